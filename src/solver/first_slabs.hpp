// How the planes are shared at the start of a run: by the number of particles in each. Collective: plane_weights.
#pragma once

#include "domain/slabs.hpp"
#include "particles/cell_grid.hpp"
#include "trevi/particles.hpp"
#include "trevi/session.hpp"
#include "trevi/settings.hpp"

namespace trevi {

/// The cells of a box, at least h wide. `settings` are resolved.
CellGrid cell_grid(const Settings& settings);

/// Particles of all ranks in each plane.
std::vector<Real> plane_weights(MPI_Comm comm, const CellGrid& grid, const Particles& particles);

/// Throws InputError for more ranks than planes, more particles or cells than a rank can count, or more unknowns than
/// PETSc can, for the method that asks it.
Slabs first_slabs(const Settings& settings, const CellGrid& grid, const std::vector<Real>& weights, int ranks);

}  // namespace trevi
