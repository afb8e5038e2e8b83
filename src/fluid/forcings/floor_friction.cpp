#include "fluid/forcings/floor_friction.hpp"

#include <cmath>

#include "base/threads.hpp"

namespace trevi {

void FloorFriction::apply(Particles& particles, const StepInfo& info) {
  const ScopedEvent timed(event_);
  for_each_index({0, particles.size()}, [&](std::size_t i) {
    const Real d = particles.position[i].z() - floor_;
    if (d >= h_) return;
    Vec3& v = particles.velocity[i];
    const Real rate = coefficient_ / h_ * (1 - d / h_) * std::sqrt(v.x() * v.x() + v.y() * v.y());
    v.head<2>() /= 1 + rate * info.dt;
  });
}

}  // namespace trevi
