// The six walls of the box: where a moving particle ends up, and where a shifted one stops (inputs/README.md, Walls).
// One particle at a time; metres and seconds. A particle inside the closed box stays inside at any speed. Not
// collective.
#pragma once

#include <algorithm>
#include <array>

#include "domain/slabs.hpp"
#include "trevi/box.hpp"
#include "trevi/settings.hpp"

namespace trevi {

/// The first plane that a path meets: its axis, −1 if there is none, and the time, s.
struct WallHit {
  int axis = -1;
  Real t = 0;
};

/// The box, with walls so far away that nothing reaches them along axes without walls: periodic ones, and y in two
/// dimensions.
Box box_of_walls(const Settings& settings);

class Walls {
 public:
  /// `tolerance`: how far inside the plane a shift stops with reflection "report", m (1e-6 h).
  Walls(const Box& box, const WallSettings& settings, Real tolerance);

  /// Motion with a velocity: p + v dt, with a bounce at each plane that is met. Reflection "normal" scales the
  /// component along the plane's normal by the restitution, "report" the whole velocity.
  Vec3 predict(const Vec3& p, const Vec3& v, Real dt) const;

  /// Shift by the density solve: p + shift, clamped at the planes for each axis separately, or, with reflection
  /// "report", stopped where the shift meets the first plane, `tolerance` inside.
  Vec3 collide(const Vec3& p, const Vec3& shift) const {
    const Vec3 target = p + shift;
    if (inside(target)) return target;
    return along_ray_ ? stop_on_ray(p, shift) : clamp(target);
  }

  // std::clamp returns a NaN unchanged, which Eigen's cwiseMin need not do: the guard of the run checks for NaNs.
  Vec3 clamp(const Vec3& p) const {
    const Vec3 &low = box_.min, &high = box_.max;
    return {std::clamp(p.x(), low.x(), high.x()), std::clamp(p.y(), low.y(), high.y()),
            std::clamp(p.z(), low.z(), high.z())};
  }
  bool inside(const Vec3& p) const { return box_.contains(p); }
  const Box& box() const { return box_; }

  /// The steps of predict(), for paths that also meet other things: the first plane that p + t v meets before t_end,
  /// and the position and the velocity after it has been met.
  WallHit first_hit(const Vec3& p, const Vec3& v, Real t_end) const;
  void bounce(const WallHit& hit, Vec3& position, Vec3& velocity) const;

 private:
  Vec3 stop_on_ray(const Vec3& p, const Vec3& shift) const;

  Box box_;
  Real restitution_, tolerance_;
  bool along_ray_;
};

}  // namespace trevi
