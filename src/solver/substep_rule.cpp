#include "solver/substep_rule.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

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
  if (!(parts * (1 - 1e-9) <= max_substeps)) {  // the same numbers on all ranks
    throw BlowUp(
        fmt::format("step {}: water of {:.4g} m/s would need {:.0f} substeps, and time.max_substeps is {}: it has "
                    "become unstable or "
                    "is crushed; use a smaller dt, look at what presses it, or raise the limit",
                    clock.step + 1, v, std::ceil(parts), max_substeps));
  }
  return std::max(1, static_cast<int>(std::ceil(parts * (1 - 1e-9))));
}

}  // namespace trevi
