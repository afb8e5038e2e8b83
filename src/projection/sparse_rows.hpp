// A number for few of the cells or faces of each owned row, which each thread writes for rows of its own. Not
// collective.
#pragma once

#include <algorithm>
#include <cstdint>
#include <vector>

#include "projection/grid.hpp"

namespace trevi {

class SparseRows {
 public:
  struct Entry {
    std::uint32_t number;  // of the cell or face in its row
    Real value;
  };
  /// For the planes and rows of the grid. Rows keep what they have.
  void resize(const ProjectionGrid& grid) {
    rows_of_plane_ = grid.rows();
    rows_.resize(index(grid.planes() + 1, 0));
  }
  /// Empties a row, which is then to be filled in ascending order of the numbers.
  std::vector<Entry>& begin_row(LocalId k, LocalId r) {
    rows_[index(k, r)].clear();
    return rows_[index(k, r)];
  }
  /// The value, or null without one.
  const Real* find(LocalId k, LocalId r, std::uint32_t number) const {
    const std::vector<Entry>& row = rows_[index(k, r)];
    const auto found = std::lower_bound(row.begin(), row.end(), number,
                                        [](const Entry& one, std::uint32_t of) { return one.number < of; });
    return found != row.end() && found->number == number ? &found->value : nullptr;
  }
  std::size_t bytes() const {
    std::size_t sum = rows_.capacity() * sizeof(rows_[0]);
    for (const std::vector<Entry>& row : rows_) sum += row.capacity() * sizeof(Entry);
    return sum;
  }

 private:
  std::size_t index(LocalId k, LocalId r) const {
    return static_cast<std::size_t>(k - 1) * static_cast<std::size_t>(rows_of_plane_) + static_cast<std::size_t>(r);
  }

  LocalId rows_of_plane_ = 0;
  std::vector<std::vector<Entry>> rows_;
};

}  // namespace trevi
