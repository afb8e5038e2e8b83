// Surfaces of triangles from STL, OBJ or PLY files, by VTK's readers. Rank-local. InputError names the file and what is
// wrong with it.
#pragma once

#include <string>

#include "trevi/obstacle.hpp"

namespace trevi {

/// As it stands in the file: polygons cut to triangles, equal points joined, triangles without area left out.
TriangleMesh read_mesh_file(const std::string& path);

}  // namespace trevi
