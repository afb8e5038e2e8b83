// The files that obstacles refer to: meshes, and tables of times and positions. Collective; InputError on all ranks
// alike.
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "io/hdf5/checkpoint.hpp"
#include "trevi/scene.hpp"

namespace trevi {

/// Reads them into the obstacles of the scene.
void read_obstacle_files(MPI_Comm comm, Scene& scene);

/// A closed surface with triangles facing outwards, from a file whose unit is given in metres. InputError if it is not
/// closed or encloses nothing.
std::shared_ptr<TriangleMesh> read_mesh(MPI_Comm comm, const std::string& path, Real scale);

/// Checksums of what has been read, for a restart to compare: of the mesh and of the table of each obstacle in turn, 0
/// without one.
std::vector<std::int64_t> obstacle_checksums(const Scene& scene);

}  // namespace trevi
