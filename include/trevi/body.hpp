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
  std::optional<Vec3> point;   ///< m, where it is fixed to the body at the start; none: the centre of mass
  Real stiffness = 0;          ///< N/m
  Real damping = 0;            ///< N s/m, along the mooring
  std::optional<Real> length;  ///< m, without a force; none: as long as it is at the start
  bool slack = false;          ///< a line: it pulls when it is longer, and never pushes
  bool operator==(const Mooring&) const = default;
};

/// Names of what a body may do: to move along the axes x, y, z of the world, and to turn about them.
inline constexpr std::array<const char*, 6> freedoms{"x", "y", "z", "roll", "pitch", "yaw"};

/// The shape, place and velocities at the start are those of an obstacle; it has no motion of its own.
struct BodySettings : ObstacleSettings {
  std::optional<Real> density;  ///< kg/m³; this or the mass
  std::optional<Real> mass;     ///< kg
  /// Whether it may, in the order of `freedoms`.
  std::array<bool, 6> free{true, true, true, true, true, true};
  std::optional<Mooring> mooring;
  bool operator==(const BodySettings&) const = default;
};

/// What a solver knows of a body between two steps; the same on all ranks. A restart needs all of it.
struct BodyState {
  Vec3 position = Vec3::Zero();                 ///< of the centre of mass, m
  std::array<Real, 4> orientation{1, 0, 0, 0};  ///< unit quaternion w, x, y, z from the frame of the shape to the world
  Vec3 momentum = Vec3::Zero();                 ///< kg m/s
  Vec3 angular_momentum = Vec3::Zero();         ///< kg m²/s, about the centre of mass
  Vec3 velocity = Vec3::Zero();                 ///< m/s, of the centre of mass
  Vec3 angular_velocity = Vec3::Zero();         ///< rad/s
  std::array<Real, 6> last_twist{};             ///< m/s and rad/s, in the last substep
  std::array<Real, 6> last_force{};             ///< N and N m, of the pressure in the last substep
  /// What is known of the water's own response, in the frame of the shape; kg, kg m, kg m².
  std::array<Real, 36> added_mass{};
  bool operator==(const BodyState&) const = default;
};

}  // namespace trevi
