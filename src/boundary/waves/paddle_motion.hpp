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
  Pose at(const Pose& rest, Real time) const { return pose(rest, displacement(time)); }

 private:
  Real solitary(Real time) const;

  WavemakerSettings wavemaker_;
  std::vector<PaddleComponent> components_;  // of other waves than a solitary one
};

/// The farthest that a paddle goes to either side of its rest, m; irregular waves by four standard deviations.
Real paddle_reach(const WavemakerSettings& wavemaker);

}  // namespace trevi
