#include "boundary/geometry/periods.hpp"

#include <fmt/format.h>

#include <cmath>

#include "boundary/geometry/pose.hpp"
#include "boundary/geometry/shape.hpp"

namespace trevi {
namespace {

// The box in the world that the corners of a box sweep as they go around an axis through the centre; the box and the
// axis are in the frame of a shape.
Box swept_by(const Box& bounds, const Vec3& axis, const Pose& pose) {
  const Vec3 direction = pose.turn * axis;
  Box swept{Vec3::Constant(INFINITY), Vec3::Constant(-INFINITY)};
  for (int n = 0; n < 8; ++n) {
    const Vec3 corner((n & 1 ? bounds.max : bounds.min).x(), (n & 2 ? bounds.max : bounds.min).y(),
                      (n & 4 ? bounds.max : bounds.min).z());
    const Real along = corner.dot(axis), around = (corner - along * axis).norm();
    const Vec3 middle = pose.center + along * direction;
    const Vec3 reach = around * (1 - direction.array().square()).max(0).sqrt();
    swept = {swept.min.cwiseMin(middle - reach), swept.max.cwiseMax(middle + reach)};
  }
  return swept;
}

// The box of its surface; for a rotating obstacle, at any time.
Box place_of(const ObstacleSettings& obstacle) {
  const Box bounds = bounds_of(obstacle);
  const Pose pose = BodyMotion(obstacle).at(0);
  const Vec3 turning = obstacle.oscillation ? obstacle.oscillation->rotation : obstacle.angular_velocity;
  if (Vec3 axis = pose.turn.transpose() * turning; axis.norm() > 0) {
    axis.normalize();
    constexpr Real rounding = 1e-9;
    if ((axes_of_revolution(obstacle) * axis - axis).norm() > rounding) return swept_by(bounds, axis, pose);
  }
  const Vec3 middle = pose.into_world((bounds.max + bounds.min) / 2);
  const Vec3 half = pose.turn.cwiseAbs() * (bounds.max - bounds.min) / 2;
  return {middle - half, middle + half};
}

bool is_along(Vec3 direction, int axis) {
  direction[axis] = 0;
  return direction.isZero();
}

// Whether it is straight along an axis, with the same cross-section everywhere; a cylinder may rotate about the axis.
bool is_straight(const ObstacleSettings& obstacle, int axis) {
  if (!obstacle.rotate.isZero()) return false;
  if (obstacle.wavemaker) return obstacle.wavemaker->direction[axis] == 0;
  if (obstacle.shape == ShapeKind::box) return !obstacle.moves();
  return obstacle.shape == ShapeKind::cylinder && is_along(obstacle.axis, axis) &&
         is_along(obstacle.angular_velocity, axis);
}

bool fits(const ObstacleSettings& obstacle, const Box& place, const Settings& settings, int axis) {
  const Real least = 2 * settings.fluid.kernel_radius;
  const Box& box = settings.domain;
  const bool away = place.min[axis] >= box.min[axis] + least && place.max[axis] <= box.max[axis] - least;
  const bool through = place.min[axis] <= box.min[axis] - least && place.max[axis] >= box.max[axis] + least;
  return away || (through && is_straight(obstacle, axis));
}

}  // namespace

std::string why_not_periodic(const ObstacleSettings& obstacle, const Settings& settings) {
  if (settings.periodic == std::array<bool, 3>{}) return "";
  if (!obstacle.velocity.isZero() || !obstacle.knots.empty() ||
      (obstacle.oscillation && !obstacle.oscillation->amplitude.isZero()))
    return "goes places, which it cannot in a box with periodic axes; leave out its velocity or motion, or "
           "[domain] periodic";
  const Box place = place_of(obstacle);
  for (int a = 0; a < 3; ++a) {
    if (!settings.periodic[static_cast<std::size_t>(a)] || fits(obstacle, place, settings, a)) continue;
    if (obstacle.wavemaker && obstacle.wavemaker->direction[a] != 0)
      return fmt::format("makes waves along {0}, where the box has no ends; leave {0} out of [domain] periodic",
                         "xyz"[a]);
    return fmt::format(
        "reaches from {0} = {1:.6g} to {2:.6g} m, and has no image beyond an end of a periodic axis; keep it {3:.6g} m "
        "(two kernel radii) from both ends, or let a box or a cylinder along {0} go as far beyond both",
        "xyz"[a], place.min[a], place.max[a], 2 * settings.fluid.kernel_radius);
  }
  return "";
}

}  // namespace trevi
