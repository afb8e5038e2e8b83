#include "scene/scene_gauge.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "boundary/gauges.hpp"
#include "boundary/waves/paddle_motion.hpp"
#include "scene/scene_place.hpp"
#include "scene/scene_plane.hpp"
#include "solver/density_solver.hpp"

namespace trevi {
namespace {

bool is_pressure(const GaugeSettings& gauge) { return gauge.kind == GaugeKind::pressure; }

void belongs_to(Section& section, const char* key, bool right, const char* words) {
  section.check(key, right || !section.given(key), std::string("is for ") + words + "; leave it out");
}

void read_radius(Section& section, const Scene& scene, GaugeSettings& gauge, bool box_known) {
  constexpr Real least = 1;  // spacings: a smaller disc holds a particle at some times, and none at others
  gauge.radius = 2 * scene.fluid.spacing;
  section.number(
      {"radius",
       "the radius in metres of the disc, or the ball, over which the mean is taken; run_up: half the strip's width"},
      gauge.radius, above(0));
  section.check(
      "radius", gauge.radius >= least * scene.fluid.spacing * (1 - 1e-9),
      fmt::format("is less than the spacing, and such a disc holds a particle at times only; give {:.6g} m or "
                  "more",
                  least * scene.fluid.spacing));
  if (box_known)
    section.check("radius", gauge.radius <= (scene.domain.max - scene.domain.min).maxCoeff(),
                  "is more than the box is long; make it smaller");
  belongs_to(section, "radius", gauge.kind != GaugeKind::flow, "a disc or a ball; a flow has a size");
}

// Without a normal, a pressure is that of the water at this place.
void read_normal(Section& section, const Scene& scene, GaugeSettings& gauge) {
  const bool required = gauge.kind == GaugeKind::flow || gauge.kind == GaugeKind::run_up;
  const bool given = section.direction({"normal",
                                        "the direction [x, y, z], of any length: pressure: out of the wall or the "
                                        "obstacle; flow: the way that counts as "
                                        "positive; run_up: level, up the beach"},
                                       gauge.normal);
  section.check("normal", !required || section.given("normal"), "missing; give the direction [x, y, z]");
  if (gauge.kind == GaugeKind::pressure && !section.given("normal")) gauge.kind = GaugeKind::pressure_in_water;
  if (gauge.kind == GaugeKind::run_up && given)
    section.check("normal", gauge.normal.z() == 0, "must be level, the way up the beach as seen from above");
  check_along_plane(section, scene, "normal", gauge.normal);
  const bool takes = required || is_pressure(gauge);
  belongs_to(section, "normal", takes, "a pressure, a flow or a run_up");
  belongs_to(section, "radius", gauge.kind != GaugeKind::pressure_in_water,
             "a pressure on a surface, which has a normal");
}

void read_rectangle(Section& section, GaugeSettings& gauge) {
  const bool flow = gauge.kind == GaugeKind::flow;
  section.numbers({"size", "flow: the level edge and the other edge [a, b] of the rectangle in metres"}, gauge.size);
  belongs_to(section, "size", flow, "a flow");
  section.check("size", !flow || section.given("size"), "missing; give the edges [a, b] of the rectangle in metres");
  section.check("size", !flow || !section.fine("size") || std::min(gauge.size[0], gauge.size[1]) > 0,
                "must be positive; give the edges [a, b] of the rectangle in metres");
}

// The places of height gauges along a line, of which the gauge itself is the first.
std::vector<Vec3> read_line(Section& section, const Scene& scene, const GaugeSettings& gauge, bool box_known) {
  constexpr int most = 10000;
  Vec3 to = gauge.center;
  int count = 1;
  const bool line = section.numbers({"to", "height: the last of a line of gauges [x, y, z] in metres"}, to);
  section.integer({"count", "height: the number of gauges from center to to"}, count, 2);
  if (scene.fluid.dimensions == 2) to.y() = 0;
  for (const char* key : {"to", "count"}) belongs_to(section, key, gauge.kind == GaugeKind::height, "a height");
  section.check("count", section.given("to") == section.given("count"), "and to go together; give both, or none");
  section.check("count", count <= most, fmt::format("must be at most {}", most));
  if (line && box_known) section.check("to", scene.domain.contains(to), "is outside the box; move it inside");
  if (!section.fine("count") || !section.fine("to")) return {gauge.center};
  std::vector<Vec3> places;
  for (int k = 0; k < count; ++k)
    places.push_back(count == 1 ? gauge.center : Vec3(gauge.center + (to - gauge.center) * k / (count - 1)));
  return places;
}

}  // namespace

void read_gauge(Section& section, Scene& scene, bool box_known) {
  GaugeSettings gauge;
  section.choice<GaugeKind>({"type", "what it measures", true}, gauge.kind,
                            {{"height", GaugeKind::height},
                             {"pressure", GaugeKind::pressure},
                             {"velocity", GaugeKind::velocity},
                             {"flow", GaugeKind::flow},
                             {"run_up", GaugeKind::run_up}});
  if (!section.fine("type")) return;  // which of the other keys belong here is not known
  section.numbers(
      {"center", "the foot of the column, or the place in the water, on a wall or an obstacle, [x, y, z] in metres",
       true},
      gauge.center);
  if (scene.fluid.dimensions == 2) gauge.center.y() = 0;
  if (box_known && section.fine("center"))
    section.check("center", scene.domain.contains(gauge.center), "is outside the box; move it inside, or onto a wall");
  read_radius(section, scene, gauge, box_known);
  read_normal(section, scene, gauge);
  read_rectangle(section, gauge);
  for (const Vec3& place : read_line(section, scene, gauge, box_known)) {
    scene.gauges.push_back(gauge);
    scene.gauges.back().center = place;
    SceneTable::add(scene, "gauge", section.line());
  }
  section.reject_unknown();
}

void check_gauges(Section& root, const Scene& scene) {
  const auto any = [&](GaugeKind kind) {
    return std::any_of(scene.gauges.begin(), scene.gauges.end(), [kind](const auto& one) { return one.kind == kind; });
  };
  const bool stands =
      std::any_of(scene.obstacles.begin(), scene.obstacles.end(), [](const auto& one) { return !one.moves(); });
  root.check("gauge",
             !any(GaugeKind::pressure) || root.given("obstacle") || root.given("body") || root.given("wavemaker"),
             "type = \"pressure\" with a normal needs an [[obstacle]] or a [[body]]: without one nobody counts what "
             "walls take of the "
             "water; leave out the normal for the pressure of the water there");
  root.check("gauge", !any(GaugeKind::run_up) || stands || !root.fine("obstacle"),
             "type = \"run_up\" needs an [[obstacle]] that stands, for the water to run up");
  root.check("gauge",
             !any(GaugeKind::pressure_in_water) || ((!scene.density.coarse_grid.given() || scene.density.coarse_grid) &&
                                                    is_downward(scene.gravity.value_or(Vec3::Zero()))),
             "type = \"pressure\" without a normal needs the projection, density.coarse_grid, and gravity along -z");
  root.check("gauge", scene.gauges.empty() || scene.output.series || scene.output.gauges,
             "gauges.csv has a row with each of series.csv; add [output.series], or [output.gauges]");
}

namespace {

// Whether water can never be there: in a standing obstacle, or behind a paddle however far it draws back.
bool is_never_wet(const Scene& scene, const FreePlaces& places, const Vec3& p) {
  const int solid = places.solid_at(p);
  if (solid < 0 || std::cmp_greater_equal(solid, scene.obstacles.size())) return false;
  const ObstacleSettings& obstacle = scene.obstacles[static_cast<std::size_t>(solid)];
  return obstacle.wavemaker ? places.solid_at(p, paddle_reach(*obstacle.wavemaker)) == solid : !obstacle.moves();
}

// For a column: all of it.
bool is_never_wet(const Scene& scene, const FreePlaces& places, const GaugeSettings& gauge) {
  if (gauge.kind == GaugeKind::velocity || gauge.kind == GaugeKind::pressure_in_water)
    return is_never_wet(scene, places, gauge.center);
  if (gauge.kind != GaugeKind::height) return false;
  Vec3 p = gauge.center;
  for (p.z() = scene.domain.min.z(); p.z() <= scene.domain.max.z(); p.z() += scene.fluid.spacing / 2)
    if (!is_never_wet(scene, places, p)) return false;
  return true;
}

// Some of a line of places may be in a solid, but not all.
void check_in_water(const Scene& scene, const FreePlaces& places) {
  const auto line = [&](std::size_t k) { return SceneTable("gauge", k).line_in(scene); };
  for (std::size_t k = 0, end = 0; k < scene.gauges.size(); k = end) {
    bool never = true;
    for (end = k; end < scene.gauges.size() && (end == k || line(end) == line(k)); ++end)
      never = never && is_never_wet(scene, places, scene.gauges[end]);
    if (!never) continue;
    told_at(scene, {"gauge", k}, "center", [&] {
      const Vec3& p = scene.gauges[k].center;
      throw InputError(
          fmt::format("({}, {}, {}) is in a solid, where no water comes; move it into the water", p.x(), p.y(), p.z()));
    });
  }
}

}  // namespace

void check_gauge_places(const Scene& scene, const FreePlaces& places) {
  check_in_water(scene, places);
  for (std::size_t k = 0; k < scene.gauges.size(); ++k) {
    const GaugeSettings& gauge = scene.gauges[k];
    if (gauge.kind != GaugeKind::pressure) continue;
    const Real fraction = open_fraction_of_gauge(
        gauge, lattice_of(scene.fluid), scene.domain, [&](const Vec3& p) { return places.solid_at(p) >= 0; },
        scene.periodic);
    if (fraction >= 0.2) continue;  // in a corner of the box it is a quarter
    told_at(scene, {"gauge", k}, "center", [&] {
      throw InputError(
          fmt::format("({}, {}, {}) is not on a wall or an obstacle with this normal: {:.0f} % of the disc "
                      "has solid behind it and room before it; move it there",
                      gauge.center.x(), gauge.center.y(), gauge.center.z(), 100 * fraction));
    });
  }
}

}  // namespace trevi
