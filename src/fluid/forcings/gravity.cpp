#include "fluid/forcings/gravity.hpp"

#include "base/threads.hpp"

namespace trevi {

void Gravity::apply(Particles& particles, const StepInfo& info) {
  const ScopedEvent timed(event_);
  const Vec3 change = acceleration_ * info.dt;
  for_each_index({0, particles.size()}, [&](std::size_t i) { particles.velocity[i] += change; });
}

}  // namespace trevi
