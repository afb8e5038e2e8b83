// The position of the paddle of a wavemaker, as a pure function of time with the same bits on any processor: it is the
// same after a restart and on any number of ranks. Not collective.
#pragma once

#include <vector>

#include "boundary/geometry/pose.hpp"
#include "boundary/waves/wave_theory.hpp"
#include "trevi/obstacle.hpp"

namespace trevi {

class PaddleMotion {
 public:
  explicit PaddleMotion(const WavemakerSettings& wavemaker);

  /// Displacement of the paddle from its position at rest, at the surface of the still water along its direction, m.
  Real displacement(Real time) const;
  /// The pose of a body that is at `rest` without waves, for such a displacement: shifted by a piston, rotated about
  /// its hinge by a flap.
  Pose pose(const Pose& rest, Real displacement) const;
  Pose at(const Pose& rest, Real time, Real offset) const { return pose(rest, displacement(time) + offset); }
  /// The level at the paddle of the waves that it makes according to linear theory, m above the still water: each is in
  /// phase with the speed of the paddle. The near field, a tenth of that in quadrature, is left out. Not for a solitary
  /// wave.
  Real level(Real time) const;

 private:
  Real solitary(Real time) const;

  WavemakerSettings wavemaker_;
  std::vector<PaddleComponent> components_;  // of waves other than a solitary one
  std::vector<Real> levels_;                 // m, of the wave of each component
};

/// A point on the axis about which a flap rotates.
Vec3 hinge_of(const WavemakerSettings& flap);

/// The largest distance of a paddle from its rest to either side, m; for irregular waves four standard deviations.
Real paddle_reach(const WavemakerSettings& wavemaker);

}  // namespace trevi
