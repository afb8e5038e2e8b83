// Particles in cell order: sorted by (plane, row, cell, id) of their predicted positions, O(n). The order stays the
// same from the prediction to the end of a step. Owned particles are in plane order, so that a boundary plane, and the
// ghosts from a neighbouring rank, are contiguous slices: low ghosts, owned, high ghosts. Where other ranks own rows of
// the same planes, the ghosts of the row before the owned ones follow, plane by plane, and then those of the row after
// them. Rows are counted from the first owned one. Not collective: the halo provides the cell counts of ghosts.
#pragma once

#include <algorithm>
#include <array>
#include <memory>
#include <span>
#include <vector>

#include "base/range.hpp"
#include "base/scratch.hpp"
#include "particles/cell_grid.hpp"
#include "trevi/particles.hpp"

namespace trevi {

/// Whether velocities must be kept when particles are sorted. Between the prediction and the velocity update of a
/// substep they will be overwritten anyway, and CellOrder uses their array as scratch memory to sort the other fields,
/// which saves 24 bytes per particle.
enum class Velocities { preserve, discard };

class CellOrder {
 public:
  /// sort() borrows its memory from `scratch`.
  explicit CellOrder(const CellGrid& grid, std::shared_ptr<Scratch> scratch = std::make_shared<Scratch>())
      : scratch_(std::move(scratch)), grid_(grid) {}

  /// Sorts the owned particles by `predicted`, all of which must be in the window.
  void sort(Particles& particles, const CellWindow& window, Velocities velocities);

  /// Number of particles in each cell of row r of the owned plane k, counted from 1, and of the following rows, for the
  /// neighbouring ranks.
  const LocalId* counts(LocalId k, LocalId r) const {
    return counts_.data() + static_cast<std::size_t>(((k - 1) * rows() + r) * grid_.columns());
  }

  /// Number of particles in each cell of the ghost planes (empty where the box ends), and of the rows before and after
  /// the owned ones, in all planes including ghost planes (empty if no other rank has rows of the planes).
  struct GhostCounts {
    std::span<const LocalId> low{}, high{}, row_before{}, row_after{};
  };
  /// Adds the ghosts. size(), start() and owned_range() are valid only after this.
  void add_ghosts(const GhostCounts& counts);

  const CellGrid& grid() const { return grid_; }
  const CellWindow& window() const { return window_; }
  LocalId planes() const { return window_.planes.size(); }  ///< owned ones
  LocalId rows() const { return window_.rows.size(); }      ///< owned ones, of each plane
  /// Whether other ranks own rows of the same planes.
  bool rows_are_cut() const { return rows() < grid_.rows(); }
  LocalId owned() const { return owned_; }
  LocalId low_ghosts() const { return low_ghosts_; }
  LocalId high_ghosts() const { return high_ghosts_; }
  /// Number of ghosts in the rows before and after the owned ones.
  std::array<LocalId, 2> row_ghosts() const {
    return {row_start_ghosts_[0].empty() ? 0 : row_start_ghosts_[0].back() - row_start_ghosts_[0].front(),
            row_start_ghosts_[1].empty() ? 0 : row_start_ghosts_[1].back() - row_start_ghosts_[1].front()};
  }
  LocalId size() const { return low_ghosts_ + owned_ + high_ghosts_ + row_ghosts()[0] + row_ghosts()[1] + copied_; }

  /// If rows or columns are periodic, particles at one side of a plane exist a second time at the other side: as copies
  /// after all others. `turns`: along rows and columns, in lengths of the box.
  struct Copy {
    LocalId from, count, to;
    std::array<int, 2> turns;
  };
  std::span<const Copy> copies() const { return copies_; }
  /// Whether cell() knows cells beyond the ends of the owned rows: if rows or columns have copies.
  bool has_copies() const { return rows_wrap() || grid_.is_periodic(2); }
  /// Particles of row r and column c of plane k, which may be one beyond the first or the last if they are periodic.
  Range cell(LocalId k, LocalId r, LocalId c) const {
    const auto at = static_cast<std::size_t>((k * (rows() + 2) + r + 1) * (grid_.columns() + 2) + c + 1);
    return around_[at];
  }
  /// The rows beside row r whose particles are on this rank: rows of owned planes, and ghost rows if there are any.
  Range rows_beside(LocalId r) const {
    return {std::max(r - 1, row_start_ghosts_[0].empty() ? 0 : -1),
            std::min(r + 2, rows() + (row_start_ghosts_[1].empty() ? 0 : 1))};
  }
  /// Particles (indices with ghosts) of the cells [columns) of row r of plane k; -1 and rows() are the ghost rows.
  Range run(LocalId k, LocalId r, Range columns) const {
    if (r >= 0 && r < rows()) {
      const LocalId first = r * grid_.columns();
      return {start(k, first + columns.begin), start(k, first + columns.end)};
    }
    const std::vector<LocalId>& starts = row_start_ghosts_[r < 0 ? 0 : 1];
    if (starts.empty()) return {};
    const auto first = static_cast<std::size_t>(k) * static_cast<std::size_t>(grid_.columns());
    return {starts[first + static_cast<std::size_t>(columns.begin)],
            starts[first + static_cast<std::size_t>(columns.end)]};
  }
  /// All particles of such a row.
  Range row(LocalId k, LocalId r) const { return run(k, r, {0, grid_.columns()}); }

  /// First particle (index with ghosts) of cell c of plane k, where k = 0 is the low ghost plane, 1 the first owned
  /// one.
  LocalId start(LocalId k, LocalId c) const {
    return start_[static_cast<std::size_t>(k) * cells() + static_cast<std::size_t>(c)];
  }
  /// First owned particle of each row of cells of the owned planes, plane by plane, and the total number.
  std::span<const LocalId> row_starts() const { return row_start_; }
  /// Owned particles of the owned planes [k, l), counted from 0.
  Range owned_range(LocalId k, LocalId l) const;
  std::size_t bytes() const;

 private:
  struct RowScratch;
  // Of the owned rows of a plane.
  std::size_t cells() const { return static_cast<std::size_t>(rows() * grid_.columns()); }
  // Whether the rows beyond the owned ones are those at the other end.
  bool rows_wrap() const { return grid_.is_periodic(1) && !rows_are_cut(); }
  // An exact division, because a cell number has 31 bits and Real 53; faster than an integer division.
  LocalId row_of(LocalId cell) const { return static_cast<LocalId>((cell + 0.5) / grid_.columns()); }
  // What the particles are sorted by.
  struct Places {
    Borrowed<LocalId> cell;   // of each particle, before sorting
    Borrowed<LocalId> order;  // sorted index -> old index
  };
  void sort_by_rows(const Particles& particles, const Places& places);
  void sort_row(const Particles& particles, LocalId row, const Places& places, RowScratch& scratch);
  void add_plane(std::span<const LocalId> counts, LocalId first, std::size_t at);
  void add_row_ghosts(std::span<const LocalId> counts, std::size_t side);
  void add_copies();
  void add_copy(LocalId k, LocalId r, LocalId c);
  template <class T>
  void apply(const Borrowed<LocalId>& order, std::vector<T>& field, std::vector<T>& sorted) const;
  template <class T>
  void apply(const Borrowed<LocalId>& order, std::vector<T>& field) const;

  std::shared_ptr<Scratch> scratch_;
  CellGrid grid_;
  CellWindow window_;
  LocalId owned_ = 0, low_ghosts_ = 0, high_ghosts_ = 0, copied_ = 0;
  std::vector<Copy> copies_;
  std::vector<Range> around_;       // cell(), with a ring around each plane; if rows or columns are periodic
  std::vector<LocalId> counts_;     // of each owned cell
  std::vector<LocalId> start_;      // first particle of each cell of planes_ + 2 planes, and the total
  std::vector<LocalId> row_start_;  // first particle of each row of cells of the owned planes, and the total
  std::array<std::vector<LocalId>, 2> row_start_ghosts_;  // like start_, of the rows before and after the owned ones
};

}  // namespace trevi
