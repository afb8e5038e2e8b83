// The files that obstacles name: meshes, and tables of times and places. Collective; InputError on all ranks alike.
#pragma once

#include <cstdint>
#include <vector>

#include "io/hdf5/checkpoint.hpp"
#include "trevi/scene.hpp"

namespace trevi {

/// Reads them into the obstacles of the scene.
void read_obstacle_files(MPI_Comm comm, Scene& scene);

/// Of what has been read, for a restart to compare: of the mesh and of the table of each obstacle in turn, 0 without.
std::vector<std::int64_t> obstacle_checksums(const Scene& scene);

}  // namespace trevi
