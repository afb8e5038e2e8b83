// The water that is missing behind walls and obstacles for the friction of xsph_viscosity.hpp, because there are no
// neighbours there. Velocities behind a wall are extrapolated linearly through that of the wall: the component across
// it always, those along it where it holds the water ([viscosity] no_slip). Those behind a plane at distance d then
// add, along it,
//   dv/dt = (nu/M_i) n (v_wall − v) ∫_d^h A(z) z/d dz = (nu/M_i) n h³ (2π/35) (v_wall − v) (1 − u²)^(7/2)/u,  u = d/h,
// n being the number of particles per volume and A(z) = h² (2π/5) (1 − z²/h²)^(5/2) the integral of F over a plane at
// distance z. Across the wall they add twice that, the second half being that of the transposed gradients. v_wall is
// the velocity of a point that moves with the wall at the place of the water: for water that rotates with a wall, what
// is missing is what the wall would have there. Along a frictionless wall velocities are mirrored; as their neighbours
// along it are the existing ones, M_i then has only a share of the moment of what is behind. In two dimensions n is the
// number of particles per area, A(z) = h (16/15) (1 − z²/h²)^(5/2) the integral of F over a line at distance z, and h²
// (16/105) takes the place of h³ (2π/35). Applied implicitly, so that no distance and no step is too short. Not
// collective.
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

  /// Whether a position is within h of a wall.
  bool is_near(const Vec3& p) const;
  /// The part of M_i that is due to what is behind the walls, over M of the lattice.
  Real moment_behind(const Vec3& p) const;
  /// The velocity after a step of a particle with velocity v, `weight` being M/M_i; what each wall gave is recorded.
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
