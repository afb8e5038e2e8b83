// What a plane wall adds to the density of a particle near it, as if the fluid went on behind the plane (walls.density
// = "analytic"). Closed form for a half space at distance d (u = d/h):
//   share of rest density  F(d) = C6 π/4 ∫_d^h (h² − z²)⁴ dz,  C6 = 315/(64 π h⁹)
//   gradient magnitude     g(d) = 30/h⁶ [h (h − d)⁴/4 − (h − d)⁵/5]
// scaled, by tables over the distances of the lattice layers, such that the start lattice has rest density and balanced
// gradients at walls, edges and corners alike. Edges and corners by inclusion and exclusion. Not collective.
#pragma once

#include <array>
#include <vector>

#include "trevi/fluid/density.hpp"
#include "trevi/fluid/walls.hpp"

namespace trevi {

/// Closed forms of one plane, d in [0, h].
Real half_space_share(Real d, Real h);
Real half_space_gradient(Real d, Real h);  ///< 1/m

class AnalyticWallDensity : public BoundaryDensity {
 public:
  /// `spacing` and h define the lattice that shall be at rest; metres.
  AnalyticWallDensity(const Box& box, Real spacing, Real h);
  BoundaryShare at(const Vec3& p) const override;

 private:
  // Tables over the distances (k + ½) spacing of one, two or three planes, all with d < h, multilinear in between: sums
  // over the lattice points behind all of these planes, divided by the closed form or the product of the planes' own.
  using Distances = std::array<Real, 3>;
  struct Table {
    std::vector<Real> share, gradient;  // the gradient is along the first plane's normal
  };
  Real ratio(const std::vector<Real>& table, const Distances& d, int dimensions) const;
  void tabulate(int dimensions);
  BoundaryShare union_of_planes(const Distances& d, const std::array<int, 3>& axis, int near) const;

  Box box_;
  Real h_, spacing_;
  int layers_;                   // lattice layers with distance below h
  std::array<Table, 3> tables_;  // plane, edge, corner
};

}  // namespace trevi
