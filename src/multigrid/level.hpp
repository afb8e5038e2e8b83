// One level of the multigrid (multigrid.hpp): the equation
//   Σ link (phi − phi of the neighbour) + dirichlet phi = rhs
// for the water cells in a run of planes, over the six faces of each cell. The Dirichlet diagonal is the sum of the
// links to points where phi is 0: the free surface. Other cells have no links, and phi = 0. Columns keep their cells on
// all levels; planes and rows are coarsened by two. A coarse cell represents up to four finer ones. Its Dirichlet
// diagonal, upward link and right-hand side are sums over these; its horizontal links are half of the sums, because
// their distance is doubled. The correction of a coarse cell is added to all of its cells. An opening between solids is
// a link so weak that phi jumps there and hardly changes on its two sides: it keeps its strength on coarser levels.
// Halved on each of them, such links gave corrections several times too large, and phi of water in a pocket grew from
// cycle to cycle.
//
// A sweep solves each column exactly, with the previous values of its neighbours (line Jacobi), and is damped. Pressure
// acts mostly in the vertical direction, and with whole columns nothing depends on the depth. Arrays have a ring of
// cells around each plane and a ghost plane on either side, which are empty except where the level is periodic. There
// repeat() fills the ring, and the ghost planes of a level whose planes are all on this rank. Not collective.
#pragma once

#include <array>
#include <initializer_list>
#include <span>
#include <vector>

#include "base/scratch.hpp"
#include "multigrid/cell_rows.hpp"
#include "trevi/types.hpp"

namespace trevi {

struct LevelShape {
  LocalId first = 0;  // the first owned plane, counted from the start of the box
  LocalId planes = 0, rows = 0, columns = 0;
  LocalId all_planes = 0;  // of the level, on all ranks
  Repeats repeats{};
  LocalId first_row = 0, all_rows = 0;      // the same for rows
  std::array<LocalId, 2> last_width{1, 1};  // of the last plane and the last row; that of others is `width`
  LocalId width = 1;

  std::size_t step(std::size_t a) const {
    const std::size_t row = static_cast<std::size_t>(columns) + 2;
    return a == 0 ? (static_cast<std::size_t>(rows) + 2) * row : a == 1 ? row : 1;
  }
  std::size_t cells() const { return (static_cast<std::size_t>(planes) + 2) * step(0); }
  /// Owned planes are numbered from 1, rows and columns from 0.
  std::size_t index(LocalId k, LocalId r, LocalId c) const {
    return static_cast<std::size_t>(k) * step(0) + (static_cast<std::size_t>(r) + 1) * step(1) +
           static_cast<std::size_t>(c) + 1;
  }
  CellRows rows_of(Range of) const { return {of, rows, columns}; }
  CellRows own_rows() const { return rows_of({1, planes + 1}); }
  bool is_whole() const { return planes == all_planes; }
  bool rows_are_cut() const { return rows != all_rows; }
  LocalId count(std::size_t a) const { return a == 0 ? all_planes : all_rows; }
  /// Twice the distance between the centres of plane or row k, of all of them, and of the one before it, in cells of
  /// the finest level.
  LocalId distance_below(std::size_t a, LocalId k) const;
  bool operator==(const LevelShape&) const = default;
};

class MultigridLevel {
 public:
  /// Sets the shape; borrows no memory.
  void resize(const LevelShape& shape);
  /// Borrow the equation and phi, and the other fields that the cycles need. All values are 0; the memory is borrowed
  /// until give_back().
  void borrow_equation(Scratch& scratch);
  void borrow_for_cycles(Scratch& scratch);
  /// Give back everything except phi, and everything.
  void give_back_all_but_phi();
  void give_back();
  const LevelShape& shape() const { return shape_; }
  /// Restricts row (k, r) to the lowest `columns` cells, which alone can hold water; others are 0. At first all can.
  void use_columns(LocalId k, LocalId r, std::size_t columns);

  /// To be called when links and Dirichlet diagonals are known: prepares the sweeps of the owned planes.
  void factor();
  bool is_water(std::size_t at) const { return per_pivot[at] > 0; }

  /// Computes the next phi of rows of owned planes from phi; show_next() makes it phi.
  void sweep(Range planes, Range rows, Real weight);
  void show_next() { phi.swap(next); }
  /// The same for all owned planes if phi is 0 everywhere.
  void sweep_from_zero(Real weight);
  /// Computes the residual of the owned planes, in `next`.
  void find_residual();

  /// Fills the periodic cells of a field whose owned planes are new, and whose ghost planes have been received if other
  /// ranks own them.
  void repeat(Borrowed<Real>& field) const;

  /// Computes links and Dirichlet diagonals of the cells `made` of `coarse`. Needs those of the plane above the owned
  /// planes of this level, and of the row after the owned rows; among solids also the links of the plane below and of
  /// the row before.
  void coarsen(MultigridLevel& coarse, const CellRows& made, bool among_solids) const;
  /// Computes rhs of the cells `made` of `coarse` from the residual in `next`, ghosts included.
  void restrict_residual(MultigridLevel& coarse, const CellRows& made) const;
  /// Adds phi of `coarse` to phi of this level, ghosts included.
  void add_correction(const MultigridLevel& coarse);

  std::size_t bytes() const;

  // The links of the lower faces of each cell in the three directions, 1/m².
  std::array<Borrowed<Real>, 3> link;
  Borrowed<Real> dirichlet, rhs;
  Borrowed<Real> phi, next;  // `next` is memory for what is computed from phi
  Borrowed<Real> per_pivot;  // 1 over the pivot of the elimination in a column, m²; 0 outside the water

 private:
  // The finer cells that a row of coarse cells represents: the index of the first of them, and whether (1 or 0) there
  // are others in the next row and in the next plane. Periodic copies beyond the last one are not counted twice.
  struct Children {
    std::size_t first;
    Real rows, planes;
  };
  void borrow(std::initializer_list<Borrowed<Real>*> fields, Scratch& scratch) const;
  Children children_of(const LevelShape& coarse, LocalId k, LocalId r) const;
  Real fraction_of_link(const LevelShape& coarse, std::size_t a, LocalId k) const;
  LocalId parent_of(const LevelShape& coarse, LocalId k) const;
  LocalId parent_row_of(const LevelShape& coarse, LocalId r) const;
  // Cells of a column, from the floor up to the highest water cell.
  struct Column {
    std::size_t at, count;
  };
  struct Cells {
    std::size_t begin, end;
  };
  static constexpr std::size_t together = 4;  // number of columns that are solved in an interleaved manner
  std::size_t row_index(LocalId k, LocalId r) const {
    return static_cast<std::size_t>(k) * static_cast<std::size_t>(shape_.rows) + static_cast<std::size_t>(r);
  }
  std::size_t top(LocalId k, LocalId r) const { return top_[row_index(k, r)]; }
  std::size_t used(LocalId k, LocalId r) const { return used_[row_index(k, r)]; }
  void factor_column(LocalId k, LocalId r);
  void gather_column(const Column& column);
  void solve_columns(std::span<const Column> columns);
  template <std::size_t n>
  void eliminate(const std::array<Column, n>& columns, Cells cells, std::array<Real, n>& last);
  template <std::size_t n>
  void substitute(const std::array<Column, n>& columns, Cells cells, std::array<Real, n>& last);
  template <class Make, class Finish>
  void solve_rows(Range planes, Range rows, const Make& make, const Finish& finish);

  LevelShape shape_;
  std::vector<std::size_t> used_;  // number of cells of each column to which use_columns() has restricted it
  std::vector<std::size_t> top_;   // number of cells of each column up to the highest water cell
};

}  // namespace trevi
