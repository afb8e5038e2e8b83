// What walls and obstacles have behind them for the friction of xsph_viscosity.hpp, as neighbours are missing there.
// Velocities go on behind a wall in a straight line through that of the wall: that across it always, those along it
// where it holds the water ([viscosity] no_slip). Those behind a plane at distance d then add, along it,
//   dv/dt = (nu/M_i) n (v_wall − v) ∫_d^h A(z) z/d dz = (nu/M_i) n h³ (2π/35) (v_wall − v) (1 − u²)^(7/2)/u,  u = d/h,
// n being particles a volume and A(z) = h² (2π/5) (1 − z²/h²)^(5/2) what F is on a plane z away; and across it twice
// that, the second half being that of the transposed gradients. v_wall is that of what goes with the wall at the place
// of the water: what is missing of water that turns with a wall is what the wall would have there. Along a frictionless
// wall velocities are mirrored; as their neighbours along it are those that there are, M_i then has only a share of the
// moment of what is behind. In two dimensions n is particles an area, A(z) = h (16/15) (1 − z²/h²)^(5/2) what F is on a
// line z away, and h² (16/105) takes the place of h³ (2π/35). Applied implicitly, so that no distance and no step is
// too short. Not collective.
#pragma once

#include <memory>

#include "boundary/obstacles/obstacles.hpp"
#include "kernels/kernels.hpp"

namespace trevi {

class ViscousWalls {
 public:
  /// `nu` in m²/s; `obstacles` may be null.
  ViscousWalls(Real nu, bool no_slip, const PointLattice& lattice, Real h, const Box& box,
               std::shared_ptr<Obstacles> obstacles);

  /// Within h of a wall.
  bool is_near(const Vec3& p) const;
  /// What M_i has of what is behind the walls, over M of the lattice.
  Real moment_behind(const Vec3& p) const;
  /// The velocity after a step of one that has v, `weight` being M/M_i; what each wall gave is recorded.
  Vec3 held(const Vec3& p, const Vec3& v, Real weight, Real dt);

 private:
  bool may_be_near(const Vec3& p) const;
  template <class Visit>
  void for_each_near(const Vec3& p, const Visit& visit) const;
  Eigen::Matrix3d pull(Real distance, const Vec3& normal) const;

  Box box_;
  std::shared_ptr<Obstacles> obstacles_;
  Real h_;
  bool no_slip_;
  int dimensions_;
  Real factor_, per_moment_, least_;  // 1/s, 1, m
};

}  // namespace trevi
