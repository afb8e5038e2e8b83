// Meshes of shapes as they are drawn, closed.
#pragma once

#include <array>
#include <cmath>
#include <cstdint>
#include <map>
#include <vector>

#include "trevi/obstacle.hpp"

namespace trevi::test {

/// With equal points joined, as those of a file are, and without what then has no area.
inline TriangleMesh joined(const TriangleMesh& mesh) {
  TriangleMesh result;
  std::map<std::array<Real, 3>, std::int32_t> number;
  std::vector<std::int32_t> to;
  for (const Vec3& p : mesh.points) {
    const std::array<Real, 3> key{std::round(p.x() * 1e9), std::round(p.y() * 1e9), std::round(p.z() * 1e9)};
    const auto [place, is_new] = number.try_emplace(key, static_cast<std::int32_t>(result.points.size()));
    if (is_new) result.points.push_back(p);
    to.push_back(place->second);
  }
  for (const auto& t : mesh.triangles) {
    const std::array<std::int32_t, 3> n{to[static_cast<std::size_t>(t[0])], to[static_cast<std::size_t>(t[1])],
                                        to[static_cast<std::size_t>(t[2])]};
    if (n[0] != n[1] && n[1] != n[2] && n[2] != n[0]) result.triangles.push_back(n);
  }
  return result;
}

}  // namespace trevi::test
