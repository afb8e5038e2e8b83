#include "scene/scene_inlet.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "fluid/forcings/inlet.hpp"
#include "fluid/in_two_dimensions.hpp"
#include "scene/scene_fountain.hpp"
#include "scene/scene_place.hpp"
#include "scene/scene_plane.hpp"
#include "solver/density_solver.hpp"
#include "solver/wall_flows.hpp"

namespace trevi {
namespace {

/// For one layer; a larger number is assumed to be a mistake.
constexpr Real max_places = 100'000'000;

void only_for(Section& section, const char* key, bool right, const char* words) {
  section.check(key, right || !section.given(key), std::string("is for ") + words + "; leave it out");
}

void read_opening(Section& section, InletSettings& inlet) {
  section.choice<InletShape>({"type", "the shape of the opening; default disc"}, inlet.shape,
                             {{"disc", InletShape::disc}, {"rectangle", InletShape::rectangle}});
  const bool disc = inlet.shape == InletShape::disc;
  section.numbers({"center", "the middle [x, y, z] of the opening in metres", true}, inlet.center);
  section.number({"radius", "the radius of a disc in metres"}, inlet.radius, above(0));
  section.numbers({"size", "the level edge and the other edge [a, b] of a rectangle in metres"}, inlet.size);
  only_for(section, "radius", disc, "a disc; a rectangle has a size");
  only_for(section, "size", !disc, "type = \"rectangle\"; a disc has a radius");
  section.check("radius", !disc || section.given("radius") || section.given("size"),
                "missing; give the radius of the disc in metres");
  section.check("size", disc || section.given("size") || section.given("radius"),
                "missing; give the edges [a, b] of the rectangle in metres");
  section.check("size", disc || !section.fine("size") || (inlet.size[0] > 0 && inlet.size[1] > 0),
                "must be positive; give the edges [a, b] of the rectangle in metres");
}

// `lattice`: none if the opening is not known.
void read_flow_rate(Section& section, InletSettings& inlet, const std::optional<InletLattice>& lattice, Real spacing) {
  Real flow = 0;
  if (!section.number({"flow", "the water that enters in m³/s, in place of speed"}, flow, at_least(0))) return;
  inlet.flow = flow;
  section.check("flow", !section.given("speed"), "speed is given, too; keep one of them");
  if (!lattice) return;
  inlet.speed = speed_of_flow(flow, *lattice, spacing);
  section.check("flow", inlet.speed <= 1e4,
                fmt::format("is {:.3g} m/s through this opening; lower it, or widen the opening", inlet.speed));
}

// In two dimensions the opening depends on the direction, which is one of the keys that are read later.
void lay_in_plane(Section& section, const Scene& scene, InletSettings& inlet) {
  if (scene.fluid.dimensions == 3) return;
  section.direction({"direction", "the direction of the jet [x, z], of any length"}, inlet.direction);
  lay_in_plane(inlet, scene.fluid);
}

// None if the opening is not known, or has more places than can be intended.
std::optional<InletLattice> lattice_of(Section& section, const Scene& scene, const InletSettings& inlet,
                                       const KnownGood& known) {
  const Real spacing = scene.fluid.spacing;
  if (!known.spacing || !section.fine("radius") || !section.fine("size")) return std::nullopt;
  const bool counts =
      section.check("center", InletLattice::places_of(inlet, spacing) <= max_places,
                    fmt::format("the opening has more than {:.0e} places; check the units", max_places));
  return counts ? std::optional(InletLattice(inlet, spacing)) : std::nullopt;
}

void refuse_in_wall(Section& section, const std::optional<WallRefusal>& refusal) {
  if (refusal && section.fine(refusal->key)) section.check(refusal->key, false, refusal->why);
}

// For an opening in a wall.
void read_in_wall(Section& section, InletSettings& inlet) {
  std::string text;
  Real level = 0;
  if (section.number({"level", "the level in metres that is held before an opening in a wall"}, level))
    inlet.level = level;
  if (!section.text({"profile", "the speed in m/s along an opening in a wall, an expression of z (m) and t (s)"}, text))
    return;
  for (const char* key : {"speed", "flow"})
    section.check("profile", !section.given(key), std::string(key) + " is given, too; keep one of them");
  try {
    inlet.profile = speed_profile(text);
    inlet.profile->speed(inlet.center.z(), 0);
  } catch (const InputError& error) {
    section.check("profile", false, error.what());
    inlet.profile.reset();
  }
}

// The mean over the opening, at the start; checked at the times of all steps, or at a thousand if there are more.
void read_mean_speed(Section& section, InletSettings& inlet, Real rows, const Scene& scene) {
  constexpr Real highest = 1e4, max_times = 1000;
  try {
    const Real parts = std::clamp(static_cast<Real>(scene.steps()), 1.0, max_times);
    for (Real part = 0; part < parts; ++part) {
      const Real time = scene.end * part / parts;
      if (part > 0 && (time < inlet.start || time >= inlet.stop)) continue;
      const Real speed = mean_speed(inlet, rows, scene.fluid.spacing, time);
      if (part == 0) inlet.speed = speed;
      section.check("profile", speed <= highest,
                    fmt::format("is {:.4g} m/s in the mean over the opening at {:.4g} s, and at most "
                                "{:g} can be; check the units",
                                speed, time, highest));
    }
  } catch (const InputError& error) {
    section.check("profile", false, error.what());
  }
}

// Errors at times in between are found only by the run.
void name_place_of_profile(const Section& section, InletSettings& inlet) {
  const auto prefix = section.told("profile", "");
  inlet.profile->speed = [prefix, speed = inlet.profile->speed](Real z, Real t) {
    try {
      return speed(z, t);
    } catch (const InputError& error) {
      throw InputError(prefix + error.what());
    }
  };
}

void check_place(Section& section, const Scene& scene, const InletSettings& inlet) {
  const Vec3 reach = InletLattice(inlet, scene.fluid.spacing).reach(), low = inlet.center - reach,
             high = inlet.center + reach;
  section.check("center", scene.domain.contains(low) && scene.domain.contains(high),
                fmt::format("the opening reaches from ({}, {}, {}) to ({}, {}, {}), out of the box; move it inside",
                            low.x(), low.y(), low.z(), high.x(), high.y(), high.z()));
}

void read_box(Section& section, const FluidSettings& fluid, DrainSettings& drain) {
  section.numbers({"min", "the lower corner of a box [x, y, z] in metres"}, drain.min);
  section.numbers({"max", "the upper corner of a box [x, y, z] in metres"}, drain.max);
  const bool box = drain.shape == DrainShape::box;
  for (const char* key : {"min", "max"}) {
    only_for(section, key, box, "type = \"box\"");
    section.check(key, !box || section.given(key), "missing; give a corner of the box [x, y, z] in metres");
  }
  lay_in_plane(drain, fluid);
  if (box && section.fine("min") && section.fine("max"))
    section.check("max", (drain.max - drain.min).minCoeff() > 0, "must be greater than min on every axis");
}

void read_round_or_plane(Section& section, DrainSettings& drain) {
  const bool box = drain.shape == DrainShape::box, cylinder = drain.shape == DrainShape::cylinder;
  section.numbers({"center", "the middle of a cylinder's base, or a point of a plane, [x, y, z] in metres"},
                  drain.center);
  section.direction({"axis", "the way a cylinder goes, or the normal [x, y, z] of a plane to the side it drains"},
                    drain.axis);
  section.number({"radius", "the radius of a cylinder in metres"}, drain.radius, above(0));
  section.number({"height", "the height of a cylinder above its base in metres"}, drain.height, above(0));
  for (const char* key : {"center", "axis"})
    only_for(section, key, !box, "a cylinder or a plane; a box has min and max");
  section.check("center", box || section.given("center"), "missing; give a point [x, y, z] in metres");
  section.check("axis", drain.shape != DrainShape::plane || section.given("axis"),
                "missing; give the normal [x, y, z] of the plane, to the side that it drains");
  for (const char* key : {"radius", "height"}) {
    only_for(section, key, cylinder, "type = \"cylinder\"");
    section.check(key, !cylinder || section.given(key), "missing; give a length in metres");
  }
}

}  // namespace

void read_inlet(Section& section, Scene& scene, const KnownGood& known) {
  InletSettings inlet;
  inlet.speed = 0;
  read_opening(section, inlet);
  if (!section.fine("type")) return;  // which of the other keys belong here is not known
  lay_in_plane(section, scene, inlet);
  const std::optional<InletLattice> lattice = lattice_of(section, scene, inlet, known);
  read_flow_rate(section, inlet, lattice, scene.fluid.spacing);
  section.check(
      "speed",
      section.given("speed") || section.given("flow") || section.given("profile") || section.given("speed_range"),
      "missing; give speed (m/s), flow (m³/s) or a profile, or speed_range where there is music");
  read_jet(section, scene, inlet);
  read_times(section, inlet);
  read_in_wall(section, inlet);
  if (lattice && inlet.profile) read_mean_speed(section, inlet, static_cast<Real>(lattice->rows()), scene);
  if (inlet.profile) name_place_of_profile(section, inlet);
  section.flag({"recycle", "whether it gives back what drains take, and nothing else"}, inlet.recycle);
  if (lattice && known.box && section.fine("center") && section.fine("direction")) {
    check_place(section, scene, inlet);
    const std::optional<WallRefusal> refusal = why_not_in_wall(inlet, scene);
    refuse_in_wall(section, refusal ? refusal : why_not_beside(inlet, scene.inlets, scene));
  }
  section.reject_unknown();
  scene.inlets.push_back(inlet);
  SceneTable::add(scene, "inlet", section.line());
}

void read_drain(Section& section, Scene& scene, const KnownGood& known) {
  DrainSettings drain;
  section.choice<DrainShape>(
      {"type", "the shape of the region; default box"}, drain.shape,
      {{"box", DrainShape::box}, {"cylinder", DrainShape::cylinder}, {"plane", DrainShape::plane}});
  if (!section.fine("type")) return;  // which of the other keys belong here is not known
  read_box(section, scene.fluid, drain);
  read_round_or_plane(section, drain);
  if (drain.shape == DrainShape::plane) check_along_plane(section, scene, "axis", drain.axis);
  lay_in_plane(drain, scene.fluid);
  Real value = 0;
  if (section.number({"level", "the level in metres that is held before a wall that water leaves by"}, value))
    drain.level = value;
  if (section.number({"flow", "the water that leaves by a wall in m³/s"}, value, at_least(0))) drain.flow = value;
  if (known.box && known.spacing && section.fine("min") && section.fine("max") && section.fine("level") &&
      section.fine("flow")) {
    const std::optional<WallRefusal> refusal = why_not_in_wall(drain, scene);
    refuse_in_wall(section, refusal ? refusal : why_not_beside(drain, scene.drains, scene));
  }
  section.reject_unknown();
  scene.drains.push_back(drain);
  SceneTable::add(scene, "drain", section.line());
}

void check_flow(Section& root, const Scene& scene) {
  const bool recycles =
      std::any_of(scene.inlets.begin(), scene.inlets.end(), [](const InletSettings& inlet) { return inlet.recycle; });
  root.check("inlet", !recycles || !scene.drains.empty(),
             "with recycle it gives back what drains take, and there is none; add [[drain]]");
  const bool projects = (!scene.density.coarse_grid.given() || scene.density.coarse_grid) &&
                        is_downward(scene.gravity.value_or(Vec3::Zero()));
  const auto in_wall = [](const auto& one) { return one.is_in_wall(); };
  constexpr const char* needs = "needs the projection, density.coarse_grid, and gravity along -z";
  root.check("inlet", projects || std::none_of(scene.inlets.begin(), scene.inlets.end(), in_wall),
             std::string("with a profile or a level it ") + needs);
  root.check("drain", projects || std::none_of(scene.drains.begin(), scene.drains.end(), in_wall),
             std::string("with a level or a flow it ") + needs);
}

namespace {

// The first obstacle in the box of a drain in a wall, where the level is measured; -1 if there is none.
int solid_in(const DrainSettings& drain, const Scene& scene, const FreePlaces& places) {
  constexpr Real most = 40;  // samples along an axis
  const Vec3 low = drain.min.cwiseMax(scene.domain.min), extent = drain.max.cwiseMin(scene.domain.max) - low;
  std::array<int, 3> count{};
  for (int a = 0; a < 3; ++a)
    count[static_cast<std::size_t>(a)] =
        static_cast<int>(std::clamp(std::ceil(extent[a] / scene.fluid.spacing - 1e-6), 1.0, most));
  const int last = count[0] * count[1] * count[2];
  for (int n = 0; n < last; ++n) {
    const Vec3 at(n % count[0] + 0.5, n / count[0] % count[1] + 0.5, n / (count[0] * count[1]) + 0.5);
    const int solid = places.solid_at(low + extent.cwiseProduct(at.cwiseQuotient(Vec3(count[0], count[1], count[2]))));
    if (solid >= 0) return solid;
  }
  return -1;
}

}  // namespace

void check_drains(const Scene& scene, const FreePlaces& places) {
  if (places.all()) return;
  for (std::size_t k = 0; k < scene.drains.size(); ++k) {
    const DrainSettings& drain = scene.drains[k];
    const int solid = drain.is_in_wall() ? solid_in(drain, scene, places) : -1;
    if (solid < 0) continue;
    told_at(scene, {"drain", k}, drain.level ? "level" : "flow", [&] {
      throw InputError(
          fmt::format("{} is in its box, in which the level of the water is measured; move it out, or "
                      "make the box smaller",
                      places.name_of(solid)));
    });
  }
}

void check_openings(const Scene& scene, const FreePlaces& places) {
  if (places.all()) return;
  for (std::size_t k = 0; k < scene.inlets.size(); ++k) {
    const InletLattice lattice(scene.inlets[k], scene.fluid.spacing);
    for (GlobalId place = 0; place < lattice.places(); ++place) {
      const Vec3 p = lattice.position(place, 0);
      const int solid = lattice.is_open(place) ? places.solid_at(p) : -1;
      if (solid < 0) continue;
      told_at(scene, {"inlet", k}, "center", [&] {
        throw InputError(
            fmt::format("the opening is in {} at ({:.6g}, {:.6g}, {:.6g}); move it out of there, or make it smaller",
                        places.name_of(solid), p.x(), p.y(), p.z()));
      });
    }
  }
}

}  // namespace trevi
