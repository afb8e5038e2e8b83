#include "boundary/geometry/tessellation.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace trevi {

namespace {

// The number of corners of a circle whose chords deviate by at most `finest`.
int corners(Real radius, Real finest) {
  const Real fraction = std::clamp(finest / radius, 1e-4, 0.1);
  return std::clamp(4 * static_cast<int>(std::ceil(std::numbers::pi / (4 * std::acos(1 - fraction)))), 16, 256);
}

}  // namespace

Profile arc(Real radius, Real apart, Real size, Real finest) {
  const int count = corners(size, finest) / 2;
  Profile profile;
  for (int k = 0; k <= count; ++k) {
    const Real angle = std::numbers::pi * k / count, shift = 2 * k < count ? -apart : apart;
    if (2 * k == count && apart > 0) profile.emplace_back(radius, -apart);
    const bool pole = k == 0 || k == count;
    profile.emplace_back(pole ? 0 : radius * std::sin(angle), shift - radius * std::cos(angle));
  }
  return profile;
}

Profile ring(Real radius, Real tube, Real finest) {
  const int count = corners(tube, finest);
  Profile profile;
  for (int k = 0; k <= count; ++k) {
    const Real angle = 2 * std::numbers::pi * (k % count) / count;
    profile.emplace_back(radius + tube * std::cos(angle), tube * std::sin(angle));
  }
  return profile;
}

TriangleMesh turned(const Profile& profile, Real finest) {
  Real widest = 0;
  for (const auto& point : profile) widest = std::max(widest, point.first);
  const int sides = corners(widest, finest);
  const auto rows = static_cast<int>(profile.size());
  TriangleMesh mesh;
  for (int side = 0; side < sides; ++side) {
    const Real angle = 2 * std::numbers::pi * side / sides;
    for (const auto& [r, z] : profile) mesh.points.emplace_back(r * std::cos(angle), r * std::sin(angle), z);
  }
  for (int side = 0; side < sides; ++side) {
    for (int k = 0; k + 1 < rows; ++k) {
      const int a = side * rows + k, b = (side + 1) % sides * rows + k;
      if (profile[static_cast<std::size_t>(k)].first > 0) mesh.triangles.push_back({a, b, a + 1});
      if (profile[static_cast<std::size_t>(k) + 1].first > 0) mesh.triangles.push_back({b, b + 1, a + 1});
    }
  }
  return mesh;
}

TriangleMesh cuboid_surface(const Vec3& half) {
  TriangleMesh mesh;
  for (int k = 0; k < 8; ++k)
    mesh.points.emplace_back((k & 1) != 0 ? half.x() : -half.x(), (k & 2) != 0 ? half.y() : -half.y(),
                             (k & 4) != 0 ? half.z() : -half.z());
  mesh.triangles = {{0, 2, 1}, {1, 2, 3}, {4, 5, 6}, {5, 7, 6}, {0, 1, 4}, {1, 5, 4},
                    {2, 6, 3}, {3, 6, 7}, {0, 4, 2}, {2, 4, 6}, {1, 3, 5}, {3, 7, 5}};
  return mesh;
}

TriangleMesh basin_surface(const Box& outer, const Vec3& half) {
  TriangleMesh mesh;
  const auto rectangle = [&](const Vec3& low, const Vec3& high, Real z) {  // counterclockwise from above
    mesh.points.insert(
        mesh.points.end(),
        {{low.x(), low.y(), z}, {high.x(), low.y(), z}, {high.x(), high.y(), z}, {low.x(), high.y(), z}});
  };
  const auto quad = [&](int a, int b, int c, int d) {
    mesh.triangles.push_back({a, b, c});
    mesh.triangles.push_back({a, c, d});
  };
  rectangle(outer.min, outer.max, outer.min.z());  // 0: under the floor
  rectangle(outer.min, outer.max, outer.max.z());  // 4: the outer edge of the rim
  rectangle(-half, half, outer.max.z());           // 8: its inner edge
  rectangle(-half, half, -half.z());               // 12: the floor
  quad(3, 2, 1, 0);
  quad(12, 13, 14, 15);
  for (int k = 0; k < 4; ++k) {
    const int next = (k + 1) % 4;
    for (int row = 0; row < 12; row += 4) quad(row + k, row + next, row + 4 + next, row + 4 + k);
  }
  return mesh;
}

}  // namespace trevi
