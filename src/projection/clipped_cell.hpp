// The parts of a square and of a cube on one side of a plane: areas and centroids of faces that a solid cuts and
// volumes of cells, exact where its surface is flat. Not collective.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>

#include "trevi/types.hpp"

namespace trevi {

/// Part of a unit square about the origin: its area and first moments.
struct SquarePart {
  Real area = 0;
  std::array<Real, 2> moment{};
};

/// The part of the square where distance + slope · place is positive: the square clipped by this half-plane (Sutherland
/// & Hodgman, Commun. ACM 17, 1974).
inline SquarePart clipped_square(Real distance, const std::array<Real, 2>& slope) {
  constexpr std::array<std::array<Real, 2>, 4> corner{{{-0.5, -0.5}, {0.5, -0.5}, {0.5, 0.5}, {-0.5, 0.5}}};
  const Real reach = (std::abs(slope[0]) + std::abs(slope[1])) / 2;
  if (distance >= reach) return {1, {}};
  if (distance <= -reach) return {};
  std::array<std::array<Real, 2>, 5> polygon{};
  std::size_t n = 0;
  const auto height = [&](const std::array<Real, 2>& p) { return distance + slope[0] * p[0] + slope[1] * p[1]; };
  for (std::size_t k = 0; k < 4; ++k) {
    const auto &from = corner[k], &to = corner[(k + 1) % 4];
    const Real a = height(from), b = height(to);
    if (a > 0) polygon[n++] = from;
    if ((a > 0) != (b > 0))
      polygon[n++] = {from[0] + (to[0] - from[0]) * (a / (a - b)), from[1] + (to[1] - from[1]) * (a / (a - b))};
  }
  SquarePart part;
  for (std::size_t k = 0; k < n; ++k) {
    const auto &p = polygon[k], &q = polygon[(k + 1) % n];
    const Real twice = p[0] * q[1] - q[0] * p[1];
    part.area += twice / 2;
    for (std::size_t i = 0; i < 2; ++i) part.moment[i] += twice * (p[i] + q[i]) / 6;
  }
  return part;
}

/// The volume of the part of a unit cube about the origin where distance + slope · place is positive: the tetrahedron
/// that the plane cuts off an octant of space, minus its parts beyond the faces of the cube (Scardovelli & Zaleski, J.
/// Comput. Phys. 164, 2000, eq. 4). A plane parallel to an edge is tilted by a thousandth.
inline Real clipped_cube(Real distance, const std::array<Real, 3>& slope) {
  std::array<Real, 3> n{};
  for (std::size_t a = 0; a < 3; ++a) n[a] = std::abs(slope[a]);
  const Real reach = (n[0] + n[1] + n[2]) / 2;
  if (distance >= reach) return 1;
  if (distance <= -reach) return 0;
  for (Real& one : n) one = std::max(one, 2e-3 * reach);
  const Real from_corner = distance + (n[0] + n[1] + n[2]) / 2;
  Real sum = 0;
  for (unsigned corner = 0; corner < 8; ++corner) {
    Real left = from_corner, sign = 1;
    for (std::size_t a = 0; a < 3; ++a) {
      if ((corner >> a & 1U) == 0) continue;
      left -= n[a];
      sign = -sign;
    }
    if (left > 0) sum += sign * left * left * left;
  }
  return std::clamp(sum / (6 * n[0] * n[1] * n[2]), 0.0, 1.0);
}

/// The approximate centroid of the rest of the cube, of which `part` is the volume; exact for planes parallel to faces,
/// and for corners.
inline std::array<Real, 3> middle_below(Real part, const std::array<Real, 3>& slope) {
  if (part == 1) return {};
  const Real steep = std::abs(slope[0]) + std::abs(slope[1]) + std::abs(slope[2]);
  const Real square = slope[0] * slope[0] + slope[1] * slope[1] + slope[2] * slope[2];
  const Real off = square > 0 ? (part - 1) / 2 * steep / square : 0;
  return {off * slope[0], off * slope[1], off * slope[2]};
}

}  // namespace trevi
