// How the planes are shared at the start of a run: by the number of particles in each. Collective: plane_weights.
#pragma once

#include "domain/slabs.hpp"
#include "particles/cell_grid.hpp"
#include "trevi/particles.hpp"
#include "trevi/session.hpp"
#include "trevi/settings.hpp"

namespace trevi {

/// The grid of cells, each at least h wide, over the box. `settings` are those of resolved().
CellGrid cell_grid(const Settings& settings);

/// Number of particles in each plane, over all ranks.
std::vector<Real> plane_weights(MPI_Comm comm, const CellGrid& grid, const Particles& particles);

/// Throws InputError where there are more ranks than planes, more particles or cells than a rank can count, or, with
/// the method anderson, more unknowns than PETSc can count.
Slabs first_slabs(const Settings& settings, const CellGrid& grid, const std::vector<Real>& weights, int ranks);

}  // namespace trevi
