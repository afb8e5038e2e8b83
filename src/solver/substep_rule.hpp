// The rule by which a step is split: into the smallest number of equal substeps with dt v_max ≤ cfl h, dt ≤ 0.25
// √(h/|g|) and dt ≤ longest. With cfl = 0 it is never split. Collective: v_max is the largest speed over all ranks.
#pragma once

#include <cmath>

#include "trevi/clock.hpp"
#include "trevi/particles.hpp"
#include "trevi/session.hpp"

namespace trevi {

struct SubstepRule {
  Real cfl = 0;
  Real h = 0;                   ///< m
  Vec3 gravity = Vec3::Zero();  ///< m/s²
  Real longest = INFINITY;      ///< s, the longest step that viscosity allows
  int max_substeps = 500;

  /// Number of substeps of the step that begins now; `fastest_pushed`, m/s, is the speed that pumps and obstacles will
  /// give to particles within it. Throws BlowUp on all ranks alike if more than max_substeps would be needed.
  int substeps(MPI_Comm comm, const Clock& clock, const Particles& particles, Real fastest_pushed) const;
};

}  // namespace trevi
