#include "boundary/geometry/pose.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "boundary/waves/paddle_motion.hpp"

namespace trevi {

namespace {

// By Taylor series, for |x| up to pi/4, where the omitted terms are below 1e-17.
Real sine_of(Real x) {
  const Real y = x * x;
  Real sum = 0;
  for (int n = 17; n >= 3; n -= 2) sum = (1 + sum) * (-y / (n * (n - 1)));
  return x * (1 + sum);
}
Real cosine_of(Real x) {
  const Real y = x * x;
  Real sum = 0;
  for (int n = 18; n >= 2; n -= 2) sum = (1 + sum) * (-y / (n * (n - 1)));
  return 1 + sum;
}

// The smallest rotation that takes z to the axis; its columns are the axes of the body.
Rotation turn_of_axis(const Vec3& axis) {
  const Vec3 z = axis / axis.norm();
  if (z.x() == 0 && z.y() == 0) return z.z() < 0 ? turn_about(Vec3::UnitX(), 0.5) : Rotation::Identity();
  Vec3 y(-z.y(), z.x(), 0);
  y /= y.norm();
  Rotation turn;
  turn.col(0) = Vec3(y.y() * z.z() - y.z() * z.y(), y.z() * z.x() - y.x() * z.z(), y.x() * z.y() - y.y() * z.x());
  turn.col(1) = y;
  turn.col(2) = z;
  return turn;
}

Rotation start_of(const ObstacleSettings& obstacle) {
  constexpr Real degrees = 360;
  return turn_about(Vec3::UnitZ(), obstacle.rotate.z() / degrees) *
         turn_about(Vec3::UnitY(), obstacle.rotate.y() / degrees) *
         turn_about(Vec3::UnitX(), obstacle.rotate.x() / degrees) * turn_of_axis(obstacle.axis);
}

}  // namespace

Pose midway_between(const Pose& from, const Pose& to) {
  const Vec3 center = (from.center + to.center) / 2;
  if (from.turn == to.turn) return {center, to.turn};
  const Eigen::Quaterniond start(from.turn), end(to.turn);
  const Real sign = start.dot(end) < 0 ? -1 : 1;
  return {center, Eigen::Quaterniond(start.coeffs() + sign * end.coeffs()).normalized().toRotationMatrix()};
}

SineCosine sine_cosine_of_turns(Real turns) {
  const Real quarters = std::floor(4 * turns + 0.5);
  const Real x = 2 * std::numbers::pi * (turns - quarters / 4);
  const Real s = sine_of(x), c = cosine_of(x);
  switch (static_cast<int>(quarters - 4 * std::floor(quarters / 4))) {
    case 1:
      return {c, -s};
    case 2:
      return {-s, -c};
    case 3:
      return {-c, s};
    default:
      return {s, c};
  }
}

Rotation turn_about(const Vec3& axis, Real turns) {
  const auto [s, c] = sine_cosine_of_turns(turns);
  Rotation cross;
  cross << 0, -axis.z(), axis.y(), axis.z(), 0, -axis.x(), -axis.y(), axis.x(), 0;
  return c * Rotation::Identity() + s * cross + (1 - c) * axis * axis.transpose();
}

BodyMotion::BodyMotion(const ObstacleSettings& obstacle)
    : center_(obstacle.center),
      velocity_(obstacle.velocity),
      spin_axis_(Vec3::UnitZ()),
      turns_per_second_(obstacle.angular_velocity.norm() / (2 * std::numbers::pi)),
      start_(start_of(obstacle)),
      knots_(obstacle.knots),
      oscillation_(obstacle.oscillation) {
  if (obstacle.wavemaker) paddle_ = std::make_shared<const PaddleMotion>(*obstacle.wavemaker);
  if (turns_per_second_ > 0) spin_axis_ = obstacle.angular_velocity / obstacle.angular_velocity.norm();
}

Pose BodyMotion::at(Real time, Real offset) const {
  if (paddle_) return paddle_->at({center_, start_}, time, offset);
  if (oscillation_) {
    const auto& [amplitude, rotation, period, ramp] = *oscillation_;
    const Real u = ramp > 0 ? std::clamp(time / ramp, 0.0, 1.0) : 1;
    const Real factor = u * u * (3 - 2 * u) * sine_cosine_of_turns(time / period).sine;
    const Real degrees = rotation.norm();
    if (degrees == 0) return {center_ + factor * amplitude, start_};
    return {center_ + factor * amplitude, turn_about(rotation / degrees, factor * degrees / 360) * start_};
  }
  const Vec3 center = knots_.empty() ? Vec3(center_ + velocity_ * time) : center_at(time);
  if (turns_per_second_ == 0) return {center, start_};
  return {center, turn_about(spin_axis_, turns_per_second_ * time) * start_};
}

// In m/s, from the neighbours of a knot; the ends are at rest.
Vec3 BodyMotion::slope_at(std::size_t knot) const {
  if (knot == 0 || knot + 1 == knots_.size()) return Vec3::Zero();
  return (knots_[knot + 1].center - knots_[knot - 1].center) / (knots_[knot + 1].time - knots_[knot - 1].time);
}

Vec3 BodyMotion::center_at(Real time) const {
  if (time <= knots_.front().time) return knots_.front().center;
  if (time >= knots_.back().time) return knots_.back().center;
  const auto next =
      std::upper_bound(knots_.begin(), knots_.end(), time, [](Real t, const ObstacleKnot& k) { return t < k.time; });
  const auto k = static_cast<std::size_t>(next - knots_.begin()) - 1;
  const Real span = knots_[k + 1].time - knots_[k].time, t = (time - knots_[k].time) / span, u = 1 - t;
  return u * u * (1 + 2 * t) * knots_[k].center + t * t * (1 + 2 * u) * knots_[k + 1].center +
         span * t * u * (u * slope_at(k) - t * slope_at(k + 1));
}

// For cubics and paddles, from samples; between these they curve too little to affect the choice of substeps.
Real BodyMotion::fastest(Real begin, Real end, Real radius) const {
  if (oscillation_) {  // a bound that holds at all times
    const auto& [amplitude, rotation, period, ramp] = *oscillation_;
    const Real rate = 2 * std::numbers::pi / period + (ramp > 0 && begin < ramp ? 1.5 / ramp : 0);
    return rate * (amplitude.norm() + rotation.norm() * std::numbers::pi / 180 * radius);
  }
  const Real spin = 2 * std::numbers::pi * turns_per_second_ * radius;
  if (knots_.empty() && !paddle_) return velocity_.norm() + spin;
  const auto place = [this](Real time) {  // of a paddle at the surface of the water
    return paddle_ ? Vec3(paddle_->displacement(time) * Vec3::UnitX()) : center_at(time);
  };
  constexpr int samples = 8;
  Real most = 0;
  Vec3 last = place(begin);
  for (int k = 1; k <= samples; ++k) {
    const Vec3 next = place(begin + (end - begin) * k / samples);
    most = std::max(most, (next - last).norm() * samples / (end - begin));
    last = next;
  }
  return most + spin;
}

// By second differences. That of a rotation has two equal singular values, and the third is 0.
Real BodyMotion::acceleration(Real begin, Real end, Real radius, Real h) const {
  const Real speed = fastest(begin, end, radius);
  if (speed == 0) return 0;
  const Real span = std::max(end - begin, h / speed), middle = std::max((begin + end) / 2, span);
  if (paddle_) {  // at the surface of the water
    const Real before = paddle_->displacement(middle - span), after = paddle_->displacement(middle + span);
    return std::abs(before - 2 * paddle_->displacement(middle) + after) / (span * span);
  }
  const Pose before = at(middle - span), now = at(middle), after = at(middle + span);
  const Vec3 center = before.center - 2 * now.center + after.center;
  const Rotation axes = before.turn - 2 * now.turn + after.turn;
  return (center.norm() + radius * axes.norm() / std::numbers::sqrt2) / (span * span);
}

}  // namespace trevi
