// The position and orientation of an obstacle as a pure function of time: the same bits on any rank, processor and
// version of the C library, which the sine and cosine of the library would not give. Not collective.
#pragma once

#include <memory>

#include "trevi/obstacle.hpp"

namespace trevi {

class PaddleMotion;

using Rotation = Eigen::Matrix3d;

/// World = center + turn · body.
struct Pose {
  Vec3 center = Vec3::Zero();
  Rotation turn = Rotation::Identity();
  Vec3 into_body(const Vec3& p) const {
    const Vec3 away = p - center;
    return turn.transpose().lazyProduct(away);  // without a function call
  }
  Vec3 into_world(const Vec3& body) const { return center + turn * body; }
};

/// The pose midway between two, rotated half as far as from one to the other, the short way; the pose itself if they
/// are the same.
Pose midway_between(const Pose& from, const Pose& to);

struct SineCosine {
  Real sine, cosine;
};
/// Accurate to 1e-15; exact for multiples of a quarter turn. The unit is one whole turn.
SineCosine sine_cosine_of_turns(Real turns);

/// Rotation by an angle, in whole turns, about a unit vector (Rodrigues).
Rotation turn_about(const Vec3& axis, Real turns);

class BodyMotion {
 public:
  explicit BodyMotion(const ObstacleSettings& obstacle);
  /// `offset`: for a paddle, from the stroke of its own waves, m.
  Pose at(Real time, Real offset = 0) const;
  /// The largest speed that any point of the obstacle within `radius` of its centre has between these times, m/s.
  Real fastest(Real begin, Real end, Real radius) const;
  /// The largest acceleration of points of the obstacle within `radius` of its centre, of a paddle that at the surface
  /// of the water, m/s²: by the second difference over a step, or over the time in which the fastest of these points
  /// moves by h, whichever is longer, to both sides of the middle of the step. Near the start it is that about the
  /// first such time. A rotation counts whatever the shape.
  Real acceleration(Real begin, Real end, Real radius, Real h) const;

 private:
  Vec3 slope_at(std::size_t knot) const;
  Vec3 center_at(Real time) const;

  Vec3 center_, velocity_, spin_axis_;
  Real turns_per_second_;
  Rotation start_;
  std::vector<ObstacleKnot> knots_;
  std::optional<Oscillation> oscillation_;
  std::shared_ptr<const PaddleMotion> paddle_;  // null without a wavemaker
};

}  // namespace trevi
