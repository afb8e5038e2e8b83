// One level of the multigrid (multigrid.hpp): the equation
//   Σ link (phi − phi of the neighbour) + dirichlet phi = rhs
// for the cells of water in a run of planes, over the six faces of each. The Dirichlet diagonal is the sum of the links
// to where phi is 0: the free surface. Other cells have no links, and phi = 0. Columns keep their cells on all levels;
// planes and rows are joined by twos. A cell of a coarse level stands for up to four: Dirichlet diagonals, upward links
// and right-hand sides are sums over these, links sideways half of the sums, as their distance is twice as long. The
// correction of a coarse cell goes to all of its cells alike.
//
// A sweep solves each column exactly, with its neighbours as they were (line Jacobi), and is damped:
// pressure acts mostly up and down, and with whole columns nothing depends on the depth. Arrays have a ring of cells
// around each plane and a ghost plane on either side, empty but where the level repeats: there repeat() fills the ring,
// and the ghost planes of a level of which all planes are here. Not collective.
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
  LocalId first = 0;  // the first own plane, counted from the start of the box
  LocalId planes = 0, rows = 0, columns = 0;
  LocalId all_planes = 0;  // of the level, on all ranks
  Repeats repeats{};
  LocalId first_row = 0, all_rows = 0;      // as those of planes
  std::array<LocalId, 2> last_width{1, 1};  // of the last plane and the last row; of others it is `width`
  LocalId width = 1;

  std::size_t step(std::size_t a) const {
    const std::size_t row = static_cast<std::size_t>(columns) + 2;
    return a == 0 ? (static_cast<std::size_t>(rows) + 2) * row : a == 1 ? row : 1;
  }
  std::size_t cells() const { return (static_cast<std::size_t>(planes) + 2) * step(0); }
  /// Own planes are counted from 1, rows and columns from 0.
  std::size_t index(LocalId k, LocalId r, LocalId c) const {
    return static_cast<std::size_t>(k) * step(0) + (static_cast<std::size_t>(r) + 1) * step(1) +
           static_cast<std::size_t>(c) + 1;
  }
  CellRows rows_of(Range of) const { return {of, rows, columns}; }
  CellRows own_rows() const { return rows_of({1, planes + 1}); }
  bool is_whole() const { return planes == all_planes; }
  bool rows_are_cut() const { return rows != all_rows; }
  LocalId count(std::size_t a) const { return a == 0 ? all_planes : all_rows; }
  /// Twice the distance from the middle of plane or row k of all to that of the one before, in cells of the finest
  /// level.
  LocalId distance_below(std::size_t a, LocalId k) const;
  bool operator==(const LevelShape&) const = default;
};

class MultigridLevel {
 public:
  /// Without memory.
  void resize(const LevelShape& shape);
  /// The equation and phi, or what the cycles need besides; all values are 0, in memory that is borrowed until
  /// give_back().
  void borrow_equation(Scratch& scratch);
  void borrow_for_cycles(Scratch& scratch);
  /// All but phi, or that, too.
  void give_back_all_but_phi();
  void give_back();
  const LevelShape& shape() const { return shape_; }
  /// Tells that in row (k, r) only the lowest `columns` cells can hold water, others being 0; at first all can.
  void use_columns(LocalId k, LocalId r, std::size_t columns);

  /// To be called when links and Dirichlet diagonals are known: prepares the sweeps of the own planes.
  void factor();
  bool is_water(std::size_t at) const { return per_pivot[at] > 0; }

  /// Writes the next phi of rows of own planes from phi; show_next() makes it phi.
  void sweep(Range planes, Range rows, Real weight);
  void show_next() { phi.swap(next); }
  /// The same for all own planes where phi is 0 everywhere.
  void sweep_from_zero(Real weight);
  /// rhs less what phi gives, of the own planes, in `next`.
  void find_residual();

  /// Of a field whose own planes are new, and whose ghost planes have come if other ranks have them.
  void repeat(Borrowed<Real>& field) const;

  /// Links and Dirichlet diagonals of the cells `made` of `coarse`; needs those of the plane above the own ones here,
  /// and of the row after them.
  void coarsen(MultigridLevel& coarse, const CellRows& made) const;
  /// rhs of the cells `made` of `coarse` from the residual in `next`, ghosts included.
  void restrict_residual(MultigridLevel& coarse, const CellRows& made) const;
  /// Adds phi of `coarse` to phi here, ghosts included.
  void add_correction(const MultigridLevel& coarse);

  std::size_t bytes() const;

  // Of the lower faces of each cell in the three directions, 1/m².
  std::array<Borrowed<Real>, 3> link;
  Borrowed<Real> dirichlet, rhs;
  Borrowed<Real> phi, next;  // `next` is memory for what is found from phi
  Borrowed<Real> per_pivot;  // of the elimination in a column, m²; 0 outside of the water

 private:
  // The finer cells that a row of cells of a coarser level stands for: where the first of them is, and whether (1 or 0)
  // there are others in the next row and in the next plane. What repeats beyond the last one is not counted twice.
  struct Children {
    std::size_t first;
    Real rows, planes;
  };
  void borrow(std::initializer_list<Borrowed<Real>*> fields, Scratch& scratch) const;
  Children children_of(const LevelShape& coarse, LocalId k, LocalId r) const;
  Real fraction_of_link(const LevelShape& coarse, std::size_t a, LocalId k) const;
  LocalId parent_of(const LevelShape& coarse, LocalId k) const;
  LocalId parent_row_of(const LevelShape& coarse, LocalId r) const;
  // Cells of a column, from the floor up to the highest one of water.
  struct Column {
    std::size_t at, count;
  };
  struct Cells {
    std::size_t begin, end;
  };
  static constexpr std::size_t together = 4;  // columns that are solved in turns
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
  std::vector<std::size_t> used_;  // cells of each column that use_columns() has left
  std::vector<std::size_t> top_;   // of each column: cells up to the highest one of water
};

}  // namespace trevi
