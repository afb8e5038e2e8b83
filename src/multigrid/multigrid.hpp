// Multigrid for the pressure of the projection: a fixed number of V-cycles over levels that coarsen columns of cells by
// two in both horizontal directions (level.hpp). As a sweep solves whole columns, the number of cycles, of sweeps and
// of messages does not depend on the depth. On a level whose columns are wider than the depth of the water, the
// pressure is determined almost entirely within a column, so the number of levels follows from the depth and not from
// the extent of the water.
//
// Nothing here depends on the ranks: planes and rows of levels are counted from the start of the box, each cell has one
// formula, and no sum extends over more than the cells that a coarse cell represents. A level with few cells is
// gathered to all ranks in the order of its planes, and each rank computes it and all coarser levels. On finer levels
// ranks hold the cells that begin in their window (cell_peers.hpp). Collective.
#pragma once

#include <initializer_list>
#include <memory>

#include "domain/halo.hpp"
#include "multigrid/level.hpp"

namespace trevi {

class Multigrid {
 public:
  static constexpr GlobalId few_cells = 4096;
  /// A level of at most `gathered_cells` cells in all is gathered.
  explicit Multigrid(MPI_Comm comm, const Repeats& repeats = {}, GlobalId gathered_cells = few_cells,
                     std::shared_ptr<Scratch> scratch = std::make_shared<Scratch>())
      : scratch_(std::move(scratch)), comm_(comm), repeats_(repeats), gathered_(gathered_cells) {}

  /// Sets the levels for this rank's window in planes of `rows` x `columns` cells; `depth` of the water in cells. Not
  /// collective.
  void resize(const CellCuts& cuts, LocalId rows, LocalId columns, int depth);
  /// Holds the equation and the initial guess phi with its ghost planes. Links are also known in the plane above the
  /// owned ones. Where the box is periodic, halo exchanges are those of a ring.
  MultigridLevel& finest() { return levels_.front().cells; }
  const MultigridLevel& finest() const { return levels_.front().cells; }

  /// Give back the memory of everything except phi of the finest level, and the memory of this phi.
  void give_back_all_but_phi();
  void give_back() { levels_[0].cells.give_back(); }

  /// Improves phi of the finest level, ghost planes included, in memory that give_back_all_but_phi() gives back.
  /// `among_solids`: whether links may be weak compared with those around them, as in the openings that solids leave.
  void solve(Halo& halo, int cycles, bool among_solids = false);
  /// The same once more if nothing but the right-hand side has changed.
  void improve(Halo& halo, int cycles);

  std::size_t bytes() const;

 private:
  struct Level {
    MultigridLevel cells;
    CellPeers peers;
    CellRows made{};        // cells that this rank computes from the finer level
    bool gathered = false;  // all cells are on all ranks
  };
  void place_level(std::size_t l, bool same_cuts);
  CellWindow own_window(std::size_t l) const;
  void exchange(Level& level, Halo& halo, Borrowed<Real>& field) const;
  bool is_gathered_here(std::size_t l) const { return l > 0 && levels_[l].gathered && !levels_[l - 1].gathered; }
  void join_levels(Halo& halo, bool among_solids);
  void complete(std::size_t l, std::initializer_list<Borrowed<Real>*> fields, Halo& halo);
  void gather(std::size_t l, std::initializer_list<Borrowed<Real>*> fields);
  void cycle(Halo& halo);
  void show_next(Level& level, Halo& halo) const;
  void sweep(Level& level, Halo& halo, Real weight) const;
  void sweep_from_zero(Level& level, Halo& halo, Real weight) const;
  void sweep_coarsest(Halo& halo);

  std::shared_ptr<Scratch> scratch_;
  MPI_Comm comm_;
  Repeats repeats_;
  GlobalId gathered_;
  CellCuts cuts_;  // of the finest level
  LocalId all_rows_ = 0;
  std::vector<Level> levels_ = std::vector<Level>(1);
};

}  // namespace trevi
