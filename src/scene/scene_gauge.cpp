#include "scene/scene_gauge.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "boundary/gauges.hpp"
#include "scene/scene_place.hpp"

namespace trevi {
namespace {

bool is_pressure(const GaugeSettings& gauge) { return gauge.kind == GaugeKind::pressure; }

}  // namespace

void read_gauge(Section& section, Scene& scene, bool box_known) {
  GaugeSettings gauge;
  section.choice<GaugeKind>(
      {"type", "what it measures", true}, gauge.kind,
      {{"height", GaugeKind::height}, {"pressure", GaugeKind::pressure}, {"velocity", GaugeKind::velocity}});
  if (!section.fine("type")) return;  // which of the other keys belong here is not known
  section.numbers(
      {"center", "the foot of the column, or the place in the water, on a wall or an obstacle, [x, y, z] in metres",
       true},
      gauge.center);
  if (box_known && section.fine("center"))
    section.check("center", scene.domain.contains(gauge.center), "is outside the box; move it inside, or onto a wall");
  constexpr Real least = 1;  // spacings: a smaller disc holds a particle at times, and none at others
  gauge.radius = 2 * scene.fluid.spacing;
  section.number({"radius", "the radius in metres of the disc, or the ball, over which the mean is taken"},
                 gauge.radius, above(0));
  section.check(
      "radius", gauge.radius >= least * scene.fluid.spacing * (1 - 1e-9),
      fmt::format("is less than the spacing, and such a disc holds a particle at times only; give {:.6g} m or "
                  "more",
                  least * scene.fluid.spacing));
  if (box_known)
    section.check("radius", gauge.radius <= (scene.domain.max - scene.domain.min).maxCoeff(),
                  "is more than the box is long; make it smaller");
  if (is_pressure(gauge))
    section.direction({"normal", "the direction [x, y, z] out of the wall or the obstacle, of any length", true},
                      gauge.normal);
  section.reject_unknown();
  scene.gauges.push_back(gauge);
  SceneTable::add(scene, "gauge", section.line());
}

void check_gauges(Section& root, const Scene& scene) {
  const bool any = std::any_of(scene.gauges.begin(), scene.gauges.end(), is_pressure);
  root.check("gauge", !any || root.given("obstacle") || root.given("body"),
             "type = \"pressure\" needs an [[obstacle]] or a [[body]]: without one nobody counts what walls take of "
             "the water");
  root.check("gauge", scene.gauges.empty() || scene.output.series.has_value(),
             "gauges.csv has a row with each of series.csv; add [output.series]");
}

void check_gauge_places(const Scene& scene, const FreePlaces& places) {
  for (std::size_t k = 0; k < scene.gauges.size(); ++k) {
    const GaugeSettings& gauge = scene.gauges[k];
    if (!is_pressure(gauge)) continue;
    const Real fraction = open_fraction_of_gauge(gauge, scene.fluid.spacing, scene.domain,
                                                 [&](const Vec3& p) { return places.solid_at(p) >= 0; });
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
