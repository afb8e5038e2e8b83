#include "fluid/obstacles/body.hpp"

#include <algorithm>
#include <cmath>

namespace trevi {

namespace {

// In units of h: how near a particle comes to a surface, and the shortest step along a path. A sheet that is thinner
// than the step could be passed.
constexpr Real contact = 1e-6, least_step = 0.01;
// Farthest that a share of density reaches, in units of h; see wall_density.hpp.
constexpr Real density_reach = 1.25;

Real radius_of(const Box& bounds) { return bounds.min.cwiseAbs().cwiseMax(bounds.max.cwiseAbs()).norm(); }

}  // namespace

Body::Body(const ObstacleSettings& obstacle, const BodyRules& rules)
    : shape_(make_shape(obstacle)),
      motion_(obstacle),
      moves_(obstacle.moves()),
      vessel_(obstacle.inside),
      whole_(rules.walls.reflection == Reflection::report),
      h_(rules.h),
      tolerance_(contact * rules.h),
      restitution_(obstacle.restitution.value_or(rules.walls.restitution)),
      friction_(obstacle.friction),
      radius_(radius_of(shape_->bounds())) {
  move(0, 0);
  std::optional<Fixed> fixed;
  if (!moves_) fixed = Fixed{now_, rules.box};
  map_ = std::make_unique<SolidMap>(*shape_, rules.kernel, h_, fixed);
  if (obstacle.shape == ShapeKind::mesh) rough_ = std::make_unique<DistanceGrid>(*shape_, h_);
}

void Body::move(Real begin, Real end) {
  before_ = motion_.at(begin);
  now_ = motion_.at(end);
  const Box bounds = shape_->bounds();
  const Vec3 half = (bounds.max - bounds.min) / 2, middle = now_.into_world((bounds.max + bounds.min) / 2);
  const Vec3 extent = (now_.turn.cwiseAbs() * half).array() + density_reach * h_;
  near_box_ = {middle - extent, middle + extent};
}

bool Body::may_meet(const Vec3& from, const Vec3& to) const {
  const Real way = (to - from).norm();
  const Box bounds = shape_->bounds();
  const Vec3 low = from.cwiseMin(to), high = from.cwiseMax(to);
  if (!vessel_ &&
      ((low.array() > bounds.max.array() + tolerance_).any() || (high.array() < bounds.min.array() - tolerance_).any()))
    return false;
  // Blocks that are not near are 2 h from the surface.
  return (way >= h_ || map_->is_near(to)) && !is_beyond(from, way);
}

bool Body::may_meet(const Vec3& from, Real length) const {
  const Box bounds = shape_->bounds();
  const Vec3 off = (bounds.min - from).cwiseMax(from - bounds.max);
  if (!vessel_ && off.maxCoeff() > length + tolerance_) return false;
  return (length >= h_ || map_->is_near(from)) && !is_beyond(from, length);
}

bool Body::is_beyond(const Vec3& p, Real way) const {
  const DistanceGrid::Rough rough = rough_ ? rough_->at(p) : DistanceGrid::Rough{shape_->distance(p), 0};
  return rough.distance - rough.error > way + 2 * tolerance_;
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

// Steps of the distance to the surface cannot pass it; the last one is halved until the place of contact is known.
std::optional<Real> Body::first_contact(const Vec3& from, const Vec3& to) const {
  const Real length = (to - from).norm(), least = least_step * h_;
  if (length == 0) return std::nullopt;
  const auto place = [&](Real s) { return Vec3(from + (to - from) * (s / length)); };
  const auto distance = [&](Real s) { return shape_->distance_within(place(s), length - s + 2 * least); };
  Real s = 0, d = distance(0);
  while (s < length && d < length - s + tolerance_) {
    Real next = std::min(s + std::max(d - tolerance_, least), length);
    const Real there = distance(next);
    if (there >= tolerance_ || (s == 0 && d < tolerance_ && there >= d)) {
      s = next;
      d = there;
      continue;
    }
    constexpr int halvings = 24;
    for (int k = 0; k < halvings; ++k) {
      const Real middle = (s + next) / 2;
      (distance(middle) >= tolerance_ ? s : next) = middle;
    }
    return s / length;
  }
  return std::nullopt;
}

Vec3 Body::outside(const Vec3& p) const {
  Vec3 place = p;
  constexpr int most = 8;  // one will do where the nearest surface is a plane or a ball
  for (int k = 0; k < most; ++k) {
    const Real d = shape_->distance_within(place, h_);
    if (d >= 0) break;
    place += (2 * tolerance_ - d) * shape_->normal(place);
  }
  return place;
}

Vec3 Body::along(const Vec3& way, const Vec3& p) const {
  const Vec3 normal = shape_->normal(p);
  return way - std::min(way.dot(normal), 0.0) * normal;
}

Vec3 Body::reflected(const Vec3& velocity, const Vec3& p) const {
  const Vec3 normal = shape_->normal(p);
  const Real into = std::min(velocity.dot(normal), 0.0);
  if (whole_) return restitution_ * (velocity - 2 * into * normal);
  const Vec3 along = velocity - into * normal;
  const Real speed = along.norm(), lost = friction_ * (1 + restitution_) * -into;
  return (speed > lost ? Vec3(along * (1 - lost / speed)) : Vec3::Zero()) - restitution_ * into * normal;
}

}  // namespace trevi
