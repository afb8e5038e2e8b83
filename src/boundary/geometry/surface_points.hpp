// Points that stand for the surface of a solid where it may touch another one.
#pragma once

#include <vector>

#include "boundary/geometry/shape.hpp"

namespace trevi {

/// Sorts the points, and of those nearer to each other than `closer`, m, keeps one.
void keep_one_of_each(std::vector<Vec3>& points, Real closer);
/// Of the triangles, no further apart than `step`, m; each once.
std::vector<Vec3> points_of(const TriangleMesh& mesh, Real step);
/// Points on the edges of a shape at which its surface turns outwards by more than 35 degrees within `radius`, m, no
/// further apart than `step`, m; each once. `surface`: its own, with chords that deviate by much less than `radius`.
std::vector<Vec3> edges_of(const Shape& shape, const TriangleMesh& surface, Real radius, Real step);

}  // namespace trevi
