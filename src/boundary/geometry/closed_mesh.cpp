#include "boundary/geometry/closed_mesh.hpp"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <map>
#include <utility>

namespace trevi {

std::string why_not_closed(const TriangleMesh& mesh) {
  struct Uses {
    int forwards = 0, backwards = 0;
  };
  std::map<std::pair<std::int32_t, std::int32_t>, Uses> edges;
  for (const auto& corners : mesh.triangles) {
    for (std::size_t k = 0; k < 3; ++k) {
      const std::int32_t a = corners[k], b = corners[(k + 1) % 3];
      Uses& uses = edges[std::minmax(a, b)];
      ++(a < b ? uses.forwards : uses.backwards);
    }
  }
  std::int64_t open = 0, shared = 0, turned = 0;
  const std::pair<std::int32_t, std::int32_t>* first = nullptr;
  for (const auto& [edge, uses] : edges) {
    if (uses.forwards == 1 && uses.backwards == 1) continue;
    if (first == nullptr) first = &edge;
    const int all = uses.forwards + uses.backwards;
    ++(all == 1 ? open : all > 2 ? shared : turned);
  }
  if (first == nullptr) return {};
  const Vec3 middle =
      (mesh.points[static_cast<std::size_t>(first->first)] + mesh.points[static_cast<std::size_t>(first->second)]) / 2;
  return fmt::format(
      "{} open edges, {} of more than two triangles, {} between triangles that are turned against each "
      "other, the first at ({:.6g}, {:.6g}, {:.6g})",
      open, shared, turned, middle.x(), middle.y(), middle.z());
}

void face_outwards(TriangleMesh& mesh) {
  Real volume = 0;
  const auto point = [&](std::int32_t i) { return mesh.points[static_cast<std::size_t>(i)]; };
  for (const auto& t : mesh.triangles) volume += point(t[0]).dot(point(t[1]).cross(point(t[2])));
  if (volume >= 0) return;
  for (auto& t : mesh.triangles) std::swap(t[1], t[2]);
}

}  // namespace trevi
