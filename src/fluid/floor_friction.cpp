#include "fluid/floor_friction.hpp"

#include <cmath>

namespace trevi {

void FloorFriction::apply(Particles& particles, const StepInfo& info) {
  const ScopedEvent timed(event_);
  for (std::size_t i = 0; i < particles.id.size(); ++i) {
    const Real d = particles.position[i].z() - floor_;
    if (d >= h_) continue;
    Vec3& v = particles.velocity[i];
    const Real rate = coefficient_ / h_ * (1 - d / h_) * std::sqrt(v.x() * v.x() + v.y() * v.y());
    v.head<2>() /= 1 + rate * info.dt;
  }
}

}  // namespace trevi
