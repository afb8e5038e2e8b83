#include "boundary/geometry/closed_mesh.hpp"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <cmath>
#include <map>
#include <numbers>
#include <numeric>
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

namespace {

// Six times the volume, m³, and twice the area, m². About a corner of the mesh, as it may be far from the origin.
std::pair<Real, Real> volume_and_area(const TriangleMesh& mesh) {
  std::pair<Real, Real> sums(0, 0);
  if (mesh.triangles.empty()) return sums;
  const auto point = [&](std::int32_t i) { return mesh.points[static_cast<std::size_t>(i)]; };
  const Vec3 origin = point(mesh.triangles[0][0]);
  for (const auto& t : mesh.triangles) {
    const Vec3 a = point(t[0]) - origin, b = point(t[1]) - origin, c = point(t[2]) - origin;
    sums.first += a.dot(b.cross(c));
    sums.second += (b - a).cross(c - a).norm();
  }
  return sums;
}

}  // namespace

namespace {

using Triangles = std::vector<std::array<std::int32_t, 3>>;

// The triangles of each shell: those that hang together by their corners.
std::vector<Triangles> shells_of(const TriangleMesh& mesh) {
  std::vector<std::int32_t> above(mesh.points.size());
  std::iota(above.begin(), above.end(), 0);
  const auto root = [&](std::int32_t i) {
    while (above[static_cast<std::size_t>(i)] != i) {
      std::int32_t& up = above[static_cast<std::size_t>(i)];
      i = up = above[static_cast<std::size_t>(up)];
    }
    return i;
  };
  for (const auto& t : mesh.triangles) {
    above[static_cast<std::size_t>(root(t[1]))] = root(t[0]);
    above[static_cast<std::size_t>(root(t[2]))] = root(t[0]);
  }
  std::map<std::int32_t, Triangles> shells;
  for (const auto& t : mesh.triangles) shells[root(t[0])].push_back(t);
  std::vector<Triangles> all;
  for (auto& [first, triangles] : shells) all.push_back(std::move(triangles));
  return all;
}

// How often the shell goes around p (van Oosterom & Strackee 1983): 1 within one that faces outwards.
Real winding_number(const TriangleMesh& mesh, const Triangles& shell, const Vec3& p) {
  Real sum = 0;
  for (const auto& t : shell) {
    const auto from_p = [&](std::size_t k) { return Vec3(mesh.points[static_cast<std::size_t>(t[k])] - p); };
    const Vec3 a = from_p(0), b = from_p(1), c = from_p(2);
    const Real la = a.norm(), lb = b.norm(), lc = c.norm();
    sum += 2 * std::atan2(a.dot(b.cross(c)), la * lb * lc + a.dot(b) * lc + b.dot(c) * la + c.dot(a) * lb);
  }
  return sum / (4 * std::numbers::pi);
}

}  // namespace

std::string where_shells_overlap(const TriangleMesh& mesh) {
  const std::vector<Triangles> shells = shells_of(mesh);
  for (std::size_t one = 0; shells.size() > 1 && one < shells.size(); ++one) {
    const bool is_hollow = volume_and_area({mesh.points, shells[one]}).first < 0;
    for (const auto& t : shells[one]) {
      const Vec3& p = mesh.points[static_cast<std::size_t>(t[0])];
      Real around = 0;  // all others together
      for (std::size_t k = 0; k < shells.size(); ++k) around += k == one ? 0 : winding_number(mesh, shells[k], p);
      if (around > (is_hollow ? 1.5 : 0.5)) return fmt::format("({:.6g}, {:.6g}, {:.6g})", p.x(), p.y(), p.z());
    }
  }
  return {};
}

bool is_flat(const TriangleMesh& mesh) {
  constexpr Real least = 1e-6;  // of a cube's volume for its area, which is area^1.5 / 14.7
  const auto [volume, area] = volume_and_area(mesh);
  return std::abs(volume) / 6 <= least * std::pow(area / 2, 1.5) / 14.7;
}

void face_outwards(TriangleMesh& mesh) {
  if (volume_and_area(mesh).first >= 0) return;
  for (auto& t : mesh.triangles) std::swap(t[1], t[2]);
}

}  // namespace trevi
