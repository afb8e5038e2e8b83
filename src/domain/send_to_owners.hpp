// Sends particles to their owners over any distance in one all-to-all exchange, where migrate() would pass them on from
// slab to slab: at a restart, whose particles come in the order of their ids, and for other particles that are far from
// their owners. Each field is sent separately and directly to its destination, so a rank receives only what it will
// own. The memory needed besides the particles is that of one field of those that leave. Counts are of particles, so
// that no number of bytes has to fit into an int. Collective.
#pragma once

#include <mpi.h>

#include <span>
#include <vector>

#include "trevi/particles.hpp"

namespace trevi {

/// `owners[i]` is the rank that owns particle i. Particles that stay keep their order and come first; the others follow
/// in the order of the ranks that sent them. Returns the number of particles that this rank sent.
GlobalId send_to_owners(MPI_Comm comm, Particles& particles, std::span<const int> owners);

}  // namespace trevi
