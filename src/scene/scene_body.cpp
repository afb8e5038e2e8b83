#include "scene/scene_body.hpp"

#include <algorithm>
#include <array>

#include "fluid/in_two_dimensions.hpp"
#include "scene/scene_obstacle.hpp"
#include "scene/scene_place.hpp"
#include "solver/check_bodies.hpp"

namespace trevi {
namespace {

void read_free(Section& section, BodySettings& body) {
  std::vector<std::string> free;
  const Key key{"free", "what it may do, a list of \"x\", \"y\", \"z\", \"roll\", \"pitch\", \"yaw\"; default all"};
  if (!section.texts(key, free)) return;
  body.free.fill(false);
  for (const std::string& one : free) {
    const auto at = std::find(freedoms.begin(), freedoms.end(), one);
    if (at == freedoms.end())
      return section.refuse(key, "\"" + printable(one) + "\" is none of x, y, z, roll, pitch, yaw; choose from these");
    bool& is_free = body.free[static_cast<std::size_t>(at - freedoms.begin())];
    if (is_free) return section.refuse(key, "\"" + one + "\" is named twice; name it once");
    is_free = true;
  }
  if (free.empty()) section.refuse(key, "is empty, and the body would stand still; make an [[obstacle]] of it");
}

void check_start(Section& section, const BodySettings& body) {
  for (std::size_t i = 0; i < 6; ++i) {
    const char* key = i < 3 ? "velocity" : "angular_velocity";
    const Real start =
        i < 3 ? body.velocity[static_cast<Eigen::Index>(i)] : body.angular_velocity[static_cast<Eigen::Index>(i - 3)];
    section.check(
        key, body.free[i] || start == 0,
        std::string("is along an axis that free does not name; add \"") + freedoms[i] + "\" to free, or put 0");
  }
}

void read_mooring(Section section, BodySettings& body) {
  if (!section.present()) return;
  Mooring mooring;
  section.numbers({"anchor", "the fixed end [x, y, z] in metres", true}, mooring.anchor);
  Vec3 point = Vec3::Zero();
  if (section.numbers({"point",
                       "where it is fixed to the body at the start, [x, y, z] in metres; default its centre "
                       "of mass"},
                      point))
    mooring.point = point;
  section.number({"stiffness", "the stiffness in N/m", true}, mooring.stiffness, at_least(0));
  section.number({"damping", "the damping along it in N s/m"}, mooring.damping, at_least(0));
  Real length = 0;
  if (section.number({"length", "its length without a force in metres; default that at the start"}, length,
                     at_least(0)))
    mooring.length = length;
  section.flag({"slack", "whether it is a line, which pulls when it is longer and never pushes"}, mooring.slack);
  section.reject_unknown();
  body.mooring = mooring;
}

void read_mass(Section& section, BodySettings& body) {
  Real value = 0;
  if (section.number({"density", "the density in kg/m³; this or mass"}, value, above(0))) body.density = value;
  if (section.number({"mass", "the mass in kg; this or density"}, value, above(0))) body.mass = value;
  section.check("density", !section.given("density") || !section.given("mass"), "mass is given, too; keep one of them");
  section.check("density", section.given("density") || section.given("mass"),
                "missing; give the density (kg/m³) or the mass (kg)");
}

}  // namespace

void read_body(Section& section, Scene& scene) {
  BodySettings body;
  if (!read_solid(section, scene, body)) return;
  section.check("inside", !body.inside, "a vessel is all the rest of the world, and cannot move freely; take a basin");
  read_velocities(section, body);
  read_mass(section, body);
  read_free(section, body);
  if (section.fine("velocity") && section.fine("angular_velocity") && section.fine("free")) check_start(section, body);
  read_mooring(section.child("mooring"), body);
  read_surface(section, scene, body);
  lay_in_plane(body, scene.fluid);
  section.reject_unknown();
  scene.bodies.push_back(body);
  SceneTable::add(scene, "body", section.line());
}

void check_bodies(Section& root, const Scene& scene) {
  root.check("body", scene.bodies.empty() || scene.periodic == std::array<bool, 3>{},
             "goes places, which it cannot in a box with periodic axes; leave out [domain] periodic");
}

void check_body_places(const Scene& scene) {
  for (std::size_t k = 0; k < scene.bodies.size(); ++k) {
    const std::string wrong = why_no_body(scene, k);
    if (!wrong.empty()) told_at(scene, {"body", k}, "", [&] { throw InputError(wrong); });
  }
}

}  // namespace trevi
