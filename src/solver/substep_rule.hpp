// The rule by which a step is split: into the smallest number of equal substeps with dt v_max ≤ cfl h, dt ≤ 0.25
// √(h/a) and dt ≤ longest. With cfl = 0 it is never split. Collective: v_max is the largest speed over all ranks; a is
// |g| or the acceleration of an obstacle, whichever is larger, because water in a shaken vessel bears it as its weight.
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

  /// What pumps and obstacles will do to particles within a step.
  struct Push {
    Real speed = 0;         ///< the highest, m/s
    Real acceleration = 0;  ///< the largest of an obstacle, m/s²
  };

  /// Number of substeps of the step that begins now. Throws BlowUp on all ranks alike if more than max_substeps would
  /// be needed.
  int substeps(MPI_Comm comm, const Clock& clock, const Particles& particles, const Push& push) const;
};

}  // namespace trevi
