#include "projection/row_storage.hpp"

#include <algorithm>

namespace trevi {

// As many as the rows around reach, and one more: a tent over the last cell ends in the next one.
LocalId RowStorage::eights_of(LocalId k, LocalId r, bool rows_repeat, std::span<const LocalId> reach) const {
  const LocalId rows = shape_.rows, beyond = rows_repeat ? 1 : 0;
  LocalId most = 0;
  for (LocalId i = k - 1; i <= k + 1; ++i) {
    for (LocalId j = std::max(r - 1, -beyond); j <= std::min(r + 1, rows - 1 + beyond); ++j)
      most = std::max(most, reach[static_cast<std::size_t>(i * rows + (j + rows) % rows)]);
  }
  return (std::min(most + 1, shape_.columns) + 7) / 8;
}

bool RowStorage::lay_out(const CellRows& cells, bool rows_repeat, std::span<const LocalId> reach) {
  const bool same =
      cells.planes.end == shape_.planes.end && cells.rows == shape_.rows && cells.columns == shape_.columns;
  shape_ = cells;
  whole_ = (cells.columns + 7) / 8;
  next_.assign(index(cells.planes.end, -1), whole_);
  for_each_row({{2, std::max(2, cells.planes.end - 2)}, cells.rows, cells.columns},
               [&](LocalId k, LocalId r) { next_[index(k, r)] = eights_of(k, r, rows_repeat, reach); });
  for (LocalId k = 2; k < cells.planes.end - 2; ++k) next_[index(k, -1)] = next_[index(k, cells.rows)] = 0;
  if (same && next_ == eights_) return false;
  eights_.swap(next_);
  begin_.resize(eights_.size());
  size_ = 0;
  for (std::size_t row = 0; row < eights_.size(); ++row) {
    begin_[row] = eights_[row] > 0 ? size_ : 0;
    size_ += static_cast<std::size_t>(eights_[row]);
  }
  return true;
}

}  // namespace trevi
