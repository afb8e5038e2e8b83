// A solid in the water, or a vessel around it, as a scene's [[obstacle]] describes it (inputs/README.md). Plain data in
// SI units; lengths are metres, angles radians unless it is said otherwise.
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

/// A basin is open at the top: upright walls and a floor around a space that is a box, or without a size a cylinder.
enum class ShapeKind { sphere, box, cylinder, capsule, torus, mesh, basin };

/// A closed surface of triangles, each with its corners counterclockwise as seen from outside.
struct TriangleMesh {
  std::vector<Vec3> points;  ///< m, in the frame of the obstacle
  std::vector<std::array<std::int32_t, 3>> triangles;
  bool operator==(const TriangleMesh&) const = default;
};

/// Where an obstacle's centre is at a time; between two of them it moves along a cubic without a kink.
struct ObstacleKnot {
  Real time = 0;  ///< s
  Vec3 center = Vec3::Zero();
  bool operator==(const ObstacleKnot&) const = default;
};

/// About the place and the pose at the start, with the factor f(t) = r(t/ramp) sin(2 pi t/period), r(u) = u²(3 - 2u) up
/// to 1: a shift by f amplitude and a rotation by f rotation, an axis with the angle as its length.
struct Oscillation {
  Vec3 amplitude = Vec3::Zero();  ///< m
  Vec3 rotation = Vec3::Zero();   ///< degrees
  Real period = 1;                ///< s
  Real ramp = 0;                  ///< s; 0: at once
  bool operator==(const Oscillation&) const = default;
};

struct ObstacleSettings {
  ShapeKind shape = ShapeKind::sphere;
  Vec3 center = Vec3::Zero();                ///< of a mesh: where the origin of its file is
  Vec3 size = Vec3::Zero();                  ///< box: its edges; basin: those of the space in it, or zero
  Real radius = 0, tube = 0;                 ///< torus: of its middle line, and of the tube around it
  Real height = 0;                           ///< cylinder, capsule: from end to end along the axis; round basin: within
  Real wall = 0;                             ///< basin: thickness of walls and floor
  Vec3 axis = Vec3::UnitZ();                 ///< cylinder, capsule, torus
  Vec3 rotate = Vec3::Zero();                ///< degrees about x, then y, then z, through the centre
  bool inside = false;                       ///< a vessel: solid is what is outside of the shape
  std::string path;                          ///< mesh: STL, OBJ or PLY
  Real scale = 1;                            ///< mesh: m per unit of the file
  std::shared_ptr<const TriangleMesh> mesh;  ///< read from `path`, or a program's own
  Vec3 velocity = Vec3::Zero();              ///< m/s
  Vec3 angular_velocity = Vec3::Zero();      ///< rad/s, about the centre
  std::string motion;                        ///< a file of times and places
  std::vector<ObstacleKnot> knots;           ///< in place of a velocity; at rest before the first and after the last
  std::optional<Oscillation> oscillation;    ///< in place of velocities and knots
  std::optional<WavemakerSettings> wavemaker;  ///< in place of all of these: the paddle of a wavemaker
  std::optional<Real> restitution;             ///< that of the walls where there is none
  Real friction = 0;                           ///< Coulomb's coefficient in a bounce
  bool extruded = false;                       ///< goes on along y without end, as in two dimensions; of resolved()

  bool moves() const {
    return !knots.empty() || oscillation || wavemaker || !velocity.isZero() || !angular_velocity.isZero();
  }
  bool operator==(const ObstacleSettings&) const = default;
};

/// The paddle of a wavemaker: a box from wall to wall that goes on outside of the box of the water, `domain`, so that
/// there is nothing behind it. To be added to the obstacles of the settings, whose gravity is that of the wavemaker.
ObstacleSettings paddle_of(const WavemakerSettings& wavemaker, const Box& domain);

}  // namespace trevi
