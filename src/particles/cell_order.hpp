// Particles in cell order: sorted by (plane, row, cell, id) of their predicted positions, O(n).
// The order stays the same from the prediction to the end of a step. Owned particles of the planes [first, last) are in
// plane order, so that a boundary plane, and the ghosts from a neighbour rank, are contiguous slices: low ghosts,
// owned, high ghosts. Not collective: the halo provides the cell counts of the ghost planes.
#pragma once

#include <array>
#include <span>
#include <tuple>
#include <vector>

#include "base/range.hpp"
#include "particles/cell_grid.hpp"
#include "trevi/particles.hpp"

namespace trevi {

/// Cell planes [first, last).
struct Planes {
  LocalId first = 0, last = 0;
};

/// Whether velocities must be kept when particles are sorted. Between the prediction and the velocity update of a
/// substep they will be overwritten anyway, and CellOrder (nothing else may) uses their array as scratch memory to sort
/// the other fields, which saves 24 bytes a particle.
enum class Velocities { preserve, discard };

class CellOrder {
 public:
  explicit CellOrder(const CellGrid& grid) : grid_(grid) {}

  /// Sorts the owned particles by `predicted`, all of which must be in the planes.
  void sort(Particles& particles, const Planes& planes, Velocities velocities);

  /// Particles in each cell of the first and the last owned plane, for the neighbour ranks.
  std::span<const LocalId> first_plane_counts() const;
  std::span<const LocalId> high_plane_counts() const;

  /// Adds the ghost planes (empty spans where the box ends). size(), start() and owned_range() are valid only after
  /// this.
  void add_ghosts(std::span<const LocalId> low_counts, std::span<const LocalId> high_counts);

  const CellGrid& grid() const { return grid_; }
  LocalId planes() const { return planes_; }  ///< owned ones
  LocalId owned() const { return owned_; }
  LocalId low_ghosts() const { return low_ghosts_; }
  LocalId high_ghosts() const { return high_ghosts_; }
  LocalId size() const { return low_ghosts_ + owned_ + high_ghosts_ + copied_; }

  /// Where rows or columns are periodic, particles at one side of a plane are there once more, at the other one: as
  /// copies behind all others. `turns`: along rows and columns, in lengths of the box.
  struct Copy {
    LocalId from, count, to;
    std::array<int, 2> turns;
  };
  std::span<const Copy> copies() const { return copies_; }
  /// Particles of row r and column c of plane k, which may be one beyond the first or the last where they are periodic.
  Range cell(LocalId k, LocalId r, LocalId c) const {
    const auto at = static_cast<std::size_t>((k * (grid_.rows() + 2) + r + 1) * (grid_.columns() + 2) + c + 1);
    return around_[at];
  }

  /// First particle (index with ghosts) of cell c of plane k, where k = 0 is the low ghost plane, 1 the first owned
  /// one.
  LocalId start(LocalId k, LocalId c) const {
    return start_[static_cast<std::size_t>(k) * cells() + static_cast<std::size_t>(c)];
  }
  /// First owned particle of each row of cells of the owned planes, plane by plane, and the number of all.
  std::span<const LocalId> row_starts() const { return row_start_; }
  /// Owned particles of the owned planes [k, l) counted from 0.
  Range owned_range(LocalId k, LocalId l) const;
  std::size_t bytes() const;

 private:
  struct RowScratch;
  std::size_t cells() const { return static_cast<std::size_t>(grid_.cells_per_plane()); }
  // A division that is exact, as a cell has 31 bits and Real 53, and faster than one of integers.
  LocalId row_of(LocalId cell) const { return static_cast<LocalId>((cell + 0.5) / grid_.columns()); }
  void sort_by_rows(const Particles& particles, LocalId first);
  void sort_row(const Particles& particles, LocalId row, RowScratch& scratch);
  void add_plane(std::span<const LocalId> counts, LocalId first, std::size_t at);
  void add_copies();
  void add_copy(LocalId k, LocalId r, LocalId c);
  template <class T>
  void apply(std::vector<T>& field, std::vector<T>& scratch) const;

  CellGrid grid_;
  LocalId planes_ = 0, owned_ = 0, low_ghosts_ = 0, high_ghosts_ = 0, copied_ = 0;
  std::vector<Copy> copies_;
  std::vector<Range> around_;       // cell(), with a ring around each plane; where rows or columns are periodic
  std::vector<LocalId> counts_;     // of each owned cell
  std::vector<LocalId> start_;      // first particle of each cell of planes_ + 2 planes, and the total
  std::vector<LocalId> row_start_;  // first particle of each row of cells of the owned planes, and the total
  std::vector<LocalId> cell_;       // of each particle, before sorting
  std::vector<LocalId> order_;      // sorted index -> old index
  std::tuple<std::vector<GlobalId>, std::vector<float>> scratch_;
};

}  // namespace trevi
