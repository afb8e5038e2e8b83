// Sums over particles that do not depend on the ranks: the particles of a plane are added in their order, then the
// planes in theirs (parallel/reductions.hpp). Where slabs are cut inside, the sums of the planes of a slab pass through
// its ranks in the order of their rows, and each rank continues where the previous one stopped. Collective.
#pragma once

#include <mpi.h>

#include <type_traits>
#include <vector>

#include "base/threads.hpp"
#include "parallel/reductions.hpp"
#include "parallel/waiting.hpp"
#include "particles/cell_order.hpp"
#include "trevi/session.hpp"

namespace trevi {

/// add(sums, particles) adds the owned particles of a range to `sums`; Sums::for_each(visit) calls visit(number) for
/// each of them.
template <class Sums, class Add>
Sums sum_over_planes(MPI_Comm comm, const CellOrder& order, const Add& add) {
  static_assert(std::is_trivially_copyable_v<Sums> || std::is_standard_layout_v<Sums>);
  std::vector<Sums> sums(static_cast<std::size_t>(order.planes()));
  const int bytes = static_cast<int>(sums.size() * sizeof(Sums)), rank = rank_of(comm);
  MPI_Request request;
  if (order.window().rows.begin > 0) {
    MPI_Irecv(sums.data(), bytes, MPI_BYTE, rank - 1, 0, comm, &request);
    wait_all({&request, 1});
  }
  for_each_part(order.planes(), [&](LocalId plane) {
    add(sums[static_cast<std::size_t>(plane)], order.owned_range(plane, plane + 1));
  });
  const bool passes_on = order.window().rows.end < order.grid().rows();
  if (passes_on) {
    MPI_Isend(sums.data(), bytes, MPI_BYTE, rank + 1, 0, comm, &request);
    wait_all({&request, 1});
    sums.clear();
  }
  return sum_over_planes(comm, sums);
}

}  // namespace trevi
