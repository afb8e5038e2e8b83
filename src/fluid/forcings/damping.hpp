// A zone in which the water comes to rest, before a wall from which waves are not to come back ([[damping]]). Not
// collective.
#pragma once

#include "parallel/log.hpp"
#include "trevi/forcing.hpp"
#include "trevi/settings.hpp"

namespace trevi {

/// dv/dt = −r(s) v in a box, with r(s) = rate · s² where s goes from 0 at the beginning of the zone to 1 at its end
/// along its direction: v exp(−r dt), exact over a step at a constant place, so that it does not matter how time is
/// cut. It never adds energy or reverses a velocity.
class Damping : public Forcing {
 public:
  explicit Damping(const DampingSettings& zone) : event_("Damping"), zone_(zone) {}
  void apply(Particles& particles, const StepInfo& info) override;

 private:
  Event event_;
  DampingSettings zone_;
};

}  // namespace trevi
