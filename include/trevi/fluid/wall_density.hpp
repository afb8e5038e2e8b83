// What a plane wall adds to the density of a particle near it, as if the fluid went on behind the plane (walls.density
// = "analytic"). Closed form for a half space at distance d (u = d/h):
//   share of rest density  F(d) = C6 π/4 ∫_d^h (h² − z²)⁴ dz,  C6 = 315/(64 π h⁹);  with Spiky ∫_d^h g(z) dz
//   gradient magnitude     g(d) = 30/h⁶ [h (h − d)⁴/4 − (h − d)⁵/5]
// scaled, by tables over the distances of the lattice layers, such that the start lattice has rest density and balanced
// gradients at walls, edges and corners alike. Edges and corners by inclusion and exclusion. Not collective.
#pragma once

#include <array>
#include <vector>

#include "trevi/fluid/settings.hpp"
#include "trevi/fluid/walls.hpp"

namespace trevi {

/// What fills the missing half of a particle's neighbourhood: a share of rest density and its gradient, in 1 and 1/m.
struct BoundaryShare {
  Real density = 0;
  Vec3 gradient = Vec3::Zero();
};

/// Closed forms of one plane, d in [0, h].
Real half_space_share(Kernel kernel, Real d, Real h);
Real half_space_gradient(Real d, Real h);  ///< 1/m

class AnalyticWallDensity {
 public:
  /// `spacing` and h define the lattice that shall be at rest; metres.
  AnalyticWallDensity(const Box& box, Kernel kernel, Real spacing, Real h);

  /// Nearly all particles are more than h away from every wall: that test is made here, the rest behind a call.
  BoundaryShare at(const Vec3& p) const {
    const bool far = (p.array() >= interior_.min.array()).all() && (p.array() <= interior_.max.array()).all();
    return far ? BoundaryShare{} : near_walls(p);
  }

 private:
  static constexpr int most_planes = 3;
  // Tables over the distances (k + ½) spacing of one, two or three planes, all with d < h, multilinear in between: sums
  // over the lattice points behind all of these planes, divided by the closed form or the product of the planes' own.
  // The last layer is there twice, so that the upper end of every interval exists.
  struct Table {
    std::vector<Real> share, gradient;  // the gradient is along the first plane's normal
  };
  // A wall within h: the closed forms, and where its distance lies between the layers of the tables.
  struct Plane {
    Real distance = 0;
    int axis = 0;
    Real side = 0;  // −1 low, +1 high: rho falls as the particle moves away from the plane
    int layer = 0;
    Real fraction = 0;
    Real share = 0, gradient = 0;
  };
  template <std::size_t Dimensions>
  Real ratio(const std::vector<Real>& table, const std::array<const Plane*, Dimensions>& planes) const;
  void tabulate(int dimensions);
  Plane plane_at(Real distance, int axis, Real side) const;
  BoundaryShare near_walls(const Vec3& p) const;
  BoundaryShare union_of(const std::array<Plane, most_planes>& planes, std::size_t count) const;

  Box box_, interior_;
  Kernel kernel_;
  Real h_, spacing_, per_spacing_;
  int layers_;                             // lattice layers with distance below h
  std::array<Table, most_planes> tables_;  // plane, edge, corner
};

}  // namespace trevi
