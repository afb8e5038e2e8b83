// How cells are counted and the planes shared at the start of a run: by the number of particles in each. Collective:
// first_cell, plane_weights.
#pragma once

#include <array>
#include <functional>
#include <vector>

#include "domain/slabs.hpp"
#include "particles/cell_grid.hpp"
#include "trevi/particles.hpp"
#include "trevi/session.hpp"
#include "trevi/settings.hpp"

namespace trevi {

/// The grid of cells, each at least h wide, over the box. `settings` are those of resolved().
CellGrid cell_grid(const Settings& settings, const Box& box);

/// Along periodic axes the cell of the box in which the particle of the least id is: counted from there, a flow that
/// starts some cells further on is the same. By coordinate; 0 along other axes.
std::array<LocalId, 3> first_cell(MPI_Comm comm, const Settings& settings, const Particles& particles);

/// Number of particles in each plane, over all ranks.
std::vector<Real> plane_weights(MPI_Comm comm, const CellGrid& grid, const Particles& particles);

/// The same in each row of each slab, slab by slab.
std::vector<Real> row_weights(MPI_Comm comm, const CellGrid& grid, const Slabs& slabs, const Particles& particles);

/// Particles of each plane, and what finds those of the rows of slabs, where these are cut inside; collective.
struct CellWeights {
  std::vector<Real> planes;
  std::function<std::vector<Real>(const Slabs&)> rows;
};
/// Throws InputError where the method anderson has more unknowns than PETSc can count. `planes`: particles of each.
void check_unknowns(const Settings& settings, const std::vector<Real>& planes);
/// Throws InputError where settings.ranks are not so many, where there are more ranks than planes and rows, more
/// particles or cells than a rank can count, or, with the method anderson, more unknowns than PETSc can count.
Slabs first_slabs(const Settings& settings, const CellGrid& grid, const CellWeights& weights, int ranks);

}  // namespace trevi
