// One obstacle: its shape, its pose at the start and at the end of a substep, and what it contributes to particles near
// it. Paths are followed in the frame of the obstacle, in which it is at rest: there the chords of a particle's path
// join end to end from step to step, so that nothing passes through the surface, however fast either of the two is. A
// solid that reaches a wall of the box is extended to it as it is slightly inside, so that nothing slips past its edge
// along the wall. Not collective.
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

/// What all obstacles of a scene have in common. `open`: the box between its walls, which is larger if it is periodic.
struct BodyRules {
  Box box, open;
  WallSettings walls;
  Kernel kernel;
  Real h;
};

/// A position in the frame of the body, and the same position in the world.
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

/// What an obstacle may reach: positions whose density it contributes to; what a shift may meet, with the obstacle
/// where it is now; and what a path of the substep may meet, from the start of the obstacle's motion to its end.
enum class Extent { density, shift, path };

class Body {
 public:
  /// `floats`: its poses are set by others with place().
  /// `like`: a moving body of the same shape, whose map is shared; may be null.
  Body(const ObstacleSettings& obstacle, const BodyRules& rules, bool floats = false, const Body* like = nullptr);

  /// Motion from `begin` to `end`, s.
  void move(Real begin, Real end) { place(motion_.at(begin, offset_before_), motion_.at(end, offset_now_)); }
  /// Sets the poses at the start of the substep and at its end.
  void place(const Pose& before, const Pose& now);
  /// For a paddle: offsets by the stroke of its own waves at the start and at the end of the next move, m.
  void set_paddle_offset(Real begin, Real end) { offset_before_ = begin, offset_now_ = end; }
  Real paddle_offset() const { return offset_now_; }
  /// At the end of the substep and at its start.
  const Pose& now() const { return now_; }
  const Pose& before() const { return before_; }
  /// In the middle of the substep: the projection uses this pose, as it uses the motion of particles there.
  const Pose& midway() const { return midway_; }
  /// Displacement during the substep of the point of the body that is at p in the middle of it, m.
  Vec3 displacement_at(const Vec3& p) const {
    const Vec3 there = midway_.into_body(p);
    return now_.into_world(there) - before_.into_world(there);
  }
  /// The reference point of moments of forces: the centre, or for a flap its hinge. The centre of a flap's box is the
  /// length of the tank away; the difference between its arc and its chord, times the force, would exceed the work.
  const Vec3& pivot() const { return hinge_ ? *hinge_ : midway_.center; }
  const Shape& shape() const { return *shape_; }
  const VolumeMap& map() const { return *map_; }
  const BodyMotion& motion() const { return motion_; }
  /// The box of the surface in the middle of the substep.
  Box surface_box() const { return box_at(midway_, 0); }
  /// The heights of its lowest and highest point midway, m: of a box or something round; of other shapes those of their
  /// bounds.
  std::array<Real, 2> lowest_and_highest() const;
  Real radius() const { return radius_; }  ///< of the ball around the centre that contains the surface, m
  bool moves() const { return moves_; }
  bool is_vessel() const { return vessel_; }
  Real restitution() const { return restitution_; }

  /// Whether p may have a contribution to its density or a collision within reach, judged by the bounds alone.
  bool may_reach(const Vec3& p) const { return vessel_ || bounds_of(Extent::density).contains(p); }
  /// Whether p, in the frame of the body, is so far from the surface that the body contributes nothing to its density;
  /// false if this cannot be determined quickly.
  bool is_out_of_reach(const Vec3& p) const { return !rough_ && is_out_of_reach(shape_->distance(p)); }
  /// Distances of positions in its frame; arbitrary values if distances are not quick to compute.
  void quick_distances(std::span<const Vec3> p, std::span<Real> found) const {
    if (!rough_) shape_->distances(p, found);
  }
  bool is_out_of_reach(Real quick_distance) const { return !rough_ && quick_distance > out_of_reach * h_; }
  /// Whether a straight path in the world, with the obstacle where it is now, stays on one side of its surface.
  bool is_passed_by(const Vec3& from, const Vec3& to) const {
    const Box& surface = bounds_of(Extent::shift);
    const auto low = from.cwiseMax(to).array() < surface.min.array();
    const auto high = from.cwiseMin(to).array() > surface.max.array();
    return !vessel_ && (low.any() || high.any());
  }
  /// Whether a straight path in the world cannot meet it in the substep, wherever the body is in between.
  bool is_out_of_way(const Vec3& from, const Vec3& to) const {
    const auto low = from.cwiseMax(to).array() < reach().min.array();
    const auto high = from.cwiseMin(to).array() > reach().max.array();
    return !vessel_ && (low.any() || high.any()) && turns_little((to - from).norm());
  }
  /// A box that contains everything that it may reach in the substep. has_bounds(): whether a path outside of this box,
  /// of up to `length` along each axis, cannot meet the surface.
  const Box& reach() const { return bounds_of(Extent::path); }
  bool has_bounds(Real length) const { return !vessel_ && turns_little(1.75 * length); }
  /// The part of space outside of which no position in the box of the walls, and no path there, is affected by the
  /// body; null if there is no such part. For a body that rotates by itself, this depends on the lengths of paths.
  const ClosedPart* part(Extent extent) const {
    const bool by_length = extent == Extent::path && turned_ != 0 && !floats_;
    return vessel_ || by_length ? nullptr : &parts_[static_cast<std::size_t>(extent)];
  }
  bool is_near(const Vec3& p) const {
    if (!may_reach(p)) return false;
    const Vec3 there = now_.into_body(p);
    return !is_out_of_reach(there) && map_->is_near(there);
  }
  /// Whether a straight path, in the frame of the body, may meet the surface; and whether any path of this length may.
  bool may_meet(const Vec3& from, const Vec3& to) const;
  bool may_meet(const Vec3& from, Real length) const;

  std::size_t bytes() const { return shares_ ? 0 : map_->bytes() + (rough_ ? rough_->bytes() : 0); }

  /// The signed distance of p in the frame of the body, for the coarse grid: near the surface accurate to h/12 where
  /// exact distances are expensive (meshes), and further away accurate enough to show that it is.
  Real rough_distance(const Vec3& p) const { return rough_ ? rough_->at(p).distance : shape_->distance(p); }
  void rough_distances(std::span<const Vec3> p, std::span<Real> found) const;
  /// Whether that differs from the exact distance.
  bool is_rough() const { return rough_ != nullptr; }
  /// Whether the straight segment in between may reach the surface; true if that is not known.
  bool may_cross(const Vec3& from, const Vec3& to) const;

  /// Whether one of two positions is in the solid, or the straight line between them meets it.
  bool covers(const Vec3& from, const Vec3& place) const;
  /// The fraction of the segment, from 0 to 1, after which it meets the surface; no value if it does not. A segment
  /// that begins closer to the surface than the contact distance meets it where it comes closer still.
  std::optional<Real> first_contact(const Segment& segment) const;
  /// Whether a path can be at that position: at least half the contact distance from the surface.
  bool is_clear(const ContactPoint& point) const;
  /// The shift, in the frame of the body, that takes a position out of the solid if it is inside or almost inside.
  Vec3 exit_shift(const ContactPoint& point) const;
  /// The shift off the surface at a contact, by the contact distance, so that a path along the surface does not begin
  /// with another contact.
  Vec3 contact_offset(const Vec3& normal) const { return tolerance_ * normal; }
  /// The smallest shift along `normal`, in the frame of the body, that takes the end of a path to the contact distance;
  /// no value if a shift of `limit`, m, is not enough.
  std::optional<Vec3> shift_inside(const ContactPoint& end, const Vec3& normal, Real limit) const;
  Vec3 normal(const ContactPoint& point) const;
  /// The velocity after a bounce, and the rest of a path after it; all in the frame of the body.
  Vec3 reflected(const Vec3& velocity, const Vec3& normal) const;
  static Vec3 along(const Vec3& rest, const Vec3& normal) { return rest - std::min(rest.dot(normal), 0.0) * normal; }

 private:
  // In units of h: the reach, plus a margin for what lies between the nodes of the map.
  static constexpr Real out_of_reach = 1.4;
  // Whether it rotates so little in the substep that the chord of a path of this length, which is straight in the frame
  // of the body, stays off the surface if the path is out of reach. A chord that comes to a body of radius r is no
  // longer than 1.2 (length + path of the centre) + 0.2 r at rotations below 0.1. The rotation bends it by this length
  // times the angle, and the reach is more than h. Floating bodies rotate little.
  bool turns_little(Real length) const {
    return turned_ == 0 || floats_ || (turned_ < 0.1 && turned_ * (1.2 * (length + went_) + 0.2 * radius_) < h_);
  }
  // Whether a position is so far outside the bounds that its distance exceeds the contact distance.
  bool is_off(const Vec3& p) const {
    return !vessel_ && (surface_.min - p).cwiseMax(p - surface_.max).maxCoeff() > 2 * wall_extension_;
  }
  // Whether p is outside the solid, and further than `segment` from the surface.
  bool is_beyond(const Vec3& p, Real segment) const;
  // Distance to the surface, including its extension to the walls; exactly `reach` if it is at least that far.
  Real distance(const ContactPoint& point, Real reach) const;
  Real step_from(const Segment& segment, Real s, Real d, Real threshold) const;

  std::shared_ptr<const Shape> shape_;
  Box surface_;                 // its bounds, in the frame of the body
  Eigen::Matrix3d revolution_;  // projects on the axes of revolution of the shape, in this frame
  BodyMotion motion_;
  std::optional<Vec3> hinge_;                     // of a flap
  bool floats_, moves_, vessel_, quick_, whole_;  // quick_: distances are
  Real h_, tolerance_, restitution_, friction_, radius_;
  Real wall_extension_;  // from the walls, within which solids are extended to them
  Box inner_;            // the box without this margin
  Real across_;          // the diagonal of the box, m
  Pose before_, midway_, now_;
  Real offset_before_ = 0, offset_now_ = 0;  // of an absorbing paddle, m
  Real turned_ = 0, went_ = 0;               // in the substep: more than the angle; of the centre, m
  const Box& bounds_of(Extent extent) const { return bounds_[static_cast<std::size_t>(extent)]; }
  Box& bounds_of(Extent extent) { return bounds_[static_cast<std::size_t>(extent)]; }
  Box box_at(const Pose& pose, Real margin) const;
  // `way`: the region that its surface passes in the substep; `margin` around it: as much as a rotation bends a path.
  void place_parts(const Box& way, Real margin);
  std::array<Box, 3> bounds_;        // by extent
  std::array<ClosedPart, 3> parts_;  // by extent
  bool shares_;                      // whether what follows, and the shape, are shared
  std::shared_ptr<const VolumeMap> map_;
  std::shared_ptr<const DistanceGrid> rough_;  // of a mesh
};

}  // namespace trevi
