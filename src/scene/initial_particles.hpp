// The particles of a scene or a checkpoint, brought to the ranks that own them. Each rank makes its own part of a
// lattice and reads its own slice of a file; no rank ever holds all particles. Collective.
#pragma once

#include "domain/slabs.hpp"
#include "io/hdf5/particle_file.hpp"
#include "particles/cell_grid.hpp"
#include "trevi/particles.hpp"
#include "trevi/scene.hpp"
#include "trevi/session.hpp"

namespace trevi {

/// The particles of a checkpoint, written on any rank count; make_solver() sends them to their owners.
Particles restored_particles(MPI_Comm comm, const Scene& scene, ParticleRows rows);

/// The slabs that initial_particles() would make, and the number of particles in each plane, without making the
/// particles of blocks, so that a scene too large for this machine can be examined. Throws as initial_particles() does.
Slabs initial_slabs(MPI_Comm comm, const Scene& scene, const CellGrid& grid, std::vector<Real>& weights);

}  // namespace trevi
