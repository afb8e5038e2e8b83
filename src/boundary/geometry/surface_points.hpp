// Points that represent the surface of a solid where it may touch another one.
#pragma once

#include <vector>

#include "boundary/geometry/shape.hpp"

namespace trevi {

/// Sorts the points, and keeps one of those that are closer to each other than `closer`, m.
void keep_one_of_each(std::vector<Vec3>& points, Real closer);
/// Points of the triangles, no further apart than `step`, m; each once.
std::vector<Vec3> points_of(const TriangleMesh& mesh, Real step);
/// Points on the edges of a shape at which its surface turns outwards by more than 35 degrees within `radius`, m, no
/// further apart than `step`, m; each once. `surface`: that of the shape, with chords that deviate by much less than
/// `radius`.
std::vector<Vec3> edges_of(const Shape& shape, const TriangleMesh& surface, Real radius, Real step);

}  // namespace trevi
