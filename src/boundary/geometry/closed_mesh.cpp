#include "boundary/geometry/closed_mesh.hpp"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <numeric>
#include <optional>
#include <utility>

#include "trevi/box.hpp"

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

// Six times the volume, m³, and twice the area, m², computed about a corner of the mesh, which may be far from the
// origin.
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

// The triangles of each shell: those connected through their corners.
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

// The winding number of the surface about p (van Oosterom & Strackee 1983): 1 within a shell that faces outwards.
Real winding_number(const TriangleMesh& mesh, const Vec3& p) {
  Real sum = 0;
  for (const auto& t : mesh.triangles) {
    const auto from_p = [&](std::size_t k) { return Vec3(mesh.points[static_cast<std::size_t>(t[k])] - p); };
    const Vec3 a = from_p(0), b = from_p(1), c = from_p(2);
    const Real la = a.norm(), lb = b.norm(), lc = c.norm();
    sum += 2 * std::atan2(a.dot(b.cross(c)), la * lb * lc + a.dot(b) * lc + b.dot(c) * la + c.dot(a) * lb);
  }
  return sum / (4 * std::numbers::pi);
}

Box bounds_of(const TriangleMesh& mesh, const Triangles& triangles) {
  const Vec3& first = mesh.points[static_cast<std::size_t>(triangles[0][0])];
  Box bounds{first, first};
  for (const auto& t : triangles) {
    for (const std::int32_t corner : t) {
      const Vec3& p = mesh.points[static_cast<std::size_t>(corner)];
      bounds = {bounds.min.cwiseMin(p), bounds.max.cwiseMax(p)};
    }
  }
  return bounds;
}

struct Triangle {
  std::array<Vec3, 3> corners;
  std::size_t shell;
  Vec3 low() const { return corners[0].cwiseMin(corners[1]).cwiseMin(corners[2]); }
  Vec3 high() const { return corners[0].cwiseMax(corners[1]).cwiseMax(corners[2]); }
};

// The point where an edge of one triangle passes through the other triangle, rim included.
std::optional<Vec3> crossing(const Triangle& one, const Triangle& other) {
  const auto& [a, b, c] = other.corners;
  const Vec3 normal = (b - a).cross(c - a);
  for (std::size_t k = 0; k < 3; ++k) {
    const Vec3 &from = one.corners[k], &to = one.corners[(k + 1) % 3];
    const Real before = normal.dot(from - a), behind = normal.dot(to - a);
    if (!(before * behind < 0)) continue;
    const Vec3 p = from + before / (before - behind) * (to - from);
    const Real rim = -1e-9 * normal.squaredNorm();
    if (normal.dot((b - a).cross(p - a)) >= rim && normal.dot((c - b).cross(p - b)) >= rim &&
        normal.dot((a - c).cross(p - c)) >= rim)
      return p;
  }
  return std::nullopt;
}

// Points where the surfaces of two shells meet, a few dozen at most: where solids touch, and where they overlap.
std::vector<Vec3> meetings(std::vector<Triangle> all) {
  constexpr std::size_t enough = 40;
  std::sort(all.begin(), all.end(), [](const auto& a, const auto& b) { return a.low().x() < b.low().x(); });
  std::vector<Vec3> places;
  for (std::size_t i = 0; i < all.size() && places.size() < enough; ++i) {
    const Vec3 low = all[i].low(), high = all[i].high();
    for (std::size_t k = i + 1; k < all.size() && all[k].low().x() <= high.x(); ++k) {
      if (all[k].shell == all[i].shell || (all[k].low().array() > high.array()).any() ||
          (all[k].high().array() < low.array()).any())
        continue;
      if (const auto p = crossing(all[i], all[k])) places.push_back(*p);
      if (const auto p = crossing(all[k], all[i])) places.push_back(*p);
    }
  }
  return places;
}

}  // namespace

// Shells that do not meet are either entirely within one another or not at all, so one point of each is enough. Around
// a point where two meet there is one point of each kind in the directions from it.
std::string where_shells_overlap(const TriangleMesh& mesh) {
  const std::vector<Triangles> shells = shells_of(mesh);
  if (shells.size() < 2) return {};
  std::vector<Triangle> all;
  std::vector<Vec3> places, middles;
  std::vector<Box> bounds;
  for (std::size_t k = 0; k < shells.size(); ++k) {
    for (const auto& t : shells[k]) {
      const auto corner = [&](std::size_t n) { return mesh.points[static_cast<std::size_t>(t[n])]; };
      all.push_back({{corner(0), corner(1), corner(2)}, k});
    }
    const auto& [a, b, c] = all.back().corners;
    middles.emplace_back((a + b + c) / 3);
    bounds.push_back(bounds_of(mesh, shells[k]));
  }
  for (std::size_t k = 0; k < shells.size(); ++k) {
    bool is_alone = volume_and_area({mesh.points, shells[k]}).first > 0;
    for (std::size_t other = 0; is_alone && other < shells.size(); ++other)
      is_alone = other == k || !(bounds[other].contains(bounds[k].min) && bounds[other].contains(bounds[k].max));
    if (!is_alone) places.push_back(middles[k]);
  }
  const Box whole = bounds_of(mesh, mesh.triangles);
  const Real beside = 1e-4 * (whole.max - whole.min).norm();
  for (const Vec3& p : meetings(std::move(all))) places.push_back(p);
  for (const Vec3& p : places) {
    for (int n = 0; n < 8; ++n) {
      const Vec3 direction((n & 1) != 0 ? 1 : -1, (n & 2) != 0 ? 0.7 : -0.7, (n & 4) != 0 ? 0.4 : -0.4);
      const Real around = winding_number(mesh, p + beside * direction);
      if (around > 1.5 || around < -0.5) return fmt::format("({:.6g}, {:.6g}, {:.6g})", p.x(), p.y(), p.z());
    }
  }
  return {};
}

bool is_flat(const TriangleMesh& mesh) {
  constexpr Real least = 1e-6;  // of the volume of a cube with the same area, which is area^1.5 / 14.7
  const auto [volume, area] = volume_and_area(mesh);
  return std::abs(volume) / 6 <= least * std::pow(area / 2, 1.5) / 14.7;
}

void face_outwards(TriangleMesh& mesh) {
  if (volume_and_area(mesh).first >= 0) return;
  for (auto& t : mesh.triangles) std::swap(t[1], t[2]);
}

}  // namespace trevi
