// Whether a mesh is the surface of a solid: only then is there an inside. Not collective.
#pragma once

#include <string>

#include "trevi/obstacle.hpp"

namespace trevi {

/// What is wrong with a mesh and where; empty when each edge is that of two triangles which are oriented consistently.
std::string why_not_closed(const TriangleMesh& mesh);

/// Turns all triangles where they face inwards.
void face_outwards(TriangleMesh& mesh);

}  // namespace trevi
