// Simulated time, and schedules of output. The time follows from the number of steps and is never accumulated, so that
// a restart sees the same times. An output is due at the first step whose time is at least its due time − dt/2.
#pragma once

#include <cmath>
#include <cstdint>

#include "trevi/types.hpp"

namespace trevi {

struct Clock {
  std::int64_t step = 0;  ///< steps completed since the start of the run, restarts included
  Real dt = 0;            ///< length of a step, s
  int substeps = 1;       ///< number of equal parts into which the last step was split
  Real time() const { return static_cast<Real>(step) * dt; }
};

/// An interval in seconds or in steps. Where both are set, `every_steps` takes precedence; where neither is, nothing is
/// ever due.
struct Schedule {
  Real every = 0;  ///< s
  std::int64_t every_steps = 0;

  bool operator==(const Schedule&) const = default;
  bool due(const Clock& clock) const {
    if (every_steps > 0) return clock.step % every_steps == 0;
    if (every <= 0) return false;
    return clock.step == 0 || outputs_until(clock.step, clock.dt) > outputs_until(clock.step - 1, clock.dt);
  }

 private:
  std::int64_t outputs_until(std::int64_t step, Real dt) const {
    // The small allowance assigns a due time that is met only up to rounding (every = n dt + dt/2) to the earlier step.
    constexpr Real most = 1e18;  // from this count on, each step is due
    const Real until = std::floor((static_cast<Real>(step) + 0.5) * dt / every + 1e-9);
    return until < most ? static_cast<std::int64_t>(until) : static_cast<std::int64_t>(most) + step;
  }
};

}  // namespace trevi
