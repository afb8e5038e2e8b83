#include "fluid/forcings/damping.hpp"

#include "base/threads.hpp"
#include "boundary/waves/elementary.hpp"

namespace trevi {

void Damping::apply(Particles& particles, const StepInfo& info) {
  const ScopedEvent timed(event_);
  const Vec3 direction = zone_.direction.value();
  const Eigen::Index axis = direction.x() != 0 ? 0 : 1;
  const Real length = zone_.max[axis] - zone_.min[axis];
  const Real begin = direction[axis] > 0 ? zone_.min[axis] : zone_.max[axis];
  for_each_index({0, particles.size()}, [&](std::size_t i) {
    const Vec3& p = particles.position[i];
    if ((p.array() < zone_.min.array()).any() || (p.array() > zone_.max.array()).any()) return;
    const Real s = (p[axis] - begin) / length;
    particles.velocity[i] *= elementary::exp(-zone_.rate * s * s * info.dt);
  });
}

}  // namespace trevi
