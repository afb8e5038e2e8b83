#include "scene/scene_obstacle.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <span>

#include "fluid/in_two_dimensions.hpp"
#include "scene/scene_fountain.hpp"
#include "scene/scene_place.hpp"
#include "scene/scene_plane.hpp"

namespace trevi {
namespace {

void read_basin(Section& section, const FluidSettings& fluid, ObstacleSettings& obstacle) {
  section.numbers({"size", "the edges [x, y, z] of the space in a basin that is a box, in metres"}, obstacle.size);
  if (fluid.dimensions == 2 && section.given("size")) obstacle.size.y() = fluid.spacing;
  section.number({"radius", "the radius of the space in a round basin in metres"}, obstacle.radius, above(0));
  section.number({"height", "the height of the space in a round basin in metres"}, obstacle.height, above(0));
  obstacle.wall = 2 * (fluid.kernel_radius.given() ? fluid.kernel_radius.value() : 2 * fluid.spacing);
  section.number({"wall", "the thickness of a basin's walls and floor in metres"}, obstacle.wall, above(0));
  const bool box = section.given("size");
  section.check("size", !box || !section.fine("size") || obstacle.size.minCoeff() > 0,
                "must be positive on every axis; give the edges of the space in the basin");
  for (const char* key : {"radius", "height"}) {
    section.check(key, !box || !section.given(key), "is of a round basin, and size is given, too; keep one of them");
    section.check(key, box || section.given(key), "missing; give radius and height of a round basin, or size of a box");
  }
}

// Only the keys of its shape are accepted; others are unknown.
void read_lengths(Section& section, const FluidSettings& fluid, ObstacleSettings& obstacle) {
  const ShapeKind shape = obstacle.shape;
  const bool has_height = shape == ShapeKind::cylinder || shape == ShapeKind::capsule;
  if (shape == ShapeKind::mesh) return;
  if (shape == ShapeKind::basin) return read_basin(section, fluid, obstacle);
  const bool in_plane = fluid.dimensions == 2;
  if (shape == ShapeKind::box) {
    section.numbers({"size", "the edges [x, y, z] of the box in metres", true}, obstacle.size);
    if (in_plane) obstacle.size.y() = fluid.spacing;
    section.check("size", obstacle.size.minCoeff() > 0, "must be positive on every axis; give the edges of the box");
    return;
  }
  section.number({"radius", "the radius in metres; of a torus that of its middle line", true}, obstacle.radius,
                 above(0));
  if (shape == ShapeKind::torus) {
    section.number({"tube", "the radius of the torus' tube in metres", true}, obstacle.tube, above(0));
    if (section.fine("radius"))
      section.check("tube", obstacle.tube < obstacle.radius, "must be less than radius; the tube would meet itself");
  }
  if (has_height)
    section.number(
        {"height", "the height along the axis in metres, from end to end; in two dimensions there is none", !in_plane},
        obstacle.height, above(0));
  section.check("height", !in_plane || shape != ShapeKind::cylinder || !section.given("height"),
                "is for three dimensions; in two a cylinder goes on along y; leave it out");
  if (shape == ShapeKind::capsule && section.fine("radius"))
    section.check("height", obstacle.height >= 2 * obstacle.radius,
                  "must be at least twice the radius, as it goes from end to end; take a sphere");
  if (shape == ShapeKind::sphere) return;
  if (in_plane) obstacle.axis = Vec3::UnitY();
  section.direction({"axis", "the direction of the axis [x, y, z], of any length"}, obstacle.axis);
}

void read_place(Section& section, const Scene& scene, ObstacleSettings& obstacle) {
  if (obstacle.shape == ShapeKind::mesh) {
    if (section.text({"path", "the mesh, an STL, OBJ or PLY file relative to the scene's folder", true}, obstacle.path))
      obstacle.path = beside_scene(scene.path, obstacle.path);
    section.number({"scale", "the length of a unit of the mesh in metres"}, obstacle.scale, above(0));
    section.numbers({"translate", "the place [x, y, z] of the mesh's origin in metres"}, obstacle.center);
  } else {
    section.numbers({"center", "the middle [x, y, z] in metres", true}, obstacle.center);
  }
  section.numbers({"rotate", "degrees [x, y, z] about the axes through the centre, x first"}, obstacle.rotate);
  constexpr Real max_degrees = 1e6;  // for which rounding leaves a millionth of a degree
  section.check("rotate", obstacle.rotate.cwiseAbs().maxCoeff() <= max_degrees,
                "must be at most a million degrees about each axis; check the units");
  if (obstacle.shape != ShapeKind::basin)
    section.flag({"inside", "whether it is a vessel that holds water inside"}, obstacle.inside);
}

bool may_follow(const ObstacleKnot& last, const ObstacleKnot& next) {
  return next.time > last.time &&
         (next.center - last.center).cwiseAbs().maxCoeff() <= fastest_obstacle * (next.time - last.time);
}

// A list of lists of a time and a position; none for anything else. In two dimensions a position may be [x, z].
std::vector<ObstacleKnot> knots_of(const toml::node& node, bool in_plane) {
  std::vector<ObstacleKnot> knots;
  const toml::array* rows = node.as_array();
  if (rows == nullptr || rows->size() < 2) return {};
  for (const toml::node& row : *rows) {
    const toml::array* numbers = row.as_array();
    if (numbers == nullptr || (numbers->size() != 4 && !(in_plane && numbers->size() == 3))) return {};
    std::array<Real, 4> value{};
    for (std::size_t k = 0; k < numbers->size(); ++k) value[k] = numbers->get(k)->value<double>().value_or(NAN);
    const Vec3 center = in_plane ? Vec3(value[1], 0, value[numbers->size() - 1]) : Vec3(value[1], value[2], value[3]);
    if (!std::isfinite(value[0]) || !is_place(center) ||
        (!knots.empty() && !may_follow(knots.back(), {value[0], center})))
      return {};
    knots.push_back({value[0], center});
  }
  return knots;
}

// motion = { type = "sine", ... }
void read_oscillation(Section section, ObstacleSettings& obstacle) {
  Oscillation swing;
  std::string type;
  const std::vector<std::string> types = {"sine"};
  section.choice({"type", "how it moves", true}, type, types);
  section.numbers({"amplitude", "the largest shift [x, y, z] in metres"}, swing.amplitude);
  section.numbers({"rotation", "the largest rotation [x, y, z] about the centre in degrees, an axis times its angle"},
                  swing.rotation);
  section.number({"period", "the time of a whole oscillation in seconds", true}, swing.period, above(0));
  section.number({"ramp", "the time in seconds in which the amplitude grows from 0; default 0"}, swing.ramp,
                 at_least(0));
  section.check("amplitude", !swing.amplitude.isZero() || !swing.rotation.isZero(),
                "is zero, and so is rotation: it would not move; give one of them, or leave motion out");
  const Real fastest = 2 * std::numbers::pi / swing.period * swing.amplitude.norm();
  const Real turns = 2 * std::numbers::pi / swing.period * swing.rotation.norm() * std::numbers::pi / 180;
  section.check("period", !section.fine("period") || fastest <= fastest_obstacle,
                "with this amplitude makes it faster than 10000 m/s; check the units");
  section.check("period", !section.fine("period") || turns <= fastest_obstacle,
                "with this rotation makes it turn faster than 10000 rad/s; check the units");
  section.reject_unknown();
  obstacle.oscillation = swing;
}

void read_motion(Section& section, const Scene& scene, ObstacleSettings& obstacle) {
  read_velocities(section, obstacle);
  const Key motion{"motion",
                   "times and places, [[time, x, y, z], ...] in s and m with times increasing, or the name of a CSV "
                   "file of them relative to the scene's folder, or a table { type = \"sine\", ... }"};
  const toml::node* node = section.find(motion, "text, list or table");
  if (node == nullptr) return;
  if (const auto* path = node->as_string()) {
    obstacle.motion = beside_scene(scene.path, path->get());
  } else if (node->is_table()) {
    read_oscillation(section.child("motion"), obstacle);
  } else {
    const bool in_plane = scene.fluid.dimensions == 2;
    obstacle.knots = knots_of(*node, in_plane);
    if (obstacle.knots.empty())
      return section.refuse(motion,
                            fmt::format("must be two times and places or more, {} each, in order, at most 10000 "
                                        "m/s apart",
                                        in_plane ? "[time, x, z]" : "[time, x, y, z]"));
  }
  section.check("motion", !section.given("velocity"), "velocity is given, too; keep one of them");
  section.check("motion", !node->is_table() || !section.given("angular_velocity"),
                "angular_velocity is given, too; a sine has a rotation of its own");
}

}  // namespace

void read_velocities(Section& section, ObstacleSettings& obstacle) {
  section.numbers({"velocity", "the velocity [x, y, z] in m/s"}, obstacle.velocity);
  section.check("velocity", obstacle.velocity.cwiseAbs().maxCoeff() <= fastest_obstacle,
                "must be at most 10000 m/s on each axis; check the units");
  section.numbers({"angular_velocity", "the angular velocity [x, y, z] about the centre in rad/s"},
                  obstacle.angular_velocity);
  section.check("angular_velocity", obstacle.angular_velocity.cwiseAbs().maxCoeff() <= fastest_obstacle,
                "must be at most 10000 rad/s about each axis; check the units");
}

bool read_solid(Section& section, const Scene& scene, ObstacleSettings& obstacle) {
  using enum ShapeKind;
  section.choice<ShapeKind>({"type", "the shape", true}, obstacle.shape,
                            {{"sphere", sphere},
                             {"box", box},
                             {"cylinder", cylinder},
                             {"capsule", capsule},
                             {"torus", torus},
                             {"basin", basin},
                             {"mesh", mesh}});
  if (!section.fine("type")) return false;  // which of the other keys belong here is not known
  read_lengths(section, scene.fluid, obstacle);
  read_place(section, scene, obstacle);
  return true;
}

void read_surface(Section& section, const Scene& scene, ObstacleSettings& obstacle) {
  Real restitution = scene.walls.restitution;
  section.number({"restitution", "the fraction of speed kept in a bounce; default that of [walls]"}, restitution,
                 {.low = 0, .high = 1});
  obstacle.restitution = restitution;
  check_in_plane(section, scene, obstacle);
  lay_in_plane(obstacle, scene.fluid);
  section.number({"friction", "Coulomb's coefficient of friction in a bounce"}, obstacle.friction, at_least(0));
}

void read_obstacle(Section& section, Scene& scene) {
  ObstacleSettings obstacle;
  if (!read_solid(section, scene, obstacle)) return;
  read_motion(section, scene, obstacle);
  read_surface(section, scene, obstacle);
  section.reject_unknown();
  scene.obstacles.push_back(obstacle);
  SceneTable::add(scene, "obstacle", section.line());
}

}  // namespace trevi
