// Who exchanges planes with whom on the levels of a multigrid. Planes 2m and 2m + 1 of a level are plane m of the next
// one, counted from the start of the box, so that levels do not depend on the ranks; who owns plane 2m owns plane m. On
// coarse levels ranks are left without a plane of their own. One that still had planes on the level before takes part:
// it receives the two planes around the place where its own would be. Not collective.
#pragma once

#include <mpi.h>

#include <array>
#include <span>

#include "trevi/session.hpp"
#include "trevi/types.hpp"

namespace trevi {

/// Ranks, or MPI_PROC_NULL; 0 is the low side, 1 the high one.
struct PlanePeers {
  std::array<int, 2> from{MPI_PROC_NULL, MPI_PROC_NULL};  // owners of the planes beside the own ones
  // Who needs the own first and the own last plane: the next owner of planes, and one without planes before it.
  std::array<std::array<int, 2>, 2> to{from, from};
};

/// The ranks with the slabs below and above; in a ring the first is next to the last.
inline std::array<int, 2> slab_neighbours(MPI_Comm comm, bool ring) {
  const int rank = rank_of(comm), last = size_of(comm) - 1;
  const int before_first = ring ? last : MPI_PROC_NULL, after_last = ring ? 0 : MPI_PROC_NULL;
  return {rank > 0 ? rank - 1 : before_first, rank < last ? rank + 1 : after_last};
}

/// The part of an exchange that goes to the low side.
inline PlanePeers downwards(const PlanePeers& peers) {
  PlanePeers down;
  down.from[1] = peers.from[1];
  down.to[0] = peers.to[0];
  return down;
}

/// The plane of `level` that begins at plane `plane` of level 0, or the first above it.
inline LocalId first_on_level(LocalId plane, int level) {
  return static_cast<LocalId>((GlobalId{plane} + (GlobalId{1} << level) - 1) >> level);
}

/// `cuts`: the first plane of each rank on level 0, and one past the last of all. In a ring the first plane is next to
/// the last.
PlanePeers peers_on_level(std::span<const LocalId> cuts, int rank, int level, bool ring);

}  // namespace trevi
