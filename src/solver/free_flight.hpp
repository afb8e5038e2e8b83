// Water in the air flies on the parabola itself: where nothing but gravity acts on a particle in a substep, it moves by
// the mean of its two velocities, x_{n+1} = x_n + (v_n + v_{n+1}) Δt/2, which is the path by the new one alone, as
// leapfrog has it, and −g Δt²/2 besides. What a pressure carries stays with leapfrog, which alone is stable for waves;
// in between the lift fades with the square of the pressure's share, so that kinetic and potential energy together
// never rise by it. May be called in loops that threads share. Not collective.
#pragma once

#include "boundary/boundary.hpp"

namespace trevi {

class FreeFlight {
 public:
  /// `gravity` in m/s², h in m.
  FreeFlight(const Vec3& gravity, Real h, const Boundary& boundary)
      : gravity_(gravity), h_(h), boundary_(boundary), half_((gravity / 2).squaredNorm()) {}

  bool has_gravity() const { return half_ > 0; }
  /// How far a particle flies, from 0 to 1, which a pressure has displaced by delta, m, in the time dt, s: nothing
  /// where it has half of its weight. None flies that is so near to something below it that it may rest on it.
  Real share(const Vec3& delta, const Vec3& p, Real dt) const {
    const Real carried = delta.squaredNorm() / (half_ * dt * dt * dt * dt);
    return carried < 1 && is_clear(p) ? 1 - carried : 0;
  }
  /// Of a particle that flies, m.
  Vec3 lift(Real dt) const { return -gravity_ * (dt * dt / 2); }

 private:
  bool is_clear(const Vec3& p) const {
    const Box& box = boundary_.walls().box();
    for (int a = 0; a < 3; ++a) {
      if (gravity_[a] < 0 ? p[a] < box.min[a] + h_ : gravity_[a] > 0 && p[a] > box.max[a] - h_) return false;
    }
    const Obstacles* obstacles = boundary_.obstacles();
    return obstacles == nullptr || !obstacles->is_near(p);
  }

  Vec3 gravity_;
  Real h_;
  const Boundary& boundary_;
  Real half_;  // of gravity, squared, m²/s⁴
};

}  // namespace trevi
