// The key [domain] ranks of a scene, and what in a scene depends on the number of ranks. Not collective.
#pragma once

#include "scene/scene_reader.hpp"
#include "solver/first_slabs.hpp"
#include "trevi/scene.hpp"

namespace trevi {

void read_ranks(Section& domain, Scene& scene);

/// first_slabs() for a scene: its InputErrors give the file, and the line and key with which the number of ranks is in
/// conflict.
Slabs slabs_of(MPI_Comm comm, const Scene& scene, const CellGrid& grid, const CellWeights& weights);

}  // namespace trevi
