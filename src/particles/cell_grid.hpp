// The cells of the neighbour search: a grid over the whole box with cells at least h wide, so that neighbours are in
// the same or in adjacent cells. Cells are numbered plane by plane along the slab axis, then row by row, the vertical
// axis fastest. The numbering is global and the same on every rank, which makes the order of particles, and with it
// every sum, independent of the ranks. Lengths in metres. Not collective.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>

#include "base/range.hpp"
#include "trevi/types.hpp"

namespace trevi {

/// Whether a periodic axis may have this length: a whole number of cells that are h wide, so that it repeats exactly in
/// the units of the records, and at least three, so that no cell is adjacent to another on both sides.
inline bool is_whole_period(Real length, Real h) {
  const Real cells = std::round(length / h);
  return cells >= 3 && std::abs(length / h - cells) <= 1e-9 * cells;
}

/// A run of planes, and of rows in each of them, that a rank owns. Counted from the start of the box.
struct CellWindow {
  Range planes, rows;
};

class CellGrid {
 public:
  /// `slab_axis`: 0 for x, 1 for y. The box must be at least h wide along each axis, except along y in two dimensions,
  /// and at least three times h along `periodic` ones of x, y, z. There a position up to one box length below `min` is
  /// in the cell of its periodic image.
  CellGrid(const Vec3& min, const Vec3& max, Real h, int slab_axis, const std::array<bool, 3>& periodic = {});

  LocalId planes() const { return count_[0]; }
  LocalId rows() const { return count_[1]; }     ///< in a plane
  LocalId columns() const { return count_[2]; }  ///< in a row
  LocalId cells_per_plane() const { return count_[1] * count_[2]; }
  int slab_axis() const { return axis_[0]; }
  /// By direction: 0 for planes, 1 for rows, 2 for columns. If periodic, the first is adjacent to the last.
  bool is_periodic(std::size_t direction) const { return periodic_[direction]; }
  /// The coordinate along a direction: 0 for x.
  int axis(std::size_t direction) const { return axis_[direction]; }
  /// Number of cells along a direction.
  LocalId count(std::size_t direction) const { return count_[direction]; }
  /// Whether it is two-dimensional: a single layer of cells, thinner than h.
  bool is_layer() const { return is_layer_; }
  /// Cells per metre, as used for numbering.
  Real per_length(std::size_t direction) const { return per_length_[direction]; }
  /// Extent of the box along a direction, m.
  Real length(std::size_t direction) const { return length_[direction]; }

  LocalId plane_of(const Vec3& p) const { return index_along(0, p); }
  LocalId row_of(const Vec3& p) const { return index_along(1, p); }     ///< within its plane
  LocalId column_of(const Vec3& p) const { return index_along(2, p); }  ///< within its row
  /// Cell within its plane: row · columns + column.
  LocalId cell_in_plane(const Vec3& p) const { return row_of(p) * count_[2] + column_of(p); }

 private:
  LocalId index_along(std::size_t k, const Vec3& p) const {
    const Real offset = p[axis_[k]] - min_[axis_[k]];
    const Real cell = (offset < 0 && periodic_[k] ? offset + length_[k] : offset) * per_length_[k];
    const Real counted = std::max(0.0, std::min(cell, 2147483000.0));  // 0 if it is not a number
    return std::min(static_cast<LocalId>(counted), count_[k] - 1);
  }

  Vec3 min_;
  std::array<int, 3> axis_;  // grid direction -> coordinate
  std::array<LocalId, 3> count_;
  std::array<Real, 3> per_length_;  // cells per metre
  std::array<Real, 3> length_{};
  std::array<bool, 3> periodic_{};
  bool is_layer_ = false;
};

}  // namespace trevi
