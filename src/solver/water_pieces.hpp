// The connected pieces of the water in a substep that nothing can push along some axis: drops, jets in the air, blocks
// that are thrown, along all of them; what lies on a level floor, or in a box that repeats, along others. Particles of
// cells that share a face, an edge or a corner hang together. Nothing acts farther between particles: pairs are of
// adjacent cells, and the projection has no pressure where there are no particles. Which pieces there are does not
// depend on the ranks.
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <span>
#include <utility>
#include <vector>

#include "particles/cell_order.hpp"
#include "trevi/session.hpp"

namespace trevi {

class WaterPieces {
 public:
  /// Owned particles, counted from 0, of consecutive cells of a row.
  struct Run {
    Range particles;
    std::size_t piece;
  };
  /// By grid direction: plane, row, column.
  using Cell = std::array<LocalId, 3>;
  using Labels = Borrowed<std::int64_t>;

  /// Along which axes something may push, a bit for each.
  using Axes = unsigned char;
  static constexpr Axes all_axes = 7;

  /// Finds the pieces that are not touched along all axes. `touches` is asked of owned particles, on any thread;
  /// `exchange` brings numbers of all particles, ghosts included, from those that own them, and is called, as ranks
  /// gather what hangs together across cuts, where water ends on some rank without a wall there; these are borrowed
  /// from `scratch`. Whether there are such pieces on any rank. Collective.
  bool find(MPI_Comm comm, const CellOrder& order, Scratch& scratch, const std::function<Axes(std::size_t)>& touches,
            const std::function<void(Labels&)>& exchange);

  /// Of this rank.
  std::span<const Run> runs() const { return runs_; }
  /// Number of pieces that runs belong to. The first shared() of them lie on several ranks: all ranks have the same
  /// ones there, in the same order, whether they have particles of them or not.
  std::size_t count() const { return first_cells_.size(); }
  std::size_t shared() const { return shared_; }
  /// Of the cells of a piece in the box the first in their order.
  Cell first_cell(std::size_t piece) const { return first_cells_[piece]; }
  /// Along which axes a piece is touched.
  Axes touched(std::size_t piece) const { return touched_[piece]; }

 private:
  struct CellRun {
    Range columns, particles;  // counted with ghosts
    std::size_t number = 0;    // of own ones
  };
  // Of a piece on several ranks: the label of a part of it, the least of all, or -1 where it is touched along all axes,
  // and along which it is.
  struct Joined {
    std::int64_t label, first;
    Axes touched;
  };

  std::vector<CellRun>& row(const CellOrder& order, LocalId k, LocalId r) {
    return rows_[static_cast<std::size_t>(k * (order.rows() + 2) + r + 1)];
  }
  void find_runs(const CellOrder& order, bool ghosts);
  void join_own(const CellOrder& order);
  void join_rows(const CellOrder& order, const std::vector<CellRun>& a, const std::vector<CellRun>& b,
                 const std::function<void(const CellRun&, const CellRun&)>& join) const;
  bool find_touching(const CellOrder& order, const std::function<Axes(std::size_t)>& touches);
  using BeyondVisit = std::function<void(const CellRun& own, const CellRun& ghost, const std::array<int, 2>& ways)>;
  void visit_beyond(const CellOrder& order, const BeyondVisit& visit);
  bool find_ends(const CellOrder& order);
  using Numbers = std::vector<std::int64_t>;
  Numbers joints(const CellOrder& order, const Labels& labels);
  void join_ranks(MPI_Comm comm, const Numbers& joints);
  void find_pieces(const CellOrder& order);
  std::size_t root(std::size_t run);
  std::int64_t label(std::size_t run) { return labels_[root(run)]; }

  std::vector<std::vector<CellRun>> rows_;  // of own planes and rows, and those of ghosts around them
  std::vector<CellRun*> own_;               // runs of the own rows, in their order
  std::vector<std::size_t> parent_;         // of each own run; of a piece here the first run is the root
  Numbers labels_;              // of roots: the first cell in the box, -1 where it is touched along all axes
  std::vector<Axes> of_roots_;  // along which axes they are touched here
  std::vector<Joined> joined_;  // by their labels
  std::vector<Run> runs_;
  std::vector<Cell> first_cells_;  // of each piece
  std::vector<Axes> touched_;      // the same
  std::size_t shared_ = 0;
};

}  // namespace trevi
