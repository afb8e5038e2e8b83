// The cells of the projection: those of the neighbour search (cell_grid.hpp) in the window that this rank owns, up to
// slightly above the highest cell that holds water. Directions are numbered in the order in which cells are stored: 0
// along the slab axis, 1 along the rows of a plane, 2 along the columns of a row, which is upwards. Arrays over cells
// have a ring of cells around each plane and a ghost plane on either side, so that every cell has six neighbours. The
// ring is empty, except where the box is periodic along rows or columns: there it holds copies of the cells at the
// other end. Where other ranks own rows of the same planes, it holds those rows. Face (a, at) is the lower face of the
// cell with index `at` in direction a. Not collective, except for complete().
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <vector>

#include "base/scratch.hpp"
#include "domain/halo.hpp"
#include "multigrid/cell_rows.hpp"
#include "particles/cell_grid.hpp"
#include "projection/cell_sums.hpp"
#include "projection/row_storage.hpp"
#include "trevi/box.hpp"

namespace trevi {

/// The lower or the upper face of a cell in direction a.
struct CellFace {
  std::size_t a;
  bool upper;
};

class ProjectionGrid {
 public:
  /// Arrays over cells are borrowed from `scratch`.
  ProjectionGrid(const CellGrid& grid, const Box& box, std::shared_ptr<Scratch> scratch = std::make_shared<Scratch>())
      : scratch_(std::move(scratch)),
        axis_{grid.slab_axis(), 1 - grid.slab_axis(), 2},
        count_{grid.planes(), grid.rows(), grid.columns()},
        repeats_{grid.is_periodic(0), grid.is_periodic(1), grid.is_periodic(2)},
        is_layer_(grid.is_layer()),
        own_{{0, 0}, {0, grid.rows()}} {
    for (std::size_t a = 0; a < 3; ++a) {
      const auto b = static_cast<std::size_t>(axis_[a]);
      const Real extent = box.max[axis_[a]] - box.min[axis_[a]];
      size_[static_cast<Eigen::Index>(a)] = extent / count_[a];
      origin_[b] = box.min[axis_[a]];
      per_length_[b] = grid.per_length(a);  // the same value, so that rounding gives the same cell
    }
  }

  /// Sets the window that this rank owns and the number of columns in use, at most that of the box.
  void resize(const CellWindow& own, LocalId columns) {
    own_ = own;
    columns_ = std::min(columns, count_[2]);
    step_ = {(static_cast<std::size_t>(rows()) + 2) * (static_cast<std::size_t>(columns_) + 2),
             static_cast<std::size_t>(columns_) + 2, 1};
    reach_.assign((static_cast<std::size_t>(planes()) + 2) * (static_cast<std::size_t>(rows()) + 2), columns_);
  }

  Scratch& scratch() const { return *scratch_; }

  LocalId planes() const { return own_.planes.size(); }
  /// All owned rows of some planes, for for_each_row().
  CellRows rows_of(Range planes) const { return {planes, rows(), columns_}; }
  /// The same including the ghost rows beside them, where rows are cut.
  CellRows rows_and_ghosts_of(Range planes) const {
    return rows_are_cut() ? CellRows{planes, rows() + 2, columns_, -1} : rows_of(planes);
  }
  LocalId rows() const { return own_.rows.size(); }
  const CellWindow& window() const { return own_; }
  LocalId first_plane() const { return own_.planes.begin; }
  LocalId first_row() const { return own_.rows.begin; }
  /// Whether other ranks own rows of the same planes. The ring then holds their rows.
  bool rows_are_cut() const { return rows() < count_[1]; }
  /// Whether the row before the first one is the last one on this rank.
  bool rows_wrap() const { return repeats_[1] && !rows_are_cut(); }
  /// Whether there is a row r, which may be one beyond the owned rows.
  bool has_row(LocalId r) const {
    const LocalId row = first_row() + r;
    return (r >= 0 && r < rows()) || (rows_are_cut() && (repeats_[1] || (row >= 0 && row < count_[1])));
  }
  /// The row that represents row r, which may be one beyond the owned rows.
  LocalId row_beside(LocalId r) const { return rows_wrap() ? (r + rows()) % rows() : r; }
  LocalId columns() const { return columns_; }
  /// Number of columns to be visited in row r of plane k, which may be a ghost row. There is nothing in higher columns
  /// or in those around them.
  LocalId columns(LocalId k, LocalId r) const { return reach_[row_index(k, r)]; }
  void set_columns(LocalId k, LocalId r, LocalId columns) { reach_[row_index(k, r)] = std::min(columns, columns_); }
  /// Lays out memory for the particles of `order` in those columns, once these are set for all rows, also of ghost
  /// planes.
  void store_rows(const CellOrder& order) {
    const std::array<bool, 2> cut{rows_are_cut() && has_row(-1), rows_are_cut() && has_row(rows())};
    const CellRows all = rows_of({0, planes() + 2});
    storage_.lay_out({all, {!wall_below(), !wall_above()}, repeats_, cut}, order, reach_);
    storage_beside_.lay_out({all, {}, repeats_, {}, true}, order, reach_);
    storage_rolling_.lay_out({all, {!wall_below(), !wall_above()}, repeats_, cut, false, rolling_planes() + 2}, order,
                             reach_);
  }
  const RowStorage& storage() const { return storage_; }
  /// The storage that includes the cells beside those that hold particles, without whole rows.
  const RowStorage& storage_beside() const { return storage_beside_; }
  /// The storage for fields of which only some planes are needed at a time, because planes are processed in turn.
  const RowStorage& storage_rolling() const { return storage_rolling_; }
  /// Number of planes that are then processed at a time: few, but with enough rows for all threads. It is all of them
  /// where rows are cut, because the ends of these are sent together.
  LocalId rolling_planes() const {
    constexpr LocalId rows_of_thread = 32;
    if (rows_are_cut()) return planes();
    return thread_count() == 1 ? 1 : (rows_of_thread * thread_count() + rows() - 1) / std::max(rows(), 1);
  }
  std::size_t bytes() const {
    return storage_.bytes() + storage_beside_.bytes() + storage_rolling_.bytes() + reach_.capacity() * sizeof(LocalId);
  }
  /// Edge lengths of a cell, m.
  const Vec3& size() const { return size_; }
  /// Difference of the index of a cell and that of its upper neighbour in direction a; step(0) is the number of cells
  /// in a plane.
  std::size_t step(std::size_t a) const { return step_[a]; }
  std::size_t cells() const { return (static_cast<std::size_t>(planes()) + 2) * step_[0]; }
  /// Planes are numbered from 1, rows and columns from 0.
  std::size_t index(LocalId k, LocalId r, LocalId c) const {
    return static_cast<std::size_t>(k) * step_[0] + (static_cast<std::size_t>(r) + 1) * step_[1] +
           static_cast<std::size_t>(c) + 1;
  }
  /// The plane, row and column of a cell by its index.
  std::array<LocalId, 3> cell_at(std::size_t index) const {
    return {static_cast<LocalId>(index / step_[0]), static_cast<LocalId>(index % step_[0] / step_[1]) - 1,
            static_cast<LocalId>(index % step_[1]) - 1};
  }
  /// Whether the lower face in direction a of cell (k, r, c) lies in a wall; the cell may be one past the last.
  bool is_wall(std::size_t a, LocalId k, LocalId r, LocalId c) const {
    if (a == 0) return (wall_below() && k == 1) || (wall_above() && k == planes() + 1);
    const LocalId row = first_row() + r;
    return !repeats_[a] && (a == 1 ? row == 0 || row == count_[1] : c == 0 || c == count_[2]);
  }
  /// Whether a face of cell (k, r, c) lies in a wall.
  bool is_wall(const CellFace& face, LocalId k, LocalId r, LocalId c) const {
    const auto& [a, upper] = face;
    return is_wall(a, k + (upper && a == 0), r + (upper && a == 1), c + (upper && a == 2));
  }
  /// The index of the face of a cell.
  std::size_t index_of(const CellFace& face, std::size_t cell) const { return cell + (face.upper ? step(face.a) : 0); }
  /// Whether the cell below cell (k, r, c) in direction a has an index: those below the ghost planes and rows have
  /// none.
  static bool has_below(std::size_t a, LocalId k, LocalId r) { return (a != 0 || k > 0) && (a != 1 || r >= 0); }
  /// Whether a face of the cell, which may be a ghost cell, lies in a wall along which water may move.
  bool is_at_wall(LocalId k, LocalId r, LocalId c) const {
    const std::array<LocalId, 3> cell{first_plane() - 1 + k, first_row() + r, c};
    for (std::size_t a = 0; a < 3; ++a) {
      if (repeats_[a] || (a == 1 && is_layer())) continue;
      if (cell[a] == 0 || cell[a] + 1 == count_[a]) return true;
    }
    return false;
  }
  /// Whether the box is periodic along planes, rows and columns.
  const Repeats& repeats() const { return repeats_; }
  /// Whether the grid is that of two dimensions: a single row of cells in each plane, across which nothing moves.
  bool is_layer() const { return is_layer_; }
  /// Fills the ring of cells where rows and columns are periodic on this rank.
  template <class Field>
  void repeat(Field& field) const {
    if (repeats_[2]) repeat_columns(field, columns_);
    if (rows_wrap()) repeat_rows(field, rows(), columns_);
  }
  /// The same, and the ghost rows that other ranks own. Collective.
  template <class Field>
  void complete(Halo& halo, Field& field) const {
    repeat(field);
    halo.start_rows(field, step(0));
    halo.finish();
  }

  /// The same, and the ghost planes. Collective.
  template <class Field>
  void exchange(Halo& halo, Field& field) const {
    halo.start_planes(field, step(0));
    halo.finish();
    complete(halo, field);
  }

  /// The coordinate along direction a: 0 for x.
  std::size_t axis(std::size_t a) const { return static_cast<std::size_t>(axis_[a]); }
  /// By coordinate: cells per metre.
  const std::array<Real, 3>& per_length() const { return per_length_; }
  /// The distance of p from the corner of the box along direction a, in cells.
  Real cells_to(const Vec3& p, std::size_t a) const { return (p[axis_[a]] - origin_[axis(a)]) * per_length_[axis(a)]; }
  /// The number along direction a of the cell of the box that contains p; for a particle on an upper wall, the last
  /// one.
  LocalId cell_of(const Vec3& p, std::size_t a) const {
    return std::min(static_cast<LocalId>(cells_to(p, a)), count_[a] - 1);
  }
  /// The number of a plane of the box among the owned planes, from 1; the number of a row among the owned rows, from 0.
  LocalId own_plane(LocalId plane) const { return plane - first_plane() + 1; }
  LocalId own_row(LocalId row) const { return row - first_row(); }
  /// The position of cell (k, r, c). Its corner is relative to that of the box or, along periodic axes, where positions
  /// and this difference are exact, to itself.
  CellPlace place_of(LocalId k, LocalId r, LocalId c) const {
    CellPlace place{origin_, {}};
    const std::array<LocalId, 3> cell{first_plane() - 1 + k, first_row() + r, c};
    for (std::size_t a = 0; a < 3; ++a) {
      const std::size_t b = axis(a);
      const Real corner = cell[a];
      const bool counted = !repeats_[a];
      (counted ? place.corner[b] : place.origin[b]) += counted ? corner : corner * size_[static_cast<Eigen::Index>(a)];
    }
    return place;
  }
  /// Changes the position to that of another cell of the same row.
  void set_column(CellPlace& place, LocalId c) const {
    const std::size_t b = axis(2);
    if (repeats_[2]) {
      place.origin[b] = origin_[b] + c * size_[2];
    } else {
      place.corner[b] = c;
    }
  }
  /// The lower end of the box along direction a, m.
  Real low(std::size_t a) const { return origin_[axis(a)]; }
  /// Number of cells of the box in direction a.
  LocalId count(std::size_t a) const { return count_[a]; }

 private:
  std::size_t row_index(LocalId k, LocalId r) const {
    return static_cast<std::size_t>(k) * (static_cast<std::size_t>(rows()) + 2) + static_cast<std::size_t>(r + 1);
  }
  bool wall_below() const { return own_.planes.begin == 0 && !repeats_[0]; }
  bool wall_above() const { return own_.planes.end == count_[0] && !repeats_[0]; }

  std::shared_ptr<Scratch> scratch_;
  std::array<int, 3> axis_;
  std::array<LocalId, 3> count_;  // of the box
  Repeats repeats_;
  bool is_layer_;
  CellWindow own_;
  Vec3 size_;
  std::array<Real, 3> origin_{}, per_length_{};
  LocalId columns_ = 0;
  std::array<std::size_t, 3> step_{};
  std::vector<LocalId> reach_;  // columns(k, r)
  RowStorage storage_, storage_beside_, storage_rolling_;
};

}  // namespace trevi
