#include "fluid/gravity.hpp"

namespace trevi {

void Gravity::apply(Particles& particles, const StepInfo& info) {
  const ScopedEvent timed(event_);
  const Vec3 change = acceleration_ * info.dt;
  for (Vec3& v : particles.velocity) v += change;
}

}  // namespace trevi
