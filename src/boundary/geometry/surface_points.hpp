// Points that stand for the surface of a solid where it may touch another one.
#pragma once

#include <vector>

#include "boundary/geometry/shape.hpp"

namespace trevi {

/// Sorts the points, and of those nearer to each other than `closer`, m, keeps one.
void keep_one_of_each(std::vector<Vec3>& points, Real closer);
/// Of the triangles, no further apart than `step`, m; each once.
std::vector<Vec3> points_of(const TriangleMesh& mesh, Real step);
/// Of points on the surface of a shape those on corners, and on edges at which it turns by more than 35 degrees within
/// `radius`, m, outwards.
std::vector<Vec3> sharp_of(const Shape& shape, const std::vector<Vec3>& points, Real radius);

}  // namespace trevi
