// Load balance while the water falls and spreads: every few steps the cuts between slabs are moved according to the
// present work in the planes, and the cuts inside slabs according to that in their rows. The rule uses only global
// numbers, so every rank finds the same cuts. Results do not depend on the cuts, because sums are formed plane by
// plane. Collective.
#pragma once

#include <mpi.h>

#include <span>
#include <vector>

#include "domain/slabs.hpp"
#include "particles/cell_order.hpp"
#include "particles/neighbour_list.hpp"

namespace trevi {

/// Work of the owned planes [k, l) of `order` in a step, in units of the work for one pair: the number of pairs plus
/// the work for each particle. Measured (falling cube, basin at rest): a particle costs about as much as twenty pairs.
Real plane_work(const CellOrder& order, const NeighbourList& list, LocalId k, LocalId l);
/// The same for a range of owned particles.
Real work_of(const NeighbourList& list, Range particles);

/// Cuts each slab into `parts` runs of rows such that the largest weight of a run is as small as possible. `weights`:
/// those of the rows on the first rank of each slab, empty on other ranks. Collective.
void cut_rows(MPI_Comm comm, std::span<const Real> weights, int parts, Slabs& slabs);

class Balance {
 public:
  static constexpr std::int64_t interval = 10;  ///< steps between two measurements of the weights

  /// Cuts are moved when this lowers the imbalance by more than `min_gain`; each move sends a plane of particles or
  /// more.
  Balance(MPI_Comm comm, Real min_gain) : comm_(comm), min_gain_(min_gain) {}

  /// Moves the cuts if a measurement is due at this step and the gain is large enough. It does not move particles.
  void update(std::int64_t step, const CellOrder& order, const NeighbourList& list, Slabs& slabs);

  /// Imbalance max/mean of the work at the measurements so far, before a move; 1 is even.
  struct History {
    std::int64_t looks = 0, moves = 0;
    Real sum = 0, max = 1;
  };
  const History& history() const { return history_; }

 private:
  std::vector<Real> work_of_planes(const CellOrder& order, const NeighbourList& list, const Slabs& slabs) const;
  std::vector<Real> work_of_rows(const CellOrder& order, const NeighbourList& list, const Slabs& now,
                                 const Slabs& next) const;
  Real cut_rows(const CellOrder& order, const NeighbourList& list, const Slabs& now, Slabs& next) const;
  Real imbalance_of(Real most, Real sum, int ranks) const;

  MPI_Comm comm_;
  Real min_gain_;
  History history_;
};

}  // namespace trevi
