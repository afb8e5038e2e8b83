// A velocity filter: skin friction of obstacles of any slope, a shear stress c_f/2 rho |u| u against the velocity u
// relative to the surface, as FloorFriction has it for the floor. It acts within h of a surface, whose distance is that
// of its equivalent plane, and what it takes from the water is recorded for the obstacle. Not collective.
#pragma once

#include <memory>

#include "base/threads.hpp"
#include "fluid/filters/velocity_filter.hpp"

namespace trevi {

template <class T>
class BedFriction : public VelocityFilter<T> {
 public:
  /// `coefficient` c_f of a flat plate; h, m.
  BedFriction(Real coefficient, Real h, std::shared_ptr<Obstacles> obstacles)
      : coefficient_(coefficient), h_(h), obstacles_(std::move(obstacles)) {}

  void apply(Neighbourhood<T>&, Particles& particles, Real dt) override {
    for_each_index({0, particles.size()}, [&](std::size_t i) {
      const Vec3& p = particles.predicted[i];
      obstacles_->for_each_near(p, [&](std::size_t account, Real distance, const Vec3&, const Vec3& displacement) {
        const Vec3 surface = displacement / dt, u = particles.velocity[i] - surface;
        const Real rate = coefficient_ / h_ * std::max(1 - distance / h_, 0.0) * u.norm();
        const Vec3 v = surface + u / (1 + rate * dt);  // implicit: it never turns a velocity around
        obstacles_->record(account, (v - particles.velocity[i]) * dt, p);
        particles.velocity[i] = v;
      });
    });
  }

 private:
  Real coefficient_, h_;
  std::shared_ptr<Obstacles> obstacles_;
};

}  // namespace trevi
