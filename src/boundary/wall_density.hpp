// What the walls of the box contribute to the density of a particle near them, as if the initial lattice continued
// behind them (walls.density = "analytic"). The gradient is the exact derivative of the density, so that a wall returns
// exactly the energy that it took: forces that are not the gradient of a function would add energy for ever.
//
// One plane at distance d contributes the fraction w(d) of the rest density. At the distances d_k = (k + 1/2) spacing
// of the lattice layers, w is the fraction that lattice points behind the plane would contribute, so that the initial
// state is at rest density; its slope there is `slope` times that of the missing points (WallSlope). In between, w is
// the monotone rational quadratic of Gregory & Delbourgo (1982); below d_0 it is a straight line; it is zero from the
// first layer on whose neighbours are all in front of the plane. Several planes are combined by inclusion and
// exclusion: the fraction behind A or B is A + B − A B r, where r(d_A, d_B) makes edges and corners of the initial
// lattice exact, too. Opposite planes, which are both near where the box is narrow, lack different points, so their
// contributions add up. Not collective.
#pragma once

#include <array>
#include <span>
#include <vector>

#include "boundary/walls.hpp"
#include "kernels/kernels.hpp"
#include "trevi/box.hpp"
#include "trevi/settings.hpp"

namespace trevi {

/// The contribution of the walls at a position: a fraction of the rest density, and its gradient in 1/m.
struct BoundaryDensity {
  Real density = 0;
  Vec3 gradient = Vec3::Zero();
};

/// Ratio of the slope of w to that of missing particles without multipliers.
///
/// Where sweeps produce velocities it is 2: water behind the wall would have multipliers of its own, mirror images of
/// those in front, and so push twice as much. With 1, layers crowd at the wall and a lattice at rest begins to move:
/// pools of 5 layers gain 0.9 % of energy in 20 s, with 2 less than 0.01 %. Waves lose the same energy with either.
///
/// Where sweeps only shift positions, nothing begins to move, and the slope determines how water is arranged at a wall.
/// With 2 it is ordered in layers: in a dam break the quarter layers from the wall on hold 0, 2.5, 0.6, 0.5, 1.1, 1.1,
/// 0.9 times what they should; with 1.25, they hold 1.2, 0.8, 0.8, 1.1, 1.1, 1.1, 1.0. A particle directly at the wall
/// is then too dense by 0.15 instead of 0.31. With 1, disturbed pools come to rest at 1.5e-4 m²/s² instead of 0.5e-4.
struct WallSlope {
  static constexpr Real of_velocities = 2, of_positions = 1.25;
};

class AnalyticWallDensity {
 public:
  /// `spacing` and h, in metres, define the lattice that is to be at rest density, with as many dimensions as the
  /// kernel; `slope` is one of WallSlope.
  AnalyticWallDensity(const Box& box, const Kernel& kernel, Real spacing, Real h, Real slope);

  /// Where walls contribute nothing, which is where most particles are.
  const Box& interior() const { return interior_; }
  /// The fraction at p; zero in the interior.
  BoundaryDensity at(const Vec3& p) const;
  /// The fraction w of a single plane at a distance, m, and its slope, 1/m; below 0 the straight line continues.
  struct OfPlane {
    Real value, slope;
  };
  OfPlane of_plane(Real distance) const;
  /// The distance from which on both are 0, m.
  Real reach() const { return (layers_ + 0.5) * spacing_; }

 private:
  static constexpr int max_planes = 6;
  // A wall within reach of a particle: its fraction and derivative along the axis, and its distance relative to the
  // layers, as weights for interpolation: 1 − blend for `layer` and blend for the next one.
  struct Plane {
    int axis, layer;
    Real value, slope;        // 1, 1/m
    Real blend, blend_slope;  // 1, 1/m
  };
  // r of two or three planes and its derivatives along their axes.
  struct Ratio {
    Real value = 0;
    std::array<Real, 3> slope{};
  };
  void tabulate_layers(Real slope);
  void tabulate_ratios();
  Plane plane_at(Real distance, int axis, Real side) const;
  Ratio ratio(std::initializer_list<const Plane*> planes) const;
  void add_edge(const Plane& a, const Plane& b, BoundaryDensity& total) const;
  void add_corner(const Plane& a, const Plane& b, const Plane& c, BoundaryDensity& total) const;
  BoundaryDensity combined(std::span<const Plane> planes) const;

  Box box_, interior_;
  Kernel kernel_;
  Real h_, spacing_, per_spacing_;
  int layers_;                       // number of layers that miss points behind a plane
  std::vector<Real> value_, slope_;  // w and its slope at d_k, k = 0 ... layers_; zero at the last
  std::vector<Real> edge_, corner_;  // r at the distances of layers; the first plane has the most significant index
};

}  // namespace trevi
