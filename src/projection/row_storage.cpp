#include "projection/row_storage.hpp"

#include <algorithm>
#include <utility>

namespace trevi {

void RowStorage::lay_out(const Shape& shape, const CellOrder& order, std::span<const LocalId> columns) {
  shape_ = shape;
  const CellRows& cells = shape_.cells;
  whole_ = static_cast<std::size_t>(cells.columns + 7) / 8;
  const std::size_t rows = row_index(cells.planes.end, -1);
  places_.resize(rows * whole_);
  held_.resize(rows * whole_);
  begin_.assign(rows, 0);
  place_whole_planes();
  for_each_row(cells, [&](LocalId k, LocalId r) { find_held(order, k, r, columns[row_index(k, r)]); });
  for_each_row(cells, [&](LocalId k, LocalId r) {
    for (std::size_t e = 0; e < whole_; ++e) begin_[row_index(k, r)] += is_needed(k, r, e) ? 1U : 0U;
  });
  find_begins();
  for_each_row(cells, [&](LocalId k, LocalId r) { place_row(k, r); });
}

// From how many eights each row needs.
void RowStorage::find_begins() {
  std::uint32_t next = nowhere_ + 1;
  std::vector<std::uint32_t> shared(static_cast<std::size_t>(shape_.window), 0);  // what a plane of them takes at most
  const auto rows_of = [&](LocalId k) {
    return std::span(begin_).subspan(row_index(k, -1), static_cast<std::size_t>(shape_.cells.rows) + 2);
  };
  for (LocalId k = 0; k < shape_.cells.planes.end; ++k) {
    std::uint32_t in_plane = 0;
    for (std::uint32_t& begin : rows_of(k)) in_plane += std::exchange(begin, is_shared(k) ? in_plane : next + in_plane);
    if (is_shared(k)) {
      std::uint32_t& most = shared[static_cast<std::size_t>(k % shape_.window)];
      most = std::max(most, in_plane);
    } else {
      next += in_plane;
    }
  }
  for (std::uint32_t& begin : shared) next += std::exchange(begin, next);
  for (LocalId k = 0; k < shape_.cells.planes.end; ++k) {
    if (!is_shared(k)) continue;
    for (std::uint32_t& begin : rows_of(k)) begin += shared[static_cast<std::size_t>(k % shape_.window)];
  }
  size_ = next;
}

void RowStorage::place_whole_planes() {
  const CellRows& cells = shape_.cells;
  nowhere_ = 0;
  for (LocalId k = 0; k < cells.planes.end; ++k) {
    if (!is_whole(k)) continue;
    const std::size_t first = row_index(k, -1) * whole_;
    for (std::size_t i = 0; i < per_plane(); ++i) places_[first + i] = nowhere_++;
  }
  whole_planes_ = nowhere_;
  for (LocalId k = 0; k < cells.planes.end; ++k) place_whole_rows(k);
  for (LocalId k = 0; k < cells.planes.end; ++k) {
    for (const LocalId r : {-1, cells.rows})
      if (!is_whole(k, r)) std::fill_n(&places_[row_index(k, r) * whole_], whole_, nowhere_);
  }
}

void RowStorage::place_whole_rows(LocalId k) {
  if (is_whole(k) || !(shape_.rows_exchanged[0] || shape_.rows_exchanged[1])) return;
  for (LocalId r = -1; r <= shape_.cells.rows; ++r) {
    for (std::size_t e = 0; e < whole_ && is_whole(k, r); ++e) places_[row_index(k, r) * whole_ + e] = nowhere_++;
  }
}

void RowStorage::find_held(const CellOrder& order, LocalId k, LocalId r, LocalId columns) {
  char* const held = &held_[row_index(k, r) * whole_];
  std::fill_n(held, whole_, 0);
  const LocalId all = shape_.cells.columns, first = r * order.grid().columns();
  for (LocalId c = 0; c < columns; ++c) {
    if (order.start(k, first + c) == order.start(k, first + c + 1)) continue;
    held[c / 8] = 1;
    for (const LocalId beside : {c - 1, c + 1}) {
      if (shape_.beside) held[(shape_.repeats[2] ? (beside + all) % all : std::clamp(beside, 0, all - 1)) / 8] = 1;
    }
  }
}

bool RowStorage::is_needed(LocalId k, LocalId r, std::size_t eight) const {
  if (is_whole(k, r)) return false;
  if (!shape_.beside) return held_[row_index(k, r) * whole_ + eight] != 0;
  const bool are_cut = shape_.rows_exchanged[0] || shape_.rows_exchanged[1];
  const LocalId rows = shape_.cells.rows, beyond = shape_.repeats[1] && !are_cut ? 1 : 0;
  for (LocalId row = std::max(r - 1, -beyond); row <= std::min(r + 1, rows - 1 + beyond); ++row)
    if (held_[row_index(k, (row + rows) % rows) * whole_ + eight] != 0) return true;
  return false;
}

void RowStorage::place_row(LocalId k, LocalId r) {
  if (is_whole(k, r)) return;
  std::uint32_t next = begin_[row_index(k, r)];
  std::uint32_t* const places = &places_[row_index(k, r) * whole_];
  for (std::size_t e = 0; e < whole_; ++e) places[e] = is_needed(k, r, e) ? next++ : nowhere_;
}

}  // namespace trevi
