// How a step is split: into the least number of equal substeps with dt v_max ≤ cfl h, dt ≤ 0.25 √(h/|g|) and dt ≤
// longest. With cfl = 0 it is never split. Collective: v_max is the largest speed over all ranks.
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
  Real longest = INFINITY;      ///< s, the longest step that viscosity allows

  /// Number of substeps of the step that begins now; pumps that start within it count. Throws BlowUp on all ranks alike
  /// where more than a million would be needed.
  int substeps(MPI_Comm comm, const Clock& clock, const Particles& particles,
               const std::vector<std::unique_ptr<Forcing>>& forcings) const;
};

}  // namespace trevi
