// Sends each particle to the rank that owns its cell plane, over any distance: hand to hand between neighbour slabs, as
// many rounds as the farthest traveller has slabs to cross (nearly always none or one). The order on arrival is of no
// account, as the cell order sorts by id. Collective.
#pragma once

#include <mpi.h>

#include "domain/slabs.hpp"
#include "particles/cell_grid.hpp"
#include "trevi/particles.hpp"

namespace trevi {

/// `position` is the field that decides, &Particles::position or &Particles::predicted. Returns the particles this rank
/// sent.
GlobalId migrate(MPI_Comm comm, Particles& particles, std::vector<Vec3> Particles::*position, const CellGrid& grid,
                 const Slabs& slabs);

}  // namespace trevi
