// Sends particles to their owners over any distance in one exchange of all ranks with all, where migrate() would pass
// them on from slab to slab: a restart, whose particles come in the order of their ids, and what else is far from home.
// Each field goes by itself, straight to where it stays, so a rank receives what it will own and no more, and the
// memory beside the particles is that of what leaves, for one field. Counts are of particles, so no number of bytes has
// to fit into an int. Collective.
#pragma once

#include <mpi.h>

#include <span>
#include <vector>

#include "trevi/particles.hpp"

namespace trevi {

/// `owners[i]` is the rank that owns particle i. Those that stay keep their order and come first; the others follow by
/// the rank that sent them. Returns the number of particles that this rank sent.
GlobalId send_to_owners(MPI_Comm comm, Particles& particles, std::span<const int> owners);

}  // namespace trevi
