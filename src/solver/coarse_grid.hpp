// The cells of the coarse-grid correction: those of the neighbour search (cell_grid.hpp) in the planes that this rank
// owns, up to a little above the highest cell that holds water. Directions are counted in the order in which cells are
// stored: 0 along the slab axis, 1 along the rows of a plane, 2 along the columns of a row, which is upwards. Arrays
// over cells have a ring of empty cells around each plane and a ghost plane on either side, so that every cell has six
// neighbours. Face (a, at) is the lower face of the cell with index `at` in direction a. Not collective, except for the
// constructor.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>

#include "domain/slabs.hpp"
#include "particles/cell_grid.hpp"
#include "trevi/box.hpp"
#include "trevi/session.hpp"

namespace trevi {

/// A vector for the loops over particles, as the four numbers x, y, y, z: registers hold two numbers each, and these
/// two pairs can be loaded from a Vec3 as they are.
using Axes = Eigen::Array4d;

inline Axes axes_of(const Vec3& v) {
  Axes axes;
  axes.head<2>() = v.array().head<2>();
  axes.tail<2>() = v.array().tail<2>();
  return axes;
}

class CoarseGrid {
 public:
  CoarseGrid(MPI_Comm comm, const CellGrid& grid, const Box& box)
      : axis_{grid.slab_axis(), 1 - grid.slab_axis(), 2},
        count_{grid.planes(), grid.rows(), grid.columns()},
        first_rank_(rank_of(comm) == 0),
        last_rank_(rank_of(comm) + 1 == size_of(comm)) {
    Vec3 per_length;
    for (std::size_t a = 0; a < 3; ++a) {
      const auto b = static_cast<Eigen::Index>(a);
      const Real extent = box.max[axis_[a]] - box.min[axis_[a]];
      size_[b] = extent / count_[a];
      per_length[b] = count_[a] / extent;  // the same factor as in CellGrid, so that rounding gives the same cell
    }
    origin_ = axes_of(box.min);
    per_length_ = axes_of_directions(per_length);
    last_ = axes_of_directions(Vec3(count(0), count(1), count(2))) - 1;
  }

  /// Owned planes, and columns in use, at most those of the box.
  void resize(LocalId planes, LocalId columns) {
    planes_ = planes;
    columns_ = std::min(columns, count_[2]);
    step_ = {(static_cast<std::size_t>(rows()) + 2) * (static_cast<std::size_t>(columns_) + 2),
             static_cast<std::size_t>(columns_) + 2, 1};
  }

  LocalId planes() const { return planes_; }
  LocalId rows() const { return count_[1]; }
  LocalId columns() const { return columns_; }
  /// Lengths of a cell, m.
  const Vec3& size() const { return size_; }
  /// Difference of index from a cell to its upper neighbour in direction a; step(0) is the number of cells in a plane.
  std::size_t step(std::size_t a) const { return step_[a]; }
  std::size_t cells() const { return (static_cast<std::size_t>(planes_) + 2) * step_[0]; }
  /// Planes are counted from 1, rows and columns from 0.
  std::size_t index(LocalId k, LocalId r, LocalId c) const {
    return static_cast<std::size_t>(k) * step_[0] + (static_cast<std::size_t>(r) + 1) * step_[1] +
           static_cast<std::size_t>(c) + 1;
  }
  /// Whether the lower face in direction a of cell (k, r, c) is in a wall; the cell may be one past the last.
  bool is_wall(std::size_t a, LocalId k, LocalId r, LocalId c) const {
    if (a == 0) return (first_rank_ && k == 1) || (last_rank_ && k == planes_ + 1);
    return a == 1 ? r == 0 || r == count_[1] : c == 0 || c == count_[2];
  }

  /// Where direction a is among the numbers of an Axes.
  Eigen::Index place(std::size_t a) const { return axis_[a] == 2 ? 3 : axis_[a]; }
  /// What has the value by_direction[a] in direction a.
  Axes axes_of_directions(const Vec3& by_direction) const {
    Vec3 v;
    for (std::size_t a = 0; a < 3; ++a) v[axis_[a]] = by_direction[static_cast<Eigen::Index>(a)];
    return axes_of(v);
  }
  /// A vector in units of cells.
  Axes way_in_cells(const Axes& way) const { return way * per_length_; }
  /// A position in units of cells, counted from the corner of the box.
  Axes in_cells(const Vec3& p) const { return (axes_of(p) - origin_) * per_length_; }
  /// Number of the cell in which a position is; a particle on an upper wall counts to the last cell.
  Axes cell_of(const Axes& in_cells) const { return in_cells.floor().min(last_); }
  /// Position of a particle within its cell, 0 at the lower face and 1 at the upper one.
  Axes fraction(const Axes& in_cells) const { return (in_cells - cell_of(in_cells)).max(0.0).min(1.0); }
  Real count(std::size_t a) const { return count_[a]; }

 private:
  std::array<int, 3> axis_;
  std::array<LocalId, 3> count_;  // of the box
  bool first_rank_, last_rank_;
  Vec3 size_;
  Axes origin_, per_length_, last_;
  LocalId planes_ = 0, columns_ = 0;
  std::array<std::size_t, 3> step_{};
};

}  // namespace trevi
