// Gravity: the same acceleration for all particles, m/s². Not collective.
#pragma once

#include "parallel/log.hpp"
#include "trevi/forcing.hpp"

namespace trevi {

/// v += a dt.
class Gravity : public Forcing {
 public:
  explicit Gravity(const Vec3& acceleration) : event_("Gravity"), acceleration_(acceleration) {}
  void apply(Particles& particles, const StepInfo& info) override;

 private:
  Event event_;
  Vec3 acceleration_;
};

}  // namespace trevi
