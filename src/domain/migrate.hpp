// Sends each particle to the rank that owns its cell, over any distance: to the ranks around where that is all (nearly
// always), else in one exchange of all ranks with all (send_to_owners.hpp). The order on arrival does not
// matter, as the cell order sorts by id. Collective.
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
