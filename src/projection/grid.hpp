// The cells of the projection: those of the neighbour search (cell_grid.hpp) in the planes that this rank owns, up to a
// little above the highest cell that holds water. Directions are counted in the order in which cells are stored: 0
// along the slab axis, 1 along the rows of a plane, 2 along the columns of a row, which is upwards. Arrays over cells
// have a ring of cells around each plane and a ghost plane on either side, so that every cell has six neighbours; the
// ring is empty, but where the box repeats along rows or columns it holds copies of those at the other end. Face (a,
// at) is the lower face of the cell with index `at` in direction a. Not collective, except for the constructor.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "domain/slabs.hpp"
#include "multigrid/cell_rows.hpp"
#include "particles/cell_grid.hpp"
#include "projection/cell_sums.hpp"
#include "projection/row_storage.hpp"
#include "trevi/box.hpp"
#include "trevi/session.hpp"

namespace trevi {

class ProjectionGrid {
 public:
  ProjectionGrid(MPI_Comm comm, const CellGrid& grid, const Box& box)
      : axis_{grid.slab_axis(), 1 - grid.slab_axis(), 2},
        count_{grid.planes(), grid.rows(), grid.columns()},
        repeats_{grid.is_periodic(0), grid.is_periodic(1), grid.is_periodic(2)},
        is_layer_(grid.is_layer()),
        wall_below_(rank_of(comm) == 0 && !repeats_[0]),
        wall_above_(rank_of(comm) + 1 == size_of(comm) && !repeats_[0]) {
    for (std::size_t a = 0; a < 3; ++a) {
      const auto b = static_cast<std::size_t>(axis_[a]);
      const Real extent = box.max[axis_[a]] - box.min[axis_[a]];
      size_[static_cast<Eigen::Index>(a)] = extent / count_[a];
      origin_[b] = box.min[axis_[a]];
      per_length_[b] = grid.per_length(a);  // so that rounding gives the same cell
    }
  }

  /// Owned planes, and columns in use, at most those of the box. False where they stay as they are.
  bool resize(LocalId planes, LocalId columns) {
    columns = std::min(columns, count_[2]);
    if (planes == planes_ && columns == columns_) return false;
    planes_ = planes;
    columns_ = columns;
    step_ = {(static_cast<std::size_t>(rows()) + 2) * (static_cast<std::size_t>(columns_) + 2),
             static_cast<std::size_t>(columns_) + 2, 1};
    reach_.assign((static_cast<std::size_t>(planes) + 2) * static_cast<std::size_t>(rows()), columns);
    return true;
  }

  LocalId planes() const { return planes_; }
  /// All rows of some planes, to go through with for_each_row().
  CellRows rows_of(Range planes) const { return {planes, rows(), columns_}; }
  LocalId rows() const { return count_[1]; }
  LocalId columns() const { return columns_; }
  /// Columns of row r of plane k to look at: in higher ones, and in those around them, there is nothing.
  LocalId columns(LocalId k, LocalId r) const { return reach_[row_index(k, r)]; }
  void set_columns(LocalId k, LocalId r, LocalId columns) { reach_[row_index(k, r)] = std::min(columns, columns_); }
  /// Makes room for the particles of `order` in those columns, once they are set of all rows, ghost planes included.
  void store_rows(const CellOrder& order) {
    storage_.lay_out({rows_of({0, planes_ + 2}), {!wall_below_, !wall_above_}, repeats_}, order, reach_);
  }
  const RowStorage& storage() const { return storage_; }
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
    if (a == 0) return (wall_below_ && k == 1) || (wall_above_ && k == planes_ + 1);
    return !repeats_[a] && (a == 1 ? r == 0 || r == count_[1] : c == 0 || c == count_[2]);
  }
  /// Whether the box is periodic along planes, rows and columns.
  const Repeats& repeats() const { return repeats_; }
  /// Whether it is that of two dimensions, a single row of cells in each plane, which nothing moves across.
  bool is_layer() const { return is_layer_; }
  /// Fills the ring of cells where rows and columns repeat.
  template <class T>
  void repeat(std::vector<T>& field) const {
    if (repeats_[2]) repeat_columns(field, columns_);
    if (repeats_[1]) repeat_rows(field, rows(), columns_);
  }

  /// The coordinate along direction a: 0 for x.
  std::size_t axis(std::size_t a) const { return static_cast<std::size_t>(axis_[a]); }
  /// By coordinate: cells per metre.
  const std::array<Real, 3>& per_length() const { return per_length_; }
  /// The distance of p from the corner of the box along direction a, in cells.
  Real cells_to(const Vec3& p, std::size_t a) const { return (p[axis_[a]] - origin_[axis(a)]) * per_length_[axis(a)]; }
  /// The number along direction a of the cell of the box in which p is; a particle on an upper wall counts to the last.
  LocalId cell_of(const Vec3& p, std::size_t a) const {
    return std::min(static_cast<LocalId>(cells_to(p, a)), count_[a] - 1);
  }
  /// Tells that p is in plane k, which is where the other planes are counted from.
  void set_plane(LocalId k, const Vec3& p) { before_ = cell_of(p, 0) - k; }
  /// The number of a plane of the box as this rank counts its own, from 1; wrong without particles.
  LocalId own_plane(LocalId plane) const { return plane - before_; }
  /// Where cell (k, r, c) is. Its corner is counted from that of the box, or, along periodic axes, where positions and
  /// this difference are exact, from itself.
  CellPlace place_of(LocalId k, LocalId r, LocalId c) const {
    CellPlace place{origin_, {}};
    const std::array<LocalId, 3> cell{before_ + k, r, c};
    for (std::size_t a = 0; a < 3; ++a) {
      const std::size_t b = axis(a);
      const Real corner = cell[a];
      const bool counted = !repeats_[a];
      (counted ? place.corner[b] : place.origin[b]) += counted ? corner : corner * size_[static_cast<Eigen::Index>(a)];
    }
    return place;
  }
  /// The lower end of the box along direction a, m.
  Real low(std::size_t a) const { return origin_[axis(a)]; }
  /// Cells of the box in direction a.
  LocalId count(std::size_t a) const { return count_[a]; }

 private:
  std::size_t row_index(LocalId k, LocalId r) const {
    return static_cast<std::size_t>(k) * static_cast<std::size_t>(rows()) + static_cast<std::size_t>(r);
  }

  std::array<int, 3> axis_;
  std::array<LocalId, 3> count_;  // of the box
  Repeats repeats_;
  bool is_layer_;
  bool wall_below_, wall_above_;
  Vec3 size_;
  std::array<Real, 3> origin_{}, per_length_{};
  LocalId planes_ = 0, columns_ = 0;
  LocalId before_ = 0;  // the number of plane 0, the low ghost plane, from the start of the box
  std::array<std::size_t, 3> step_{};
  std::vector<LocalId> reach_;  // columns(k, r)
  RowStorage storage_;
};

}  // namespace trevi
