#include "boundary/obstacles/body.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "boundary/waves/paddle_motion.hpp"

namespace trevi {

namespace {

// In units of h: the distance of a particle from a surface at a contact, and the smallest step along a path that skims
// a surface. A sheet thinner than this step could be passed through.
constexpr Real contact_distance = 1e-6, min_step = 0.01;
// The distance from a wall of the box within which a solid is extended to the wall, as it is for the density
// (volume_map.cpp).
constexpr Real extension = 1.0 / 32;
// Largest distance at which a solid contributes to the density, in units of h; see wall_density.hpp.
constexpr Real density_reach = 1.25;

Real radius_of(const Box& bounds) { return bounds.min.cwiseAbs().cwiseMax(bounds.max.cwiseAbs()).norm(); }

}  // namespace

Body::Body(const ObstacleSettings& obstacle, const BodyRules& rules, bool floats, const Body* like)
    : shape_(like != nullptr ? like->shape_ : make_shape(obstacle)),
      surface_(shape_->bounds()),
      revolution_(axes_of_revolution(obstacle)),
      motion_(obstacle),
      floats_(floats),
      moves_(floats || obstacle.moves()),
      vessel_(obstacle.inside),
      quick_(obstacle.shape != ShapeKind::mesh),
      whole_(rules.walls.reflection == Reflection::report),
      h_(rules.h),
      tolerance_(contact_distance * rules.h),
      restitution_(obstacle.restitution.value_or(rules.walls.restitution)),
      friction_(obstacle.friction),
      radius_(radius_of(surface_)),
      wall_extension_(extension * rules.h),
      inner_{rules.open.min.array() + wall_extension_, rules.open.max.array() - wall_extension_},
      across_((rules.open.max - rules.open.min).norm()),
      shares_(like != nullptr) {
  if (obstacle.wavemaker && obstacle.wavemaker->kind == PaddleKind::flap) hinge_ = hinge_of(*obstacle.wavemaker);
  move(0, 0);
  if (like != nullptr) {
    map_ = like->map_;
    rough_ = like->rough_;
    return;
  }
  std::optional<Fixed> fixed;
  if (!moves_) fixed = Fixed{now_, rules.box};
  map_ = std::make_shared<VolumeMap>(*shape_, rules.kernel, h_, fixed);
  if (!quick_) rough_ = std::make_shared<DistanceGrid>(*shape_, h_);
}

Box Body::box_at(const Pose& pose, Real margin) const {
  const Vec3 half = (surface_.max - surface_.min) / 2, middle = pose.into_world((surface_.max + surface_.min) / 2);
  const Vec3 extent = (pose.turn.cwiseAbs() * half).array() + margin;
  return {middle - extent, middle + extent};
}

std::array<Real, 2> Body::lowest_and_highest() const {
  const Vec3 half = (surface_.max - surface_.min) / 2;
  const Real middle = midway_.into_world((surface_.max + surface_.min) / 2).z(), along = std::abs(midway_.turn(2, 2));
  Real extent = (midway_.turn.cwiseAbs() * half).z();
  if (revolution_.trace() > 2) {  // a ball
    extent = half.z();
  } else if (revolution_.trace() > 0) {
    extent = along * half.z() + std::sqrt(std::max(1 - along * along, 0.0)) * half.x();
  }
  return {middle - extent, middle + extent};
}

void Body::place(const Pose& before, const Pose& now) {
  before_ = before;
  now_ = now;
  midway_ = midway_between(before, now);
  turned_ = (now_.turn - before_.turn).norm();
  const auto on_way = [&](Real margin) {
    const Box near = box_at(now_, margin), was = box_at(before_, margin);
    return Box{near.min.cwiseMin(was.min), near.max.cwiseMax(was.max)};
  };
  bounds_of(Extent::density) = box_at(now_, density_reach * h_);
  bounds_of(Extent::shift) = box_at(now_, 2 * wall_extension_);
  bounds_of(Extent::path) = on_way(density_reach * h_);
  went_ = (now_.center - before_.center).norm();
  // A plane between the body and both ends of a path is rotated by no more than this over the length of the path.
  const Real margin = std::min(2 * wall_extension_ + turned_ * (radius_ + across_), density_reach * h_);
  place_parts(on_way(margin), margin);
}

// What is outside of the part for the density is also out of reach by the distance, which is not computed for a mesh.
void Body::place_parts(const Box& way, Real margin) {
  constexpr Real rounding = 1 + 1e-9;
  const Real radius = shape_->bounding_radius();
  const auto around = [&](const Vec3& center, Real far) { return Ball{center, rounding * (radius + far)}; };
  auto& [density, shift, path] = parts_;
  density = {bounds_of(Extent::density), around(now_.center, quick_ ? out_of_reach * h_ : INFINITY)};
  shift = {bounds_of(Extent::shift), around(now_.center, 2 * wall_extension_)};
  path = {way, around((before_.center + now_.center) / 2, went_ / 2 + margin)};
}

void Body::rough_distances(std::span<const Vec3> p, std::span<Real> found) const {
  if (!rough_) return shape_->distances(p, found);
  for (std::size_t k = 0; k < p.size(); ++k) found[k] = rough_->at(p[k]).distance;
}

bool Body::may_meet(const Vec3& from, const Vec3& to) const {
  const Real segment = (to - from).norm(), margin = 2 * wall_extension_;
  const Vec3 low = from.cwiseMin(to), high = from.cwiseMax(to);
  if (!vessel_ &&
      ((low.array() > surface_.max.array() + margin).any() || (high.array() < surface_.min.array() - margin).any()))
    return false;
  // Blocks that are not near are 2 h from the surface.
  return !is_beyond(from, segment) && (segment >= h_ || map_->is_near(to));
}

bool Body::may_meet(const Vec3& from, Real length) const {
  const Vec3 off = (surface_.min - from).cwiseMax(from - surface_.max);
  if (!vessel_ && off.maxCoeff() > length + 2 * wall_extension_) return false;
  return !is_beyond(from, length) && (length >= h_ || map_->is_near(from));
}

bool Body::is_beyond(const Vec3& p, Real segment) const {
  const DistanceGrid::Rough rough = rough_ ? rough_->at(p) : DistanceGrid::Rough{shape_->distance(p), 0};
  return rough.distance - rough.error >
         segment + 2 * wall_extension_;  // in a corner of the box the extension is 1.7 times as wide
}

Real Body::distance(const ContactPoint& point, Real reach) const {
  const Real here = shape_->distance_within(point.in_body, reach);
  if (inner_.contains(point.in_world)) return here;
  const Vec3 in_seam = point.in_world.cwiseMax(inner_.min).cwiseMin(inner_.max) - point.in_world;
  return std::min(here, shape_->distance_within(point.in_body + now_.turn.transpose() * in_seam, reach));
}

Vec3 Body::normal(const ContactPoint& point) const {
  if (inner_.contains(point.in_world)) return shape_->normal(point.in_body);
  return slope_of(surface_, [&](const Vec3& step) {
    return distance({point.in_body + step, point.in_world + now_.turn * step}, std::numeric_limits<Real>::max());
  });
}

bool Body::may_cross(const Vec3& from, const Vec3& to) const {
  if (!rough_) return true;
  const Real length = (to - from).norm();
  for (Real s = 0; s < length;) {
    const DistanceGrid::Rough here = rough_->at(from + (to - from) * (s / length));
    const Real least = std::abs(here.distance) - here.error;
    if (least <= tolerance_) return true;
    s += least;
  }
  return false;
}

// A step by the distance itself passes through nothing. Closer than the smallest step, the step is the distance to the
// surface according to the slope along the path, plus a little more, so that the next position is in the solid if the
// path meets it. A path that skims the surface proceeds by smallest steps.
Real Body::step_from(const Segment& segment, Real s, Real d, Real threshold) const {
  const Real least = min_step * h_, small = tolerance_ / 2;
  if (d - tolerance_ >= least) return d - tolerance_;
  const Real ahead = distance(segment.at((s + small) / segment.length()), 2 * least);
  if (d - ahead < 1e-6 * small) return least;
  const Real to_surface = (d - threshold) * small / (d - ahead);
  return std::min(to_surface + small, least);
}

// The last step is halved until the point of contact is known.
std::optional<Real> Body::first_contact(const Segment& segment) const {
  const Real length = segment.length();
  if (length == 0) return std::nullopt;
  const auto at = [&](Real s) { return distance(segment.at(s / length), length - s + 0.02 * h_); };
  Real s = 0, d = at(0);
  const Real threshold = std::min(d, tolerance_);
  while (s < length && d < length - s + tolerance_) {
    Real next = std::min(s + step_from(segment, s, d, threshold), length);
    const Real there = at(next);
    if (there >= threshold) {
      s = next;
      d = there;
      continue;
    }
    constexpr int halvings = 24;
    for (int k = 0; k < halvings; ++k) {
      const Real middle = (s + next) / 2;
      (at(middle) >= threshold ? s : next) = middle;
    }
    return s / length;
  }
  return std::nullopt;
}

bool Body::covers(const Vec3& from, const Vec3& place) const {
  if (is_passed_by(from, place)) return false;
  const Segment segment{{now_.into_body(from), from}, {now_.into_body(place), place}};
  if (shape_->distance(segment.from.in_body) < -tolerance_ || shape_->distance(segment.to.in_body) < 0) return true;
  return first_contact(segment).has_value();
}

std::optional<Vec3> Body::shift_inside(const ContactPoint& end, const Vec3& normal, Real limit) const {
  const auto is_outside = [&](Real shift) {
    return distance({end.in_body + shift * normal, end.in_world + shift * (now_.turn * normal)}, h_) < tolerance_;
  };
  constexpr int doublings = 10, halvings = 24;
  Real low = 0, high = std::ldexp(limit, -doublings);
  for (int k = 0; k < doublings && is_outside(high); ++k) {
    low = high;
    high *= 2;
  }
  if (is_outside(high)) return std::nullopt;
  for (int k = 0; k < halvings; ++k) {
    const Real middle = (low + high) / 2;
    (is_outside(middle) ? low : high) = middle;
  }
  return Vec3(high * normal);
}

bool Body::is_clear(const ContactPoint& point) const {
  return is_off(point.in_body) || distance(point, h_) >= tolerance_ / 2;
}

Vec3 Body::exit_shift(const ContactPoint& point) const {
  Vec3 out = Vec3::Zero();
  if (is_off(point.in_body)) return out;
  constexpr int most = 8;  // one is enough where the nearest surface is a plane or a ball
  for (int k = 0; k < most; ++k) {
    const ContactPoint there{point.in_body + out, point.in_world + now_.turn * out};
    const Real d = distance(there, h_);
    if (d >= tolerance_ / 2) break;
    out += (2 * tolerance_ - d) * normal(there);
  }
  return out;
}

Vec3 Body::reflected(const Vec3& velocity, const Vec3& normal) const {
  const Real into = std::min(velocity.dot(normal), 0.0);
  if (whole_) return restitution_ * (velocity - 2 * into * normal);
  const Vec3 along = velocity - into * normal;
  const Real speed = along.norm(), lost = friction_ * (1 + restitution_) * -into;
  return (speed > lost ? Vec3(along * (1 - lost / speed)) : Vec3::Zero()) - restitution_ * into * normal;
}

}  // namespace trevi
