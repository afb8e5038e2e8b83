// The particles of a scene or a checkpoint, brought to the ranks that own them. Each rank makes its own part of a
// lattice and reads its own slice of a file; nobody ever holds them all. Collective.
#pragma once

#include "domain/slabs.hpp"
#include "io/particle_file.hpp"
#include "particles/cell_grid.hpp"
#include "trevi/particles.hpp"
#include "trevi/scene.hpp"
#include "trevi/session.hpp"

namespace trevi {

/// Those of a checkpoint, whatever rank count wrote it; make_solver() brings them home.
Particles restored_particles(MPI_Comm comm, const Scene& scene, ParticleRows rows);

/// The slabs that initial_particles() would make, and the particles in each plane, without making those of blocks: a
/// scene too large for this machine can be looked at. Throws as it does.
Slabs initial_slabs(MPI_Comm comm, const Scene& scene, const CellGrid& grid, std::vector<Real>& weights);

}  // namespace trevi
