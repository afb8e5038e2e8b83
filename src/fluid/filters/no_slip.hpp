// Walls and obstacles that hold the water that touches them ([viscosity] no_slip). XSPH misses the neighbours that
// would be behind a wall; with velocities that go on there in a straight line through that of the wall, those of a
// plane at distance d add
//   dv/dt = (nu/M) n (v_wall − v) ∫_d^h A(z) z/d dz = (nu/M) n h³ W6(0) (π/40) (v_wall − v) (1 − u²)⁵/u,  u = d/h,
// n being particles a volume, M as in xsph_viscosity.hpp, and A(z) = W6(0) h² (π/4) (1 − z²/h²)⁴ what Poly6 is on a
// plane z away. In two dimensions n is particles an area, A(z) = W6(0) h (32/35) (1 − z²/h²)^(7/2) what Poly6 is on a
// line z away, and
//   dv/dt = (nu/M) n h² W6(0) (32/315) (v_wall − v) (1 − u²)^(9/2)/u.
// Applied implicitly, so that no distance and no step is too short. Not collective.
#pragma once

#include <memory>

#include "boundary/obstacles/obstacles.hpp"
#include "fluid/filters/velocity_filter.hpp"

namespace trevi {

template <class T>
class NoSlip : public VelocityFilter<T> {
 public:
  /// `nu` in m²/s; `obstacles` may be null.
  NoSlip(Real nu, const FluidSettings& fluid, const Box& walls, std::shared_ptr<Obstacles> obstacles);
  void apply(Neighbourhood<T>& near, Particles& particles, Real dt) override;

 private:
  Real rate(Real distance) const;
  Vec3 held(const Vec3& p, const Vec3& v, Real dt) const;
  void record(const Vec3& p, const Vec3& v, Real dt);
  template <class Visit>
  void for_each_wall(const Vec3& p, Visit&& visit) const;

  Event event_{"NoSlip"};
  int dimensions_;
  Real factor_, h_, least_;  // 1/s, m, m
  Box walls_;
  std::shared_ptr<Obstacles> obstacles_;
};

extern template class NoSlip<float>;
extern template class NoSlip<double>;

}  // namespace trevi
