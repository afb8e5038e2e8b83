#include "scene/scene_waves.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "boundary/waves/check_wavemaker.hpp"
#include "boundary/waves/paddle_motion.hpp"
#include "fluid/in_two_dimensions.hpp"
#include "scene/lattice.hpp"
#include "scene/scene_place.hpp"
#include "scene/scene_plane.hpp"

namespace trevi {
namespace {

bool is_along_x_or_y(const Vec3& direction) { return direction.z() == 0 && (direction.x() == 0 || direction.y() == 0); }

void read_irregular(Section& section, WavemakerSettings& maker) {
  section.choice<WaveSpectrum>(
      {"spectrum", "irregular: the shape of the spectrum; default jonswap"}, maker.spectrum,
      {{"jonswap", WaveSpectrum::jonswap}, {"pierson_moskowitz", WaveSpectrum::pierson_moskowitz}});
  section.number({"peak_enhancement", "irregular: gamma of JONSWAP; default 3.3"}, maker.peak_enhancement, at_least(1));
  section.integer({"components", "irregular: the number of sines; default 128"}, maker.components, 1);
  section.integer({"seed", "irregular: the seed of the phases; default 1"}, maker.seed, 0);
  for (const char* key : {"spectrum", "peak_enhancement", "components", "seed"})
    section.check(key, !section.given(key) || maker.wave == WaveKind::irregular,
                  "is for wave = \"irregular\"; leave it out");
  section.check("peak_enhancement", !section.given("peak_enhancement") || maker.spectrum == WaveSpectrum::jonswap,
                "is for spectrum = \"jonswap\"; leave it out");
}

void read_wave(Section& section, WavemakerSettings& maker) {
  section.choice<PaddleKind>({"type", "the paddle", true}, maker.kind,
                             {{"piston", PaddleKind::piston}, {"flap", PaddleKind::flap}});
  section.choice<WaveKind>(
      {"wave", "the waves; default regular"}, maker.wave,
      {{"regular", WaveKind::regular}, {"irregular", WaveKind::irregular}, {"solitary", WaveKind::solitary}});
  section.number({"height", "the height of the waves in metres; of irregular ones H_m0", true}, maker.height, above(0));
  const bool periodic = maker.wave != WaveKind::solitary;
  section.number({"period", "the period of the waves in seconds; of irregular ones that of the peak"}, maker.period,
                 above(0));
  section.check("period", !periodic || section.given("period"), "missing; give the period of the waves in seconds");
  section.check("period", periodic || !section.given("period"), "is not for a solitary wave; leave it out");
  section.check("wave", periodic || maker.kind == PaddleKind::piston,
                "\"solitary\" is by a piston; take type = \"piston\"");
  section.number({"ramp", "the time in seconds in which the motion grows; default two periods"}, maker.ramp,
                 at_least(0));
  section.check("ramp", periodic || !section.given("ramp"), "is not for a solitary wave; leave it out");
  if (!section.given("ramp")) maker.ramp = periodic ? 2 * maker.period : 0;
  section.flag({"second_order", "whether a piston of regular waves has Madsen's correction; default true"},
               maker.second_order);
  section.check("second_order",
                !section.given("second_order") || (maker.kind == PaddleKind::piston && maker.wave == WaveKind::regular),
                "is for a piston of regular waves; leave it out");
  section.flag({"absorb", "whether the paddle takes in waves that come back to it; default false"}, maker.absorb);
  section.check("absorb", periodic || !section.given("absorb"), "is not for a solitary wave; leave it out");
  read_irregular(section, maker);
}

// By default at such a distance from the end of the box that the paddle keeps a kernel radius from it, on a plane of
// the lattice.
Real default_position(const WavemakerSettings& maker, const Scene& scene) {
  const Eigen::Index axis = maker.direction.x() != 0 ? 0 : 1;
  const bool up = maker.direction[axis] > 0;
  const Real s = scene.fluid.spacing, room = paddle_reach(maker) + scene.fluid.kernel_radius;
  const Real from_end = s * std::ceil(room / s - 1e-9);
  return up ? scene.domain.min[axis] + from_end : scene.domain.max[axis] - from_end;
}

bool all_fine(const Section& section) {
  constexpr const char* keys[] = {"type",      "wave",     "height",           "period",     "ramp", "second_order",
                                  "direction", "spectrum", "peak_enhancement", "components", "seed", "depth",
                                  "position",  "absorb"};
  return std::all_of(std::begin(keys), std::end(keys), [&](const char* key) { return section.fine(key); });
}

// Whether the waves can be made by a paddle in this box; if not, the reason is reported.
bool is_right(Section& section, const WavemakerSettings& maker, const Box& box) {
  const auto wrong = what_is_wrong(maker, box);
  if (wrong) section.check(wrong->key, false, wrong->why);
  return !wrong;
}

}  // namespace

std::optional<Real> depth_of_water(const Scene& scene) {
  Real top = scene.domain.min.z();
  for (const ParticleSource& source : scene.particles) {
    if (source.type != ParticleSource::Type::block || !source.surface.empty()) return std::nullopt;
    const Real s = scene.fluid.spacing;
    top = std::max(top, source.min.z() + s * std::round((source.max.z() - source.min.z()) / s));
  }
  return top > scene.domain.min.z() ? std::optional(top - scene.domain.min.z()) : std::nullopt;
}

void read_wavemaker(Section& section, Scene& scene, const KnownGood& known) {
  WavemakerSettings maker;
  read_wave(section, maker);
  section.direction({"direction", "the way [x, y, z] that the waves go, along x or y; default [1, 0, 0]"},
                    maker.direction);
  check_along_plane(section, scene, "direction", maker.direction);
  const std::optional<Real> depth = depth_of_water(scene);
  maker.depth = depth.value_or(0);
  section.number({"depth", "the depth of the still water in metres; default that of the blocks of [[particles]]"},
                 maker.depth, above(0));
  section.check("depth", depth || section.given("depth"),
                "missing; give the depth of the still water, which a file or an expression does not tell");
  const bool placed = section.number(
      {"position", "where the face of the paddle rests along the direction in metres; default just in the box"},
      maker.position);
  const Vec3 gravity = scene.gravity.value_or(Vec3::Zero());
  maker.gravity = gravity.x() == 0 && gravity.y() == 0 ? -gravity.z() : 0;
  maker.floor = scene.domain.min.z();
  section.reject_unknown();
  if (!all_fine(section) || !known.box || !known.spacing) return;
  if (!placed) {  // other problems are reported first, because the place depends on them
    if (!is_right(section, maker, {Vec3::Constant(-INFINITY), Vec3::Constant(INFINITY)})) return;
    maker.position = default_position(maker, scene);
  }
  if (!is_right(section, maker, scene.domain)) return;
  const bool alone = std::none_of(scene.obstacles.begin(), scene.obstacles.end(), [&](const ObstacleSettings& one) {
    return one.wavemaker && one.wavemaker->direction == maker.direction;
  });
  section.check("direction", alone,
                "another [[wavemaker]] makes waves in this direction, and its paddle is in the way of this one; leave "
                "one of the two out, or turn one round to the other end");
  if (!alone) return;
  scene.obstacles.push_back(paddle_of(maker, scene.domain));
  lay_in_plane(scene.obstacles.back(), scene.fluid);
  SceneTable::add(scene, "obstacle", section.line());
}

void read_damping(Section& section, Scene& scene, bool box_known) {
  DampingSettings zone;
  section.numbers({"min", "the lower corner of the zone [x, y, z] in metres", true}, zone.min);
  section.numbers({"max", "the upper corner of the zone [x, y, z] in metres", true}, zone.max);
  lay_in_plane(zone, scene.fluid);
  if (section.fine("min"))
    section.check("max", (zone.max - zone.min).minCoeff() > 0, "must be greater than min on every axis");
  if (box_known && section.fine("min") && section.fine("max"))
    section.check(
        "min",
        (zone.min.array() < scene.domain.max.array()).all() && (zone.max.array() > scene.domain.min.array()).all(),
        "the zone is out of the box, and no water would come to rest in it; move it");
  section.number({"rate", "how fast velocities die at the end of the zone in 1/s", true}, zone.rate, at_least(0));
  Vec3 direction;
  if (section.direction({"direction", "the way [x, y, z] to its end, along x or y; default to the nearest wall"},
                        direction)) {
    zone.direction = direction;
    check_along_plane(section, scene, "direction", direction);
    section.check("direction", is_along_x_or_y(direction), "must be along x or y; give [1, 0, 0] for instance");
  } else if (box_known && section.fine("min") && section.fine("max") && section.fine("direction")) {
    Settings one = scene;
    one.dampings = {zone};
    section.check("direction", resolved(one).dampings.front().direction.given(),
                  "missing, and the zone is at no single wall; give the way to its end, [1, 0, 0] for instance");
  }
  section.reject_unknown();
  scene.dampings.push_back(zone);
}

}  // namespace trevi
