// The part of the ball of the density kernel, or of its disc in two dimensions, that lies behind a plane, as a fraction
// of its integral: V(d) for a plane at distance d, from 1 at −h over ½ at 0 to 0 at h. The inverse converts the volume
// fraction of any solid into the distance of the plane with the same fraction. The solid then contributes to a
// particle's density as a wall of the box at this distance does. Not collective.
#pragma once

#include <vector>

#include "kernels/kernels.hpp"

namespace trevi {

class PlaneVolume {
 public:
  PlaneVolume(const Kernel& kernel, Real h);
  Real fraction(Real distance) const;
  /// From −h for a fraction of 1 to h for 0.
  Real distance(Real fraction) const;

 private:
  Real h_;
  std::vector<Real> fraction_;  // at distances from 0 to h in equal steps
};

}  // namespace trevi
