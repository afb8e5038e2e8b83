// The hue that colour.by = "rainbow_x" keeps for each particle. Collective.
#pragma once

#include "trevi/particles.hpp"
#include "trevi/session.hpp"

namespace trevi {

/// Sets Particles::hue: x as a fraction of the extent of the particles of all ranks along x.
void add_hue(MPI_Comm comm, Particles& particles);

}  // namespace trevi
