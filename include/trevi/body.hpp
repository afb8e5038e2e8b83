// A rigid body that moves freely in the water, as a scene's [[body]] describes it (inputs/README.md), and its state.
// Plain data in SI units.
#pragma once

#include <array>
#include <optional>
#include <vector>

#include "trevi/obstacle.hpp"
#include "trevi/types.hpp"

namespace trevi {

/// A spring with a damper, or a line, from a point of the body to a fixed point.
struct Mooring {
  Vec3 anchor = Vec3::Zero();  ///< m
  std::optional<Vec3> point;   ///< its point on the body at the start, m; none: the centre of mass
  Real stiffness = 0;          ///< N/m
  Real damping = 0;            ///< N s/m, along the mooring
  std::optional<Real> length;  ///< m, at which it exerts no force; none: its length at the start
  bool slack = false;          ///< a line, which pulls when it is longer and never pushes
  bool operator==(const Mooring&) const = default;
};

/// Names of the degrees of freedom of a body: translation along the axes x, y, z of the world, and rotation about them.
inline constexpr std::array<const char*, 6> freedoms{"x", "y", "z", "roll", "pitch", "yaw"};

/// Shape, initial position and initial velocities are given as for an obstacle. A body has no prescribed motion.
struct BodySettings : ObstacleSettings {
  std::optional<Real> density;  ///< kg/m³; this or the mass
  std::optional<Real> mass;     ///< kg
  /// Whether each degree of freedom is free, in the order of `freedoms`.
  std::array<bool, 6> free{true, true, true, true, true, true};
  std::optional<Mooring> mooring;
  bool operator==(const BodySettings&) const = default;
};

/// The state of a body between two steps, the same on all ranks. A restart needs all of it.
struct BodyState {
  Vec3 position = Vec3::Zero();                 ///< of the centre of mass, m
  std::array<Real, 4> orientation{1, 0, 0, 0};  ///< unit quaternion w, x, y, z from the frame of the shape to the world
  Vec3 momentum = Vec3::Zero();                 ///< kg m/s
  Vec3 angular_momentum = Vec3::Zero();         ///< kg m²/s, about the centre of mass
  Vec3 velocity = Vec3::Zero();                 ///< m/s, of the centre of mass
  Vec3 angular_velocity = Vec3::Zero();         ///< rad/s
  std::array<Real, 6> last_twist{};             ///< velocity and angular velocity in the last substep, m/s and rad/s
  std::array<Real, 6> last_force{};             ///< force and torque of the pressure in the last substep, N and N m
  /// The current estimate of the added mass of the water, in the frame of the shape; kg, kg m, kg m².
  std::array<Real, 36> added_mass{};
  bool operator==(const BodyState&) const = default;
};

}  // namespace trevi
