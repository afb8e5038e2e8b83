// One obstacle: its shape, where it is at the start and at the end of a substep, and what it is to particles near it.
// Paths are followed in the frame of the obstacle, in which it stands still: the chords of a particle's path there join
// end to end from step to step, so that nothing passes the surface, however fast either of the two is. A solid that
// comes to a wall of the box goes on to it as it is a little inside: nothing slips past its edge along the wall. Not
// collective.
#pragma once

#include <algorithm>
#include <array>
#include <memory>
#include <optional>
#include <span>

#include "boundary/geometry/distance_grid.hpp"
#include "boundary/obstacles/open_space.hpp"
#include "boundary/volume_map/volume_map.hpp"
#include "boundary/walls.hpp"
#include "trevi/settings.hpp"

namespace trevi {

/// What every obstacle of a scene goes by. `open`: the box between its walls, which is larger where it repeats.
struct BodyRules {
  Box box, open;
  WallSettings walls;
  Kernel kernel;
  Real h;
};

/// A place as a body sees it, from its own frame, and where that is in the world.
struct ContactPoint {
  Vec3 in_body, in_world;
};

/// A straight piece of a particle's path, in both frames.
struct Segment {
  ContactPoint from, to;
  Real length() const { return (to.in_body - from.in_body).norm(); }
  ContactPoint at(Real part) const {
    return {from.in_body + part * (to.in_body - from.in_body), from.in_world + part * (to.in_world - from.in_world)};
  }
};

/// What an obstacle may reach: places whose density it adds to; what a shift may meet, with the obstacle where it is
/// now; and what a path of the substep may meet, from where the obstacle is at its start to where it is at its end.
enum class Extent { density, shift, path };

class Body {
 public:
  /// `floats`: it is one that others place().
  /// `like`: one that moves and is of the same shape, whose map it shares, if any.
  Body(const ObstacleSettings& obstacle, const BodyRules& rules, bool floats = false, const Body* like = nullptr);

  /// From `begin` to `end`, s.
  void move(Real begin, Real end) { place(motion_.at(begin, offset_before_), motion_.at(end, offset_now_)); }
  /// Where it is at the start of the substep and at its end.
  void place(const Pose& before, const Pose& now);
  /// Of a paddle from the stroke of its own waves at the ends of the next move, m.
  void set_paddle_offset(Real begin, Real end) { offset_before_ = begin, offset_now_ = end; }
  Real paddle_offset() const { return offset_now_; }
  /// At the end of the substep and at its start.
  const Pose& now() const { return now_; }
  const Pose& before() const { return before_; }
  /// Midway in the substep: the projection sees it there, as it sees the motion of particles.
  const Pose& midway() const { return midway_; }
  /// Displacement in the substep of the point of it that is at p midway, m.
  Vec3 displacement_at(const Vec3& p) const {
    const Vec3 there = midway_.into_body(p);
    return now_.into_world(there) - before_.into_world(there);
  }
  /// About what moments of forces are taken: the centre, of a flap its hinge. The centre of its box is the length of
  /// the tank away: what its arc is longer than its chord, times the force, would be more than the work.
  const Vec3& pivot() const { return hinge_ ? *hinge_ : midway_.center; }
  const Shape& shape() const { return *shape_; }
  const VolumeMap& map() const { return *map_; }
  const BodyMotion& motion() const { return motion_; }
  /// Where the surface is midway.
  Box surface_box() const { return box_at(midway_, 0); }
  Real radius() const { return radius_; }  ///< of the ball around the centre that holds the surface, m
  bool moves() const { return moves_; }
  bool is_vessel() const { return vessel_; }
  Real restitution() const { return restitution_; }

  /// Whether p may have a contribution to its density or a collision within reach, by the bounds alone.
  bool may_reach(const Vec3& p) const { return vessel_ || bounds_of(Extent::density).contains(p); }
  /// Whether p, in its frame, is so far from the surface that the density has nothing of it, as far as that is quickly
  /// told.
  bool is_out_of_reach(const Vec3& p) const { return !rough_ && is_out_of_reach(shape_->distance(p)); }
  /// By the distances of places in its frame, or anything where they are not quickly told.
  void quick_distances(std::span<const Vec3> p, std::span<Real> found) const {
    if (!rough_) shape_->distances(p, found);
  }
  bool is_out_of_reach(Real quick_distance) const { return !rough_ && quick_distance > out_of_reach * h_; }
  /// Whether a straight path in the world, the obstacle where it is now, stays on one side of its surface.
  bool is_passed_by(const Vec3& from, const Vec3& to) const {
    const Box& surface = bounds_of(Extent::shift);
    const auto low = from.cwiseMax(to).array() < surface.min.array();
    const auto high = from.cwiseMin(to).array() > surface.max.array();
    return !vessel_ && (low.any() || high.any());
  }
  /// Whether a straight path in the world cannot meet it in the substep, wherever it is in between.
  bool is_out_of_way(const Vec3& from, const Vec3& to) const {
    const auto low = from.cwiseMax(to).array() < reach().min.array();
    const auto high = from.cwiseMin(to).array() > reach().max.array();
    return !vessel_ && (low.any() || high.any()) && turns_little((to - from).norm());
  }
  /// What holds all that it may reach in the substep; has_bounds(): that a path of up to `length` along each axis
  /// outside of it cannot meet the surface.
  const Box& reach() const { return bounds_of(Extent::path); }
  bool has_bounds(Real length) const { return !vessel_ && turns_little(1.75 * length); }
  /// The part of space outside of which no place in the box of the walls, and no path there, has to do with it; null
  /// where there is none. Paths of what turns by itself are a question of their lengths.
  const ClosedPart* part(Extent extent) const {
    const bool by_length = extent == Extent::path && turned_ != 0 && !floats_;
    return vessel_ || by_length ? nullptr : &parts_[static_cast<std::size_t>(extent)];
  }
  bool is_near(const Vec3& p) const {
    if (!may_reach(p)) return false;
    const Vec3 there = now_.into_body(p);
    return !is_out_of_reach(there) && map_->is_near(there);
  }
  /// Whether a straight path, in the frame of the body, may meet the surface; and whether any path of that length may.
  bool may_meet(const Vec3& from, const Vec3& to) const;
  bool may_meet(const Vec3& from, Real length) const;

  std::size_t bytes() const { return shares_ ? 0 : map_->bytes() + (rough_ ? rough_->bytes() : 0); }

  /// The signed distance of p in the frame of the body, for the coarse grid: near the surface to a twelfth of h where
  /// exact ones take long (meshes), and further away enough to tell that it is.
  Real rough_distance(const Vec3& p) const { return rough_ ? rough_->at(p).distance : shape_->distance(p); }
  void rough_distances(std::span<const Vec3> p, std::span<Real> found) const;
  /// Whether that is not the distance itself.
  bool is_rough() const { return rough_ != nullptr; }
  /// Whether the straight segment in between may come to the surface; true where that is not known.
  bool may_cross(const Vec3& from, const Vec3& to) const;

  /// Whether one of two places is in the solid, or the straight line between them meets it.
  bool covers(const Vec3& from, const Vec3& place) const;
  /// How far along the segment, from 0 to 1, the surface is met; no value where it is not. A segment that begins nearer
  /// to the surface than contacts are meets it where it comes nearer still.
  std::optional<Real> first_contact(const Segment& segment) const;
  /// Whether a path can be at that place: no nearer to the surface than half of what contacts are.
  bool is_clear(const ContactPoint& point) const;
  /// The shift that takes a spot out of the solid if it is inside or all but so, in the frame of the body.
  Vec3 exit_shift(const ContactPoint& point) const;
  /// The shift off the surface at a contact, by as much as a contact is near to it, so that a path along the surface
  /// does not begin with another contact.
  Vec3 contact_offset(const Vec3& normal) const { return tolerance_ * normal; }
  /// The least shift along `normal`, in the frame of the body, that takes the end of a path to where contacts are; none
  /// if a shift of `limit`, m, does not.
  std::optional<Vec3> shift_inside(const ContactPoint& end, const Vec3& normal, Real limit) const;
  Vec3 normal(const ContactPoint& point) const;
  /// What a bounce makes of a velocity, and of the rest of a path; all in the frame of the body.
  Vec3 reflected(const Vec3& velocity, const Vec3& normal) const;
  static Vec3 along(const Vec3& rest, const Vec3& normal) { return rest - std::min(rest.dot(normal), 0.0) * normal; }

 private:
  // Of h: the reach, and a little for what lies between the nodes of the map.
  static constexpr Real out_of_reach = 1.4;
  // Whether it turns by so little in the substep that the chord of a path of that length, which is straight in the
  // frame of the body, stays off the surface where the path is out of reach. A chord that comes to a body of radius r
  // is no longer than 1.2 (length + way of the centre) + 0.2 r at turns below 0.1, and the turn bends it by as much
  // times the angle, while the reach is more than h. Bodies that float turn by little.
  bool turns_little(Real length) const {
    return turned_ == 0 || floats_ || (turned_ < 0.1 && turned_ * (1.2 * (length + went_) + 0.2 * radius_) < h_);
  }
  // Whether a place is so far out of the bounds that its distance is more than contacts are.
  bool is_off(const Vec3& p) const {
    return !vessel_ && (surface_.min - p).cwiseMax(p - surface_.max).maxCoeff() > 2 * wall_extension_;
  }
  // Whether p is in the open, and further than that from the surface.
  bool is_beyond(const Vec3& p, Real segment) const;
  // Distance to the surface, that which goes on to the walls included; just `reach` where it is as far.
  Real distance(const ContactPoint& point, Real reach) const;
  Real step_from(const Segment& segment, Real s, Real d, Real threshold) const;

  std::shared_ptr<const Shape> shape_;
  Box surface_;  // its bounds, in the frame of the body
  BodyMotion motion_;
  std::optional<Vec3> hinge_;                     // of a flap
  bool floats_, moves_, vessel_, quick_, whole_;  // quick_: distances are
  Real h_, tolerance_, restitution_, friction_, radius_;
  Real wall_extension_;  // at the walls, where solids go on as inside it
  Box inner_;            // the box without it
  Real across_;          // the diagonal of the box, m
  Pose before_, midway_, now_;
  Real offset_before_ = 0, offset_now_ = 0;  // of a paddle that absorbs, m
  Real turned_ = 0, went_ = 0;               // in the substep, by more than the angle, and of the centre, m
  const Box& bounds_of(Extent extent) const { return bounds_[static_cast<std::size_t>(extent)]; }
  Box& bounds_of(Extent extent) { return bounds_[static_cast<std::size_t>(extent)]; }
  Box box_at(const Pose& pose, Real margin) const;
  // `way` is of its surface in the substep, with as much around it, `margin`, as a turn bends a path.
  void place_parts(const Box& way, Real margin);
  std::array<Box, 3> bounds_;        // by extent
  std::array<ClosedPart, 3> parts_;  // by extent
  bool shares_;                      // what follows, and the shape
  std::shared_ptr<const VolumeMap> map_;
  std::shared_ptr<const DistanceGrid> rough_;  // of a mesh
};

}  // namespace trevi
