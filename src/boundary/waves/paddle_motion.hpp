// Where the paddle of a wavemaker is, as a pure function of time with the same bits on any processor: what a restart
// and any number of ranks see alike. Not collective.
#pragma once

#include <vector>

#include "boundary/geometry/pose.hpp"
#include "boundary/waves/wave_theory.hpp"
#include "trevi/obstacle.hpp"

namespace trevi {

class PaddleMotion {
 public:
  explicit PaddleMotion(const WavemakerSettings& wavemaker);

  /// How far the paddle is from where it rests, at the surface of the still water along its direction, m.
  Real displacement(Real time) const;
  /// Where a body that is at `rest` without waves is by such a displacement: shifted by a piston, turned about its
  /// hinge by a flap.
  Pose pose(const Pose& rest, Real displacement) const;
  Pose at(const Pose& rest, Real time, Real offset) const { return pose(rest, displacement(time) + offset); }
  /// What the waves of linear theory that it makes have at the paddle, m above the still water: each is in phase with
  /// the speed of the paddle. The near field, a tenth of that in quadrature, is left out. Not for a solitary wave.
  Real level(Real time) const;

 private:
  Real solitary(Real time) const;

  WavemakerSettings wavemaker_;
  std::vector<PaddleComponent> components_;  // of other waves than a solitary one
  std::vector<Real> levels_;                 // m, of the wave of each component
};

/// A place of the line about which a flap turns.
Vec3 hinge_of(const WavemakerSettings& flap);

/// The farthest that a paddle goes to either side of its rest, m; irregular waves by four standard deviations.
Real paddle_reach(const WavemakerSettings& wavemaker);

}  // namespace trevi
