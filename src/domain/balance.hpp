// Keeps the work of all ranks even while the water falls and spreads: now and then the cuts between slabs are moved to
// where the present weights of the planes put them. The rule sees global weights only, so every rank comes to the same
// cuts, and results do not depend on them: sums are formed plane by plane. Collective.
#pragma once

#include <mpi.h>

#include <span>

#include "domain/slabs.hpp"
#include "particles/cell_order.hpp"
#include "particles/neighbour_list.hpp"

namespace trevi {

/// Work of the owned planes [k, l) of `order` in a step, in units of a pair: pairs, and what is done for each particle.
/// Measured (falling cube and basin at rest): a particle costs as much as about twenty pairs.
Real plane_work(const CellOrder& order, const NeighbourList& list, LocalId k, LocalId l);

class Balance {
 public:
  static constexpr std::int64_t interval = 10;  ///< steps between two looks at the weights

  /// Cuts move when that lowers the imbalance by more than `least_gain`; each move sends a plane or more of particles.
  Balance(MPI_Comm comm, Real least_gain) : comm_(comm), least_gain_(least_gain) {}

  /// Moves the cuts, if it is time (step) and worth it; the particles are where they were.
  void update(std::int64_t step, const CellOrder& order, const NeighbourList& list, Slabs& slabs);

  /// Imbalance max/mean of the work at the looks so far, before a move; 1 is even.
  struct History {
    std::int64_t looks = 0, moves = 0;
    Real sum = 0, max = 1;
  };
  const History& history() const { return history_; }

 private:
  MPI_Comm comm_;
  Real least_gain_;
  History history_;
};

}  // namespace trevi
