#include "app/scene_obstacle.hpp"

#include <fmt/format.h>

#include <initializer_list>
#include <span>

#include "app/scene_fountain.hpp"

namespace trevi {
namespace {

std::span<Real> components(Vec3& vector) { return {vector.data(), 3}; }

/// Keys of some shapes only; with others they are refused.
void only_for(Section& section, const char* key, bool right, const char* shapes) {
  section.check(key, right || !section.given(key), fmt::format("is for {} only; leave it out", shapes));
}

void read_lengths(Section& section, ObstacleSettings& obstacle) {
  const ShapeKind shape = obstacle.shape;
  const bool round = shape != ShapeKind::box && shape != ShapeKind::mesh;
  const bool has_height = shape == ShapeKind::cylinder || shape == ShapeKind::capsule;
  const bool has_axis = has_height || shape == ShapeKind::torus;
  section.numbers({"size", "the edges [x, y, z] of the box in metres", shape == ShapeKind::box},
                  components(obstacle.size));
  if (shape == ShapeKind::box)
    section.check("size", obstacle.size.minCoeff() > 0, "must be positive on every axis; give the edges of the box");
  section.number({"radius", "the radius in metres; of a torus that of its middle line", round}, obstacle.radius,
                 above(0));
  section.number({"tube", "the radius of the torus' tube in metres", shape == ShapeKind::torus}, obstacle.tube,
                 above(0));
  section.number({"height", "the height along the axis in metres, from end to end", has_height}, obstacle.height,
                 above(0));
  if (section.numbers({"axis", "the direction of the axis [x, y, z], of any length"}, components(obstacle.axis)))
    section.check("axis", obstacle.axis.stableNorm() > 0, "must not be zero; give the way the axis points");
  only_for(section, "size", shape == ShapeKind::box, "a box");
  only_for(section, "radius", round, "a sphere, a cylinder, a capsule or a torus");
  only_for(section, "tube", shape == ShapeKind::torus, "a torus");
  only_for(section, "height", has_height, "a cylinder or a capsule");
  only_for(section, "axis", has_axis, "a cylinder, a capsule or a torus");
  if (shape == ShapeKind::capsule && section.fine("radius"))
    section.check("height", obstacle.height >= 2 * obstacle.radius,
                  "must be at least twice the radius, as it goes from end to end; take a sphere");
  if (shape == ShapeKind::torus && section.fine("radius"))
    section.check("tube", obstacle.tube < obstacle.radius, "must be less than radius; the tube would meet itself");
}

void read_place(Section& section, const Scene& scene, ObstacleSettings& obstacle) {
  const bool mesh = obstacle.shape == ShapeKind::mesh;
  section.numbers({"center", "the middle [x, y, z] in metres", !mesh}, components(obstacle.center));
  if (section.text({"path", "the mesh, an STL, OBJ or PLY file relative to the scene's folder", mesh}, obstacle.path))
    obstacle.path = beside_scene(scene.path, obstacle.path);
  section.number({"scale", "the length of a unit of the mesh in metres"}, obstacle.scale, above(0));
  section.numbers({"translate", "the place [x, y, z] of the mesh's origin in metres"}, components(obstacle.center));
  only_for(section, "center", !mesh, "a shape that is not a mesh (which has translate)");
  for (const char* key : {"path", "scale", "translate"}) only_for(section, key, mesh, "a mesh");
  section.numbers({"rotate", "degrees [x, y, z] about the axes through the centre, x first"},
                  components(obstacle.rotate));
  section.flag({"inside", "whether it is a vessel that holds water inside"}, obstacle.inside);
}

void read_motion(Section& section, const Scene& scene, ObstacleSettings& obstacle) {
  section.numbers({"velocity", "the velocity [x, y, z] in m/s"}, components(obstacle.velocity));
  section.numbers({"angular_velocity", "the angular velocity [x, y, z] about the centre in rad/s"},
                  components(obstacle.angular_velocity));
  if (section.text({"motion", "a CSV file of times and places, time,x,y,z in s and m, relative to the scene's folder"},
                   obstacle.motion)) {
    obstacle.motion = beside_scene(scene.path, obstacle.motion);
    section.check("motion", !section.given("velocity"), "velocity is given, too; keep one of them");
  }
}

}  // namespace

void read_obstacle(Section& section, Scene& scene) {
  ObstacleSettings obstacle;
  obstacle.line = section.line();
  using enum ShapeKind;
  section.choice<ShapeKind>({"type", "the shape", true}, obstacle.shape,
                            {{"sphere", sphere},
                             {"box", box},
                             {"cylinder", cylinder},
                             {"capsule", capsule},
                             {"torus", torus},
                             {"mesh", mesh}});
  if (!section.fine("type")) return;  // which of the other keys belong here is not known
  read_lengths(section, obstacle);
  read_place(section, scene, obstacle);
  read_motion(section, scene, obstacle);
  Real restitution = scene.walls.restitution;
  section.number({"restitution", "the share of speed kept in a bounce; default that of [walls]"}, restitution,
                 {.low = 0, .high = 1});
  obstacle.restitution = restitution;
  section.number({"friction", "Coulomb's coefficient of friction in a bounce"}, obstacle.friction, at_least(0));
  section.reject_unknown();
  scene.obstacles.push_back(obstacle);
}

}  // namespace trevi
