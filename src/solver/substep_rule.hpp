// How a step is split: into n equal substeps with dt v_max ≤ cfl h, dt ≤ 0.25 √(h/|g|) and dt ≤ longest; never, where
// cfl is 0. Collective: the speed is the largest over all ranks.
#pragma once

#include <cmath>

#include "trevi/clock.hpp"
#include "trevi/forcing.hpp"
#include "trevi/session.hpp"

namespace trevi {

struct SubstepRule {
  Real cfl = 0;
  Real h = 0;                   ///< m
  Vec3 gravity = Vec3::Zero();  ///< m/s²
  Real longest = INFINITY;      ///< s, what viscosity allows

  /// For the step that begins now; a pump that starts within it counts. Throws BlowUp on all ranks alike for absurd
  /// speeds.
  int substeps(MPI_Comm comm, const Clock& clock, const Particles& particles,
               const std::vector<std::unique_ptr<Forcing>>& forcings) const;
};

}  // namespace trevi
