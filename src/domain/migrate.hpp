// Sends each particle to the rank that owns its cell, over any distance: to the surrounding ranks if these suffice
// (nearly always), otherwise in one all-to-all exchange (send_to_owners.hpp). The order on arrival does not matter,
// because the cell order sorts by id. Collective.
#pragma once

#include <mpi.h>

#include "domain/slabs.hpp"
#include "particles/cell_grid.hpp"
#include "trevi/particles.hpp"

namespace trevi {

/// `position` is the field that determines the owner, &Particles::position or &Particles::predicted. Returns the number
/// of particles that this rank sent.
GlobalId migrate(MPI_Comm comm, Particles& particles, std::vector<Vec3> Particles::*position, const CellGrid& grid,
                 const Slabs& slabs);

}  // namespace trevi
