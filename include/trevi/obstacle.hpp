// A solid in the water, or a vessel around it, as a scene's [[obstacle]] describes it (inputs/README.md). Plain data in
// SI units; lengths are in metres and angles in radians unless stated otherwise.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "trevi/box.hpp"
#include "trevi/types.hpp"
#include "trevi/wavemaker.hpp"

namespace trevi {

/// A basin is open at the top. Its walls and floor enclose a space that is a box or, without a size, a cylinder.
enum class ShapeKind { sphere, box, cylinder, capsule, torus, mesh, basin };

/// A closed surface of triangles, each with its corners counterclockwise as seen from outside.
struct TriangleMesh {
  std::vector<Vec3> points;  ///< m, in the frame of the obstacle
  std::vector<std::array<std::int32_t, 3>> triangles;
  bool operator==(const TriangleMesh&) const = default;
};

/// Position of an obstacle's centre at a given time. Between knots it moves along a cubic with continuous velocity.
struct ObstacleKnot {
  Real time = 0;  ///< s
  Vec3 center = Vec3::Zero();
  bool operator==(const ObstacleKnot&) const = default;
};

/// Oscillation about the initial position and orientation with the factor f(t) = r(t/ramp) sin(2 pi t/period), where
/// r(u) = u²(3 - 2u) up to u = 1: a translation by f amplitude and a rotation by f rotation, which is an axis with the
/// angle as its length.
struct Oscillation {
  Vec3 amplitude = Vec3::Zero();  ///< m
  Vec3 rotation = Vec3::Zero();   ///< degrees
  Real period = 1;                ///< s
  Real ramp = 0;                  ///< s; 0: at once
  bool operator==(const Oscillation&) const = default;
};

struct ObstacleSettings {
  ShapeKind shape = ShapeKind::sphere;
  Vec3 center = Vec3::Zero();                  ///< mesh: position of the origin of its file
  Vec3 size = Vec3::Zero();                    ///< box: its edges; basin: edges of its inner space, or zero
  Real radius = 0, tube = 0;                   ///< torus: radii of its centre line and of its tube
  Real height = 0;                             ///< cylinder, capsule: length along the axis; round basin: inner height
  Real wall = 0;                               ///< basin: thickness of walls and floor
  Vec3 axis = Vec3::UnitZ();                   ///< cylinder, capsule, torus
  Vec3 rotate = Vec3::Zero();                  ///< degrees about x, then y, then z, through the centre
  bool inside = false;                         ///< a vessel: the solid is what lies outside the shape
  std::string path;                            ///< mesh: STL, OBJ or PLY
  Real scale = 1;                              ///< mesh: m per unit of the file
  std::shared_ptr<const TriangleMesh> mesh;    ///< read from `path`, or a program's own
  Vec3 velocity = Vec3::Zero();                ///< m/s
  Vec3 angular_velocity = Vec3::Zero();        ///< rad/s, about the centre
  std::string motion;                          ///< a file of times and positions
  std::vector<ObstacleKnot> knots;             ///< in place of a velocity; at rest before the first and after the last
  std::optional<Oscillation> oscillation;      ///< in place of velocities and knots
  std::optional<WavemakerSettings> wavemaker;  ///< in place of all of these: the paddle of a wavemaker
  std::optional<Real> restitution;             ///< that of the walls if not given
  Real friction = 0;                           ///< coefficient of Coulomb friction in a bounce
  bool extruded = false;                       ///< infinite along y, as in two dimensions; set by resolved()

  bool moves() const {
    return !knots.empty() || oscillation || wavemaker || !velocity.isZero() || !angular_velocity.isZero();
  }
  bool operator==(const ObstacleSettings&) const = default;
};

/// The paddle of a wavemaker: a box from wall to wall that extends beyond the box of the water, `domain`, so that there
/// is no water behind it. The caller adds it to the obstacles of the settings, whose gravity is that of the wavemaker.
ObstacleSettings paddle_of(const WavemakerSettings& wavemaker, const Box& domain);

}  // namespace trevi
