// A zone in which the water comes to rest, in front of a wall that is not to reflect waves ([[damping]]). Not
// collective.
#pragma once

#include "parallel/log.hpp"
#include "trevi/forcing.hpp"
#include "trevi/settings.hpp"

namespace trevi {

/// dv/dt = −r(s) v in a box, with r(s) = rate · s² where s increases from 0 at the beginning of the zone to 1 at its
/// end along its direction: v exp(−r dt), exact over a step at a constant place, so that it does not depend on how time
/// is divided. It never adds energy or reverses a velocity.
class Damping : public Forcing {
 public:
  explicit Damping(const DampingSettings& zone) : event_("Damping"), zone_(zone) {}
  void apply(Particles& particles, const StepInfo& info) override;

 private:
  Event event_;
  DampingSettings zone_;
};

}  // namespace trevi
