#include "scene/scene_plane.hpp"

#include <fmt/format.h>

#include "fluid/in_two_dimensions.hpp"

namespace trevi {

namespace {

void check_why(Section& section, const Scene& scene, const char* key, const std::string& why) {
  section.check(key, scene.fluid.dimensions == 3 || why.empty(), why);
}

}  // namespace

void read_dimensions(Section& domain, Scene& scene) {
  int& dimensions = scene.fluid.dimensions;
  domain.integer({"dimensions", "3, or 2 for a layer of particles in the plane of x and z; default 3"}, dimensions, 2);
  if (!domain.check("dimensions", dimensions <= 3, "must be 2 or 3")) dimensions = 3;
  if (dimensions == 2) domain.allow_pairs();
}

void check_plane(Section& domain, Scene& scene) {
  if (scene.fluid.dimensions == 3) return;
  domain.check("slab_axis", scene.slab_axis != 1, "is x in two dimensions; leave it out");
  domain.check("periodic", !scene.periodic[1],
               "y is one spacing thick in two dimensions and has no ends; leave it out");
  lay_in_plane(scene);
}

void check_along_plane(Section& section, const Scene& scene, const char* key, const Vec3& vector) {
  check_why(section, scene, key, why_not_along_plane(vector));
}

void check_about_y(Section& section, const Scene& scene, const char* key, const Vec3& rotation) {
  check_why(section, scene, key, why_not_about_y(rotation));
}

void check_in_plane(Section& section, const Scene& scene, const ObstacleSettings& obstacle) {
  check_why(section, scene, section.given("axis") ? "axis" : "type", why_not_in_plane(obstacle));
  check_along_plane(section, scene, "velocity", obstacle.velocity);
  check_about_y(section, scene, "rotate", obstacle.rotate);
  check_about_y(section, scene, "angular_velocity", obstacle.angular_velocity);
  if (!obstacle.oscillation) return;
  check_along_plane(section, scene, "motion", obstacle.oscillation->amplitude);
  check_about_y(section, scene, "motion", obstacle.oscillation->rotation);
}

void lay_in_plane(Section& section, const Scene& scene, ParticleSource& block) {
  if (scene.fluid.dimensions == 3) return;
  block.min.y() = scene.domain.min.y();
  block.max.y() = scene.domain.max.y();
  block.vortex_axis = 2;
  check_along_plane(section, scene, "velocity", block.velocity);
  if (block.velocity_formulas.size() == 2) block.velocity_formulas.insert(block.velocity_formulas.begin() + 1, "0");
  section.check("velocity", block.velocity_formulas.empty() || block.velocity_formulas[1] == "0",
                "must be 0 along y in two dimensions; give two texts, for x and z");
}

}  // namespace trevi
