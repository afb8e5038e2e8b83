// The cells of the neighbour search: a grid over the whole box with cells at least h wide, so that neighbours are in
// the same or in adjacent cells. Cells are numbered plane by plane along the slab axis, then row by row, the vertical
// axis fastest. The numbering is global and the same on every rank, which makes the order of particles, and with it
// every sum, independent of the ranks. Lengths in metres. Not collective.
#pragma once

#include <algorithm>
#include <array>

#include "trevi/types.hpp"

namespace trevi {

class CellGrid {
 public:
  /// `slab_axis`: 0 for x, 1 for y. The box must be at least h wide in each axis.
  CellGrid(const Vec3& min, const Vec3& max, Real h, int slab_axis);

  LocalId planes() const { return count_[0]; }
  LocalId rows() const { return count_[1]; }     ///< in a plane
  LocalId columns() const { return count_[2]; }  ///< in a row
  LocalId cells_per_plane() const { return count_[1] * count_[2]; }
  int slab_axis() const { return axis_[0]; }

  LocalId plane_of(const Vec3& p) const { return index_along(0, p); }
  LocalId row_of(const Vec3& p) const { return index_along(1, p); }     ///< within its plane
  LocalId column_of(const Vec3& p) const { return index_along(2, p); }  ///< within its row
  /// Cell within its plane: row · columns + column.
  LocalId cell_in_plane(const Vec3& p) const { return row_of(p) * count_[2] + column_of(p); }

 private:
  LocalId index_along(int k, const Vec3& p) const {
    const Real cell = (p[axis_[k]] - min_[axis_[k]]) * per_length_[k];
    return std::clamp(static_cast<LocalId>(std::clamp(cell, 0.0, 2147483000.0)), 0, count_[k] - 1);
  }

  Vec3 min_;
  std::array<int, 3> axis_;  // grid direction -> coordinate
  std::array<LocalId, 3> count_;
  std::array<Real, 3> per_length_;  // cells per metre
};

}  // namespace trevi
