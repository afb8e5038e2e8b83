// The connected pieces of the water in a substep that nothing can push along some axis. For drops, jets in the air and
// thrown blocks these are all axes; for water on a level floor or in a periodic box, some of them. Particles of cells
// that share a face, an edge or a corner are connected. Particles do not interact over longer distances: pairs are of
// adjacent cells, and the projection has no pressure where there are no particles. The pieces do not depend on the
// ranks.
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
  /// Owned particles, numbered from 0, of consecutive cells of a row.
  struct Run {
    Range particles;
    std::size_t piece;
  };
  /// By grid direction: plane, row, column.
  using Cell = std::array<LocalId, 3>;
  using Labels = Borrowed<std::int64_t>;

  /// The axes along which something may push, one bit for each.
  using Axes = unsigned char;
  static constexpr Axes all_axes = 7;

  /// Finds the pieces that are not touched along all axes, and returns whether any rank has one. `touches` is called
  /// for owned particles, on any thread. `exchange` sends the numbers of particles from their owners to the ghosts. It
  /// is called if water ends on some rank without a wall there, when ranks also gather the connections across cuts. The
  /// labels are borrowed from `scratch`. Collective.
  bool find(MPI_Comm comm, const CellOrder& order, Scratch& scratch, const std::function<Axes(std::size_t)>& touches,
            const std::function<void(Labels&)>& exchange);

  /// The runs of this rank.
  std::span<const Run> runs() const { return runs_; }
  /// Number of pieces to which the runs belong. The first shared() of them lie on several ranks. All ranks have the
  /// same shared pieces in the same order, whether or not they have particles of them.
  std::size_t count() const { return first_cells_.size(); }
  std::size_t shared() const { return shared_; }
  /// The first of the cells of a piece, in the order of the cells of the box.
  Cell first_cell(std::size_t piece) const { return first_cells_[piece]; }
  /// The axes along which a piece is touched.
  Axes touched(std::size_t piece) const { return touched_[piece]; }

 private:
  struct CellRun {
    Range columns, particles;  // including ghosts
    std::size_t number = 0;    // among the owned runs
  };
  // A part of a piece on several ranks: its label; the lowest label of the piece, or -1 if it is touched along all
  // axes; and the axes along which it is touched.
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

  std::vector<std::vector<CellRun>> rows_;  // for owned planes and rows, and for those of ghosts around them
  std::vector<CellRun*> own_;               // runs of the owned rows, in their order
  std::vector<std::size_t> parent_;         // of each owned run; the first run of a piece on this rank is the root
  Numbers labels_;                          // of roots: the first cell in the box, -1 if it is touched along all axes
  std::vector<Axes> of_roots_;              // axes along which they are touched on this rank
  std::vector<Joined> joined_;              // in the order of their labels
  std::vector<Run> runs_;
  std::vector<Cell> first_cells_;  // of each piece
  std::vector<Axes> touched_;      // the same
  std::size_t shared_ = 0;
};

}  // namespace trevi
