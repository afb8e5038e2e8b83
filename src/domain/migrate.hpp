// Sends each particle to the rank that owns its cell plane, over any distance: from slab to neighbour slab, in as many
// rounds as the particle that moved farthest has slabs to cross (nearly always none or one). The order on arrival does
// not matter, as the cell order sorts by id. Collective.
#pragma once

#include <mpi.h>

#include "domain/slabs.hpp"
#include "particles/cell_grid.hpp"
#include "trevi/particles.hpp"

namespace trevi {

/// `position` is the field that decides, &Particles::position or &Particles::predicted. Returns the number of particles
/// that this rank sent.
GlobalId migrate(MPI_Comm comm, Particles& particles, std::vector<Vec3> Particles::*position, const CellGrid& grid,
                 const Slabs& slabs);

}  // namespace trevi
