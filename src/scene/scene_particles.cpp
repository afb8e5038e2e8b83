#include "scene/scene_particles.hpp"

#include <fmt/format.h>

#include "scene/formula.hpp"
#include "scene/scene_fountain.hpp"
#include "scene/scene_place.hpp"
#include "scene/scene_plane.hpp"
#include "trevi/error.hpp"

namespace trevi {
namespace {

void check_formula(Section& section, const char* key, const std::string& text, std::string_view variables) {
  try {
    const Formula formula(text, variables);
  } catch (const InputError& error) {
    section.check(key, false, fmt::format("\"{}\": {}", printable(text), error.what()));
  }
}

void read_velocity(Section& section, const Scene& scene, ParticleSource& source) {
  const Key key{"velocity", "the start velocity [x, y, z] in m/s, or three texts, expressions of x, y and z"};
  const toml::node* node = section.find(key, "3 numbers or 3 texts");
  if (node == nullptr) return;
  const toml::array* values = node->as_array();
  const bool counts =
      values != nullptr && (values->size() == 3 || (scene.fluid.dimensions == 2 && values->size() == 2));
  if (!counts || !values->is_homogeneous(toml::node_type::string)) {
    section.numbers(key, source.velocity);
    return;
  }
  for (const toml::node& value : *values) {
    source.velocity_formulas.push_back(value.as_string()->get());
    check_formula(section, "velocity", source.velocity_formulas.back(), "xyz");
  }
}

void read_block(Section& section, const Scene& scene, const KnownGood& known, ParticleSource& source) {
  section.numbers({"min", "the lower corner of the block [x, y, z] in metres", true}, source.min);
  section.numbers({"max", "the upper corner of the block [x, y, z] in metres", true}, source.max);
  read_velocity(section, scene, source);
  if (section.text({"surface", "the height of the water in metres, an expression of x and y; default: max"},
                   source.surface))
    check_formula(section, "surface", source.surface, "xy");
  section.number({"vortex",
                  "the largest speed of a Taylor-Green vortex in x and y that is added, in m/s; in two "
                  "dimensions in x and z"},
                 source.vortex);
  lay_in_plane(section, scene, source);
  if (!section.fine("min") || !section.fine("max")) return;
  const Vec3 extent = source.max - source.min;
  section.check("max", extent.minCoeff() > 0, "must be greater than min on every axis; enlarge the block");
  if (known.box) {
    section.check("min", (source.min - scene.domain.min).minCoeff() >= 0,
                  "the block is outside the box; move min to [domain] min or above");
    section.check("max", (scene.domain.max - source.max).minCoeff() >= 0,
                  "the block is outside the box; move max to [domain] max or below");
  }
  if (!known.spacing || !section.fine("max")) return;
  const Real spacing = scene.fluid.spacing;
  const Vec3 counts = (extent / spacing).array().round();
  section.check("max", counts.minCoeff() >= 1,
                fmt::format("zero particles: the block is thinner than half the spacing {} m; enlarge it", spacing));
  section.check("max", counts.prod() <= max_counted,
                fmt::format("{:.1e} particles are too many; check the units, or coarsen the spacing", counts.prod()));
}

}  // namespace

void read_particle_source(Section& section, Scene& scene, const KnownGood& known) {
  ParticleSource source;
  section.choice<ParticleSource::Type>({"type", "where the particles come from; default block"}, source.type,
                                       {{"block", ParticleSource::Type::block}, {"file", ParticleSource::Type::file}});
  if (!section.fine("type")) return;  // which of the other keys belong here is not known
  if (source.type == ParticleSource::Type::file) {
    section.text({"path", "the HDF5 file with /particles/position, relative to the scene's folder", true}, source.path);
    source.path = beside_scene(scene.path, source.path);
  } else {
    read_block(section, scene, known, source);
  }
  section.reject_unknown();
  scene.particles.push_back(source);
  SceneTable::add(scene, "particles", section.line());
}

}  // namespace trevi
