// The key [domain] ranks of a scene, and what of a scene depends on the number of ranks. Not collective.
#pragma once

#include "scene/scene_reader.hpp"
#include "solver/first_slabs.hpp"
#include "trevi/scene.hpp"

namespace trevi {

void read_ranks(Section& domain, Scene& scene);

/// first_slabs() for a scene: its InputErrors name the file, and the line and key that the number of ranks goes
/// against.
Slabs slabs_of(MPI_Comm comm, const Scene& scene, const CellGrid& grid, const CellWeights& weights);

}  // namespace trevi
