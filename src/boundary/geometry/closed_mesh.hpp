// Whether a mesh is the surface of a solid: only then does it have an inside. Not collective.
#pragma once

#include <string>

#include "trevi/obstacle.hpp"

namespace trevi {

/// What is wrong with a mesh, and where; empty if each edge belongs to two triangles that are oriented consistently.
std::string why_not_closed(const TriangleMesh& mesh);

/// Whether it encloses next to no volume for its size: two triangles back to back are closed, too.
bool is_flat(const TriangleMesh& mesh);

/// Where a shell of a closed mesh extends into the solid of another, "(x, y, z)"; empty if none does. The distance
/// would have the wrong sign there. A shell that faces inwards inside another one is a cavity, which is allowed.
std::string where_shells_overlap(const TriangleMesh& mesh);

/// Reverses all triangles if they face inwards.
void face_outwards(TriangleMesh& mesh);

}  // namespace trevi
