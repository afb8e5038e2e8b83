#include "solver/substep_rule.hpp"

#include <algorithm>

#include "base/threads.hpp"
#include "parallel/reductions.hpp"
#include "trevi/error.hpp"

namespace trevi {

int SubstepRule::substeps(MPI_Comm comm, const Clock& clock, const Particles& particles, Real fastest_pushed) const {
  if (cfl <= 0) return 1;
  const Real dt = clock.dt, g = gravity.norm();
  const Real v2 = largest({0, particles.size()}, 0, [&](std::size_t i) { return particles.velocity[i].squaredNorm(); });
  const Real v = std::max(std::sqrt(max_over_ranks(comm, v2)), fastest_pushed);
  const Real by_speed = dt * v / (cfl * h);
  const Real by_gravity = g > 0 ? dt / (0.25 * std::sqrt(h / g)) : 0;
  const Real parts = std::max({by_speed, by_gravity, dt / longest});
  if (!(parts < 1e6)) {  // the same numbers on all ranks
    throw BlowUp("step " + std::to_string(clock.step + 1) + ": " + std::to_string(v) +
                 " m/s would need more than a million substeps: the run has become unstable; use a smaller dt");
  }
  return std::max(1, static_cast<int>(std::ceil(parts * (1 - 1e-9))));
}

}  // namespace trevi
