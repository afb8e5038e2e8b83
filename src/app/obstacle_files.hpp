// The files that obstacles name: meshes, and tables of times and places. Collective; InputError on all ranks alike.
#pragma once

#include <cstdint>
#include <vector>

#include "io/checkpoint.hpp"
#include "trevi/scene.hpp"

namespace trevi {

/// Reads them into the obstacles of the scene.
void read_obstacle_files(MPI_Comm comm, Scene& scene);

/// Of what has been read, one for each obstacle, for a restart to compare.
std::vector<std::int64_t> obstacle_checksums(const Scene& scene);
/// InputError where the run had another mesh or another motion of the same name. Not collective.
void check_obstacle_files(const CheckpointInfo& info, const std::string& checkpoint_path, const Scene& scene);

}  // namespace trevi
