// The six walls of the box (Algorithm 3 of the report): where a moving particle ends up, and where a shifted one stops.
// One particle at a time, metres and seconds; a particle inside the closed box stays inside at any speed. Not
// collective.
#pragma once

#include <algorithm>

#include "domain/slabs.hpp"
#include "trevi/box.hpp"
#include "trevi/settings.hpp"

namespace trevi {

class Walls {
 public:
  /// `tolerance`: how far inside the plane a shift stops in the report's reading, m (1e-6 h).
  Walls(const Box& box, const WallSettings& settings, Real tolerance);

  /// Velocity part: p + v dt with a bounce at each plane met. Reflection "normal" damps the component along the plane's
  /// normal, "report" the whole velocity.
  Vec3 predict(const Vec3& p, const Vec3& v, Real dt) const;

  /// Δp part: p + shift, stopped at the planes: per axis, or ("report") on the ray at the first plane, `tolerance`
  /// inside.
  Vec3 collide(const Vec3& p, const Vec3& shift) const {
    const Vec3 target = p + shift;
    if (inside(target)) return target;
    return along_ray_ ? stop_on_ray(p, shift) : clamp(target);
  }

  // std::clamp lets a NaN be one, which Eigen's cwiseMin need not: the guard of the step looks for it.
  Vec3 clamp(const Vec3& p) const {
    const Vec3 &low = box_.min, &high = box_.max;
    return {std::clamp(p.x(), low.x(), high.x()), std::clamp(p.y(), low.y(), high.y()),
            std::clamp(p.z(), low.z(), high.z())};
  }
  bool inside(const Vec3& p) const {
    return (p.array() >= box_.min.array()).all() && (p.array() <= box_.max.array()).all();
  }

 private:
  Vec3 stop_on_ray(const Vec3& p, const Vec3& shift) const;

  Box box_;
  Real restitution_, tolerance_;
  bool along_ray_;
};

}  // namespace trevi
