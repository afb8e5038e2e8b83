#include "boundary/geometry/surface_points.hpp"

#include <algorithm>
#include <cmath>
#include <tuple>

namespace trevi {

void keep_one_of_each(std::vector<Vec3>& points, Real closer) {
  const auto key = [](const Vec3& p) { return std::make_tuple(p.x(), p.y(), p.z()); };
  std::sort(points.begin(), points.end(), [&](const Vec3& p, const Vec3& q) { return key(p) < key(q); });
  points.erase(std::unique(points.begin(), points.end(),
                           [&](const Vec3& p, const Vec3& q) { return (p - q).squaredNorm() < closer * closer; }),
               points.end());
}

std::vector<Vec3> points_of(const TriangleMesh& mesh, Real step) {
  std::vector<Vec3> points;
  for (const auto& [i, j, k] : mesh.triangles) {
    const Vec3 &a = mesh.points[static_cast<std::size_t>(i)], &b = mesh.points[static_cast<std::size_t>(j)],
               &c = mesh.points[static_cast<std::size_t>(k)];
    const Real longest = std::max({(b - a).norm(), (c - a).norm(), (c - b).norm()});
    const int n = std::max(1, static_cast<int>(std::ceil(longest / step)));
    for (int u = 0; u <= n; ++u) {
      for (int v = 0; u + v <= n; ++v) points.push_back(a + (b - a) * (Real(u) / n) + (c - a) * (Real(v) / n));
    }
  }
  keep_one_of_each(points, 1e-6 * step);
  return points;
}

namespace {

// The mean distance around a point grows with the angle of an edge: from 0 in a plane to 0.15 of the radius at 35
// degrees and 0.37 at a right angle.
bool is_sharp(const Shape& shape, const Vec3& p, Real radius) {
  constexpr Real sharp = 0.15;
  constexpr int directions = 27;  // to the corners, edges and faces of a cube, and its centre
  Real sum = 0;
  for (int n = 0; n < directions; ++n) {
    const Vec3 to(n % 3 - 1, n / 3 % 3 - 1, n / 9 - 1);
    if (!to.isZero()) sum += shape.distance(p + radius / to.norm() * to);
  }
  return sum > sharp * radius * (directions - 1);
}

}  // namespace

std::vector<Vec3> edges_of(const Shape& shape, const TriangleMesh& surface, Real radius, Real step) {
  std::vector<Vec3> points;
  for (const auto& corners : surface.triangles) {
    for (std::size_t k = 0; k < 3; ++k) {
      const Vec3 &a = surface.points[static_cast<std::size_t>(corners[k])],
                 &b = surface.points[static_cast<std::size_t>(corners[(k + 1) % 3])];
      // An edge belongs to two triangles, which traverse it in opposite directions.
      if (std::tie(a.x(), a.y(), a.z()) > std::tie(b.x(), b.y(), b.z()) || !is_sharp(shape, (a + b) / 2, radius))
        continue;
      const int n = std::max(1, static_cast<int>(std::ceil((b - a).norm() / step)));
      for (int u = 0; u <= n; ++u) points.push_back(a + (b - a) * (Real(u) / n));
    }
  }
  keep_one_of_each(points, 1e-6 * step);
  return points;
}

}  // namespace trevi
