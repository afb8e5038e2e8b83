// The numbering of cells and the distribution of planes at the start of a run, by the number of particles in each.
// Collective: first_cell, plane_weights, first_slabs.
#pragma once

#include <array>
#include <functional>
#include <map>
#include <vector>

#include "domain/slabs.hpp"
#include "particles/cell_grid.hpp"
#include "trevi/particles.hpp"
#include "trevi/session.hpp"
#include "trevi/settings.hpp"

namespace trevi {

/// The grid of cells, each at least h wide, over the box. `settings` are those of resolved().
CellGrid cell_grid(const Settings& settings, const Box& box);

/// Along periodic axes the cell of the box that contains the particle with the lowest id. Cells are counted from there,
/// so that a flow that starts some cells further on is the same. By coordinate; 0 along other axes.
std::array<LocalId, 3> first_cell(MPI_Comm comm, const Settings& settings, const Particles& particles);

/// Number of particles in each plane, over all ranks.
std::vector<Real> plane_weights(MPI_Comm comm, const CellGrid& grid, const Particles& particles);

/// The number of particles in each row of a slab, for the slabs of which a rank knows any, by the number of the slab.
using RowWeights = std::map<int, std::vector<Real>>;
/// Adds the particles of this rank. Not collective.
void add_row_weights(const CellGrid& grid, const Slabs& slabs, const Particles& particles, RowWeights& weights);

/// The number of particles of each plane on all ranks, and a function that finds those in rows which this rank knows,
/// where slabs are cut inside; each particle counts on one rank. No rank has the numbers of all rows of all slabs.
/// Collective.
struct CellWeights {
  std::vector<Real> planes;
  std::function<RowWeights(const Slabs&)> rows;
};
/// Throws InputError if the method anderson has more unknowns than PETSc can count. `planes`: particles of each plane.
void check_unknowns(const Settings& settings, const std::vector<Real>& planes);
/// Bytes per particle of a plane at a cut in the largest message: its record, or with the projection its part of the
/// data that a full cell sends.
Real bytes_of_particle(const Settings& settings, const CellGrid& grid);
/// Throws InputError if settings.ranks does not match the number of ranks, if there are more ranks than planes and
/// rows, more particles or cells than a rank can count, or, with the method anderson, more unknowns than PETSc can
/// count.
Slabs first_slabs(MPI_Comm comm, const Settings& settings, const CellGrid& grid, const CellWeights& weights);

}  // namespace trevi
