// Triangle surfaces from STL, OBJ or PLY files, by VTK's readers. Rank-local. InputError names the file and what is
// wrong with it.
#pragma once

#include <string>

#include "trevi/obstacle.hpp"

namespace trevi {

/// The mesh of the file: polygons are cut into triangles, equal points merged, triangles without area left out.
TriangleMesh read_mesh_file(const std::string& path);

}  // namespace trevi
