// A forcing: wind that pulls what is above a height along with it, du/dt = (wind − u)/time. It treats each particle on
// its own and depends on nothing but its state, so no bit depends on the ranks. Not collective.
#pragma once

#include "trevi/forcing.hpp"

namespace trevi {

class Wind : public Forcing {
 public:
  /// Velocity, m/s; height, m; the time in which water takes it on, s.
  Wind(const Vec3& velocity, Real height, Real time) : velocity_(velocity), height_(height), time_(time) {}

  void apply(Particles& particles, const StepInfo& info) override {
    for (std::size_t i = 0; i < particles.id.size(); ++i) {
      if (particles.position[i].z() < height_) continue;
      particles.velocity[i] += (velocity_ - particles.velocity[i]) * -std::expm1(-info.dt / time_);
    }
  }
  Real fastest(const TimeSpan&) const override { return velocity_.norm(); }

 private:
  Vec3 velocity_;
  Real height_, time_;
};

}  // namespace trevi
