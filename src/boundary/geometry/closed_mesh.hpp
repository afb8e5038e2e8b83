// Whether a mesh is the surface of a solid: only then is there an inside. Not collective.
#pragma once

#include <string>

#include "trevi/obstacle.hpp"

namespace trevi {

/// What is wrong with a mesh and where; empty when each edge is that of two triangles which are oriented consistently.
std::string why_not_closed(const TriangleMesh& mesh);

/// Whether it encloses next to nothing for its size: two triangles back to back are closed, too.
bool is_flat(const TriangleMesh& mesh);

/// Where a shell of a closed mesh reaches into the solid of another, "(x, y, z)"; empty where none does. There a
/// distance has the wrong sign. A shell that faces inwards within another is a hollow, and is fine.
std::string where_shells_overlap(const TriangleMesh& mesh);

/// Turns all triangles where they face inwards.
void face_outwards(TriangleMesh& mesh);

}  // namespace trevi
