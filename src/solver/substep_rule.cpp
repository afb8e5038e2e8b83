#include "solver/substep_rule.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "base/threads.hpp"
#include "parallel/reductions.hpp"
#include "trevi/error.hpp"

namespace trevi {

int SubstepRule::substeps(MPI_Comm comm, const Clock& clock, const Particles& particles, const Push& push) const {
  if (cfl <= 0) return 1;
  const Real dt = clock.dt, a = std::max(gravity.norm(), push.acceleration);
  const Real v2 = largest({0, particles.size()}, 0, [&](std::size_t i) { return particles.velocity[i].squaredNorm(); });
  const Real v = std::max(std::sqrt(max_over_ranks(comm, v2)), push.speed);
  const Real by_speed = dt * v / (cfl * h);
  const Real by_weight = a > 0 ? dt / (0.25 * std::sqrt(h / a)) : 0;
  const Real parts = std::max({by_speed, by_weight, dt / longest});
  if (!(parts * (1 - 1e-9) <= max_substeps)) {  // the same numbers on all ranks
    const bool shaken = by_weight >= std::max(by_speed, dt / longest) && push.acceleration > gravity.norm();
    throw BlowUp(fmt::format(
        "step {}: {} would need {:.0f} substeps, and time.max_substeps is {}: {}", clock.step + 1,
        shaken ? fmt::format("an obstacle that is accelerated by {:.4g} m/s²", push.acceleration)
               : fmt::format("water of {:.4g} m/s", v),
        std::ceil(parts), max_substeps,
        shaken ? "look at its motion, use a smaller dt, or raise the limit"
               : "it has become unstable or is crushed; use a smaller dt, look at what presses it, or raise "
                 "the limit"));
  }
  return std::max(1, static_cast<int>(std::ceil(parts * (1 - 1e-9))));
}

}  // namespace trevi
