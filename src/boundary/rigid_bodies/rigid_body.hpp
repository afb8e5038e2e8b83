// One rigid body: its mass, its state, and its motion in a substep, which depends on the water (rigid_bodies.hpp). The
// state holds momenta, so that a body without torque keeps its angular momentum to rounding; the orientation follows by
// the implicit midpoint rule (Austin, Krishnaprasad & Wang, J. Comput. Phys. 107, 1993), which is second order. In the
// air, and in falling water, the path is the exact parabola, or with a mooring that of two half kicks (velocity
// Verlet). In the water gravity acts as it does on particles, at the start of a substep, because the two would
// otherwise not balance. Elementary arithmetic only: the same bits on any rank and processor. Not collective.
#pragma once

#include "boundary/geometry/mass_properties.hpp"
#include "boundary/geometry/pose.hpp"
#include "boundary/geometry/shape.hpp"
#include "boundary/rigid_bodies/six.hpp"
#include "trevi/body.hpp"

namespace trevi {

class RigidBody {
 public:
  /// `gravity`, m/s²; `water`: its density, kg/m³.
  RigidBody(const BodySettings& settings, const Shape& shape, const Vec3& gravity, Real water);

  const BodyState& state() const { return state_; }
  void set_state(const BodyState& state) { state_ = state; }
  Real mass() const { return mass_; }
  Real volume() const { return volume_; }
  Real weight() const { return mass_ * gravity_.norm(); }  ///< N
  const std::array<bool, 6>& free() const { return free_; }
  /// Pose of the frame of the shape at the start of a substep, and at its end with the present twist.
  Pose pose() const { return pose_of(state_.position, state_.orientation); }
  Pose end_pose() const { return pose_of(end_position(), end_orientation_); }
  /// The same without the spin about axes of revolution, which does not change the position of the surface.
  Pose end_pose_without_spin() const;
  Vec3 midway_position() const { return state_.position + dt_ / 2 * along_of(twist_); }
  Vec3 end_position() const { return state_.position + dt_ * along_of(twist_); }
  /// Kinetic and potential energy, and that of the mooring, J.
  Real energy() const;
  /// The largest speed of any point within this distance of the centre of the shape, m/s, in a step of dt.
  Real fastest(Real radius, Real dt) const;

  /// Begins a substep: gravity and the mooring act, and the twist is that with the pressure of the last substep.
  void begin(Real dt);
  Real dt() const { return dt_; }
  /// Velocities in the substep: of the centre of mass and about it.
  const Six& twist() const { return twist_; }
  void set_twist(const Six& twist);
  /// Inertia of the body in the middle of the substep.
  const Mass6& inertia() const { return inertia_; }
  /// The same with the added mass of the water, as far as it is known.
  Mass6 felt_inertia() const { return is_wet_ ? plus(inertia_, added_) : inertia_; }
  /// Momentum after external forces and what the body was given in this substep.
  const Six& momentum() const { return momentum_; }
  /// Adds known impulses, N s and N m s about the centre of mass at the start of the substep.
  void give(const Six& impulse) { momentum_ = plus(momentum_, impulse); }
  /// The momentum that the twist lacks when the pressure gives this impulse.
  Six missing(const Six& pressure) const { return plus(plus(momentum_, pressure), times(inertia_, twist_), -1); }
  /// The response of the pressure to the present twist. Its change since the last one reveals the added mass.
  void hear(const Six& pressure);
  /// The part of a moment or an angular velocity about axes of revolution of its shape: pressure has no such moment,
  /// and such a spin leaves the surface where it is.
  Vec3 about_axes_of_revolution(const Vec3& vector) const;
  bool is_moored() const { return mooring_.has_value(); }
  /// The least mass against which the mooring pulls, kg: that of the body if it is at its centre, less away from it,
  /// because the body rotates.
  Real mass_at_mooring() const;
  /// The impulse by anything but gravity and the mooring: none, so little that it falls freely, or more.
  enum class Push { none, little, full };
  /// Ends the substep: momentum() includes all that was given.
  void finish(Push push);

 private:
  Pose pose_of(const Vec3& position, const std::array<Real, 4>& orientation) const;
  Rotation inertia_at(const Rotation& turn) const { return turn * moment_ * turn.transpose(); }
  Six velocities(const Six& momentum, const Rotation& turn) const;
  Real part_that_counts(const Six& step, const Six& found, const Six& known, const Mass6& wide) const;
  Six mooring_force() const;
  Six mean_twist() const;
  void take_momentum();
  Real mooring_energy() const;
  struct Line;
  Line line() const;

  Real mass_, volume_;
  Vec3 center_;      // of mass, in the frame of the shape
  Rotation moment_;  // of inertia, in the frame of the shape, about it
  std::array<bool, 6> free_;
  Vec3 gravity_;
  std::optional<Mooring> mooring_;
  Vec3 hook_ = Vec3::Zero();  // of the mooring, in the frame of the shape, from the centre of mass
  Real rest_length_ = 0;
  BodyState state_;

  Real dt_ = 0;
  Six twist_{}, momentum_{};
  Six pull_{};  // of the mooring, at the start of the substep
  Mass6 inertia_{};
  std::array<Real, 4> end_orientation_{1, 0, 0, 0};
  bool is_wet_ = false;  // whether there is pressure
  Mass6 added_{};        // in the frame of the world
  Mass6 first_added_{};  // from the shape, in its frame
  Rotation revolution_;  // projects on the axes of revolution of its shape, in its frame
  int answers_ = 0;
  Six asked_{}, answer_{};  // the last twist and the pressure in response to it
};

/// Quaternions w, x, y, z.
Rotation rotation_of(const std::array<Real, 4>& q);
std::array<Real, 4> quaternion_of(const Rotation& turn);

}  // namespace trevi
