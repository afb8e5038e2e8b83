// Walls and obstacles that hold the water that touches them ([viscosity] no_slip). XSPH misses the neighbours that
// would be behind a wall; with velocities that go on there in a straight line through that of the wall, those of a
// plane at distance d add
//   dv/dt = (nu/M) n (v_wall − v) ∫_d^h A(z) z/d dz = (nu/M) n h³ (2π/35) (v_wall − v) (1 − u²)^(7/2)/u,  u = d/h,
// n being particles a volume, M as in xsph_viscosity.hpp, and A(z) = h² (2π/5) (1 − z²/h²)^(5/2) what its F is on a
// plane z away. In two dimensions n is particles an area, A(z) = h (16/15) (1 − z²/h²)^(5/2) what F is on a line z
// away, and h² (16/105) takes the place of h³ (2π/35).
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
  Real factor_, h_, least_;  // 1/s, m, m
  Box walls_;
  std::shared_ptr<Obstacles> obstacles_;
};

extern template class NoSlip<float>;
extern template class NoSlip<double>;

}  // namespace trevi
