// One obstacle: its shape, where it is at the start and at the end of a substep, and what it is to particles near it.
// Paths are followed in the frame of the obstacle, in which it stands still: the chords of a particle's path there join
// end to end from step to step, so that nothing passes the surface, however fast either of the two is. Not collective.
#pragma once

#include <memory>
#include <optional>

#include "fluid/obstacles/distance_grid.hpp"
#include "fluid/obstacles/solid_map.hpp"
#include "fluid/walls.hpp"
#include "trevi/settings.hpp"

namespace trevi {

/// What every obstacle of a scene goes by.
struct BodyRules {
  Box box;
  WallSettings walls;
  Kernel kernel;
  Real h;
};

class Body {
 public:
  Body(const ObstacleSettings& obstacle, const BodyRules& rules);

  /// From `begin` to `end`, s.
  void move(Real begin, Real end);
  /// At the end of the substep and at its start.
  const Pose& now() const { return now_; }
  const Pose& before() const { return before_; }
  const Shape& shape() const { return *shape_; }
  const SolidMap& map() const { return *map_; }
  const BodyMotion& motion() const { return motion_; }
  Real radius() const { return radius_; }  ///< of the ball around the centre that holds the surface, m
  bool moves() const { return moves_; }

  /// Whether p may have a share of density or a collision within reach, by the bounds alone.
  bool may_reach(const Vec3& p) const { return vessel_ || near_box_.contains(p); }
  bool is_near(const Vec3& p) const { return may_reach(p) && map_->is_near(now_.into_body(p)); }
  /// Whether a straight path, in the frame of the body, may meet the surface; and whether any path of that length may.
  bool may_meet(const Vec3& from, const Vec3& to) const;
  bool may_meet(const Vec3& from, Real length) const;

  std::size_t bytes() const { return map_->bytes() + (rough_ ? rough_->bytes() : 0); }

  /// The signed distance of p in the frame of the body, for the coarse grid: near the surface to a twelfth of h where
  /// exact ones take long (meshes), and further away enough to tell that it is.
  Real rough_distance(const Vec3& p) const { return rough_ ? rough_->at(p).distance : shape_->distance(p); }
  /// Whether the straight way in between may come to the surface; true where that is not known.
  bool may_cross(const Vec3& from, const Vec3& to) const;

  /// How far along the way from `from` to `to`, from 0 to 1, the surface is met; no value where it is not.
  std::optional<Real> first_contact(const Vec3& from, const Vec3& to) const;
  /// p, or where it is pushed to if it is inside of the solid.
  Vec3 outside(const Vec3& p) const;
  /// A contact's place, moved off the surface by as much as a contact is near to it, so that a path along the surface
  /// does not begin with another contact.
  Vec3 lifted(const Vec3& p) const { return p + tolerance_ * shape_->normal(p); }
  /// What a bounce at p makes of a velocity, and of a way that goes on; all in the frame of the body.
  Vec3 reflected(const Vec3& velocity, const Vec3& p) const;
  Vec3 along(const Vec3& way, const Vec3& p) const;

 private:
  // Whether p is in the open, and further than that from the surface.
  bool is_beyond(const Vec3& p, Real way) const;

  std::unique_ptr<Shape> shape_;
  BodyMotion motion_;
  bool moves_, vessel_, whole_;
  Real h_, tolerance_, restitution_, friction_, radius_;
  Pose before_, now_;
  Box near_box_;
  std::unique_ptr<SolidMap> map_;
  std::unique_ptr<DistanceGrid> rough_;  // of a mesh
};

}  // namespace trevi
