// The files that obstacles name: meshes, and tables of times and places. Collective; InputError on all ranks alike.
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

/// A closed surface with triangles outwards, of a file whose unit is so many metres. InputError for one that is not
/// closed or encloses nothing.
std::shared_ptr<TriangleMesh> read_mesh(MPI_Comm comm, const std::string& path, Real scale);

/// Of what has been read, for a restart to compare: of the mesh and of the table of each obstacle in turn, 0 without.
std::vector<std::int64_t> obstacle_checksums(const Scene& scene);

}  // namespace trevi
