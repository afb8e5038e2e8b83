#include "app/preflight/advice.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "boundary/geometry/pose.hpp"
#include "boundary/geometry/shape.hpp"
#include "io/frames/frame_sets.hpp"
#include "scene/block_start.hpp"
#include "scene/free_places.hpp"
#include "scene/scene_place.hpp"

namespace trevi {

namespace {

using Advice = std::vector<std::string>;

bool all_blocks(const Scene& scene) {
  return std::all_of(scene.particles.begin(), scene.particles.end(),
                     [](const ParticleSource& source) { return source.type == ParticleSource::Type::block; });
}

int line_of(const Scene& scene, const char* list, std::size_t k) { return SceneTable(list, k).line_in(scene); }

// Whether water of a block is at both ends of the box along an axis, without solids there, as behind a vessel.
bool touches_both_walls(const Scene& scene, const ParticleSource& block, int axis) {
  constexpr int samples = 8;  // in each direction
  const FreePlaces places(scene);
  for (const Vec3& end : {block.min, block.max}) {
    bool touches = false;
    for (int n = 0; n < samples * samples; ++n) {
      const Vec3 part = (Vec3(n % samples, n / samples, n / samples).array() + 0.5) / samples;
      const Vec3 across(part.x(), axis == 0 ? part.x() : 0, part.z());
      Vec3 place = block.min + across.cwiseProduct(block.max - block.min);
      place[axis] = std::clamp(end[axis], scene.domain.min[axis], scene.domain.max[axis]);
      touches = touches || places.solid_at(place) < 0;
    }
    if (!touches) return false;
  }
  return true;
}

// A block from wall to wall whose lattice ends past the wall or well before it: such water moves immediately.
void look_at_block(const Scene& scene, std::size_t k, Advice& advice) {
  const ParticleSource& block = scene.particles[k];
  const Real s = scene.fluid.spacing;
  for (int axis = 0; axis < 2; ++axis) {
    const Real low = block.min[axis], high = block.max[axis], wide = scene.domain.max[axis] - scene.domain.min[axis];
    if (low - scene.domain.min[axis] > 0.5 * s || scene.domain.max[axis] - high > 0.5 * s) continue;
    const Real gap = (scene.domain.max[axis] - low) / s - std::round((high - low) / s);
    if (gap > -0.05 && gap < 0.35) continue;
    if (!touches_both_walls(scene, block, axis)) continue;
    advice.push_back(fmt::format(
        "the water of line {} goes from wall to wall along {}, {:.4g} spacings: its lattice does not fit, and "
        "it moves at once; give the box a whole number of spacings, for example spacing = {:.6g}",
        line_of(scene, "particles", k), axis == 0 ? "x" : "y", wide / s, wide / std::round(wide / s)));
  }
}

void look_at_overlaps(const Scene& scene, Advice& advice) {
  for (std::size_t i = 0; i < scene.particles.size(); ++i) {
    for (std::size_t j = 0; j < i; ++j) {
      const ParticleSource &a = scene.particles[i], &b = scene.particles[j];
      const Vec3 common = a.max.cwiseMin(b.max) - a.min.cwiseMax(b.min);
      if (common.minCoeff() < 0.5 * scene.fluid.spacing) continue;
      advice.push_back(fmt::format(
          "the blocks of lines {} and {} overlap: water is twice as dense there and flies apart; move one of them",
          line_of(scene, "particles", j), line_of(scene, "particles", i)));
    }
  }
}

// The diagonal of cells as wide as the kernel radius is 1.7 times as long.
void look_at_walls(const Scene& scene, const char* list, std::size_t k, const ObstacleSettings& obstacle,
                   Advice& advice) {
  const Real least = std::sqrt(3.0) * scene.fluid.kernel_radius;
  if (obstacle.shape != ShapeKind::basin || obstacle.wall >= least) return;
  advice.push_back(
      fmt::format("the walls of the basin of line {} are {:.3g} m thick, and cells of the coarse grid see both sides "
                  "of them, which "
                  "crushes the water beside them; set wall = {:.3g} or more",
                  line_of(scene, list, k), obstacle.wall, 2 * scene.fluid.kernel_radius));
}

// A box at least two cells wide, and thinner than three quarters of a cell, beside which water was found not to rest.
void look_at_sheet(const Scene& scene, const char* list, std::size_t k, const ObstacleSettings& obstacle,
                   Advice& advice) {
  if (obstacle.shape != ShapeKind::box || obstacle.inside) return;
  const Real h = scene.fluid.kernel_radius;
  std::array<Real, 3> size{obstacle.size.x(), obstacle.size.y(), obstacle.size.z()};
  if (scene.fluid.dimensions == 2) size[1] = INFINITY;
  std::sort(size.begin(), size.end());
  if (size[0] >= 0.75 * h || size[1] < 2 * h) return;
  advice.push_back(
      fmt::format("the box of line {} is {:.3g} m thick, and cells of the coarse grid see both sides of it: "
                  "water beside it does not come to rest, and levels are up to 2 % off; make it {:.3g} m "
                  "thick or more",
                  line_of(scene, list, k), size[0], h));
}

// A mesh in millimetres that nobody has scaled, for instance.
void look_at_obstacle(const Scene& scene, std::size_t k, Advice& advice) {
  const ObstacleSettings& obstacle = scene.obstacles[k];
  if (obstacle.inside || obstacle.moves()) return;
  const Box place = place_of(obstacle);
  const Vec3 extent = place.max - place.min, box = scene.domain.max - scene.domain.min;
  const bool outside =
      (place.min.array() > scene.domain.max.array()).any() || (place.max.array() < scene.domain.min.array()).any();
  const bool huge = obstacle.shape == ShapeKind::mesh && (extent.array() > 100 * box.array()).all();
  if (!outside && !huge) return;
  std::string remedy = "move it";
  if (obstacle.shape == ShapeKind::mesh && extent.maxCoeff() > box.maxCoeff())
    remedy = fmt::format("move it, or give scale = {:g} if its file is in {}", 0.001 * obstacle.scale, "millimetres");
  advice.push_back(
      fmt::format("the obstacle of line {} is {} the box: it goes from ({:.4g}, {:.4g}, {:.4g}) to ({:.4g}, "
                  "{:.4g}, {:.4g}) m; {}",
                  line_of(scene, "obstacle", k), outside ? "wholly outside of" : "far larger than", place.min.x(),
                  place.min.y(), place.min.z(), place.max.x(), place.max.y(), place.max.z(), remedy));
}

bool shows_colours(const std::optional<FrameSettings>& frames) {
  return frames && std::find(frames->fields.begin(), frames->fields.end(), "rgb") != frames->fields.end();
}

void look_at_colours(const Scene& scene, Advice& advice) {
  const OutputSettings& output = scene.output;
  if (!scene.colour || (!output.vtu && !output.vtkhdf && output.frames.empty())) return;
  if (shows_colours(output.vtu) || shows_colours(output.vtkhdf)) return;
  for (const FrameSetSettings& set : output.frames)
    if (shows_colours(FrameSettings{set.schedule, fields_of(set)})) return;
  advice.emplace_back(
      "[colour] by: no frame shows it; add \"rgb\" to the fields of [output.vtu], [output.vtkhdf] or "
      "[[output.frames]]");
}

// Whether a lattice of spacing s has a point within the radius of (x, y), where it extends.
bool holds_water(const Scene& scene, const FountainSettings& fountain) {
  const Real s = scene.fluid.spacing, radius = fountain.diameter / 2;
  const auto distance = [&](Real center, Real low, Real high) {  // to the nearest point of a row of the lattice
    const Real last = std::max<Real>(std::round((high - low) / s) - 1, 0);
    const Real k = std::clamp<Real>(std::round((center - low) / s - 0.5), 0, last);
    return std::abs(center - (low + (k + 0.5) * s));
  };
  return std::any_of(scene.particles.begin(), scene.particles.end(), [&](const ParticleSource& block) {
    return std::hypot(distance(fountain.center[0], block.min.x(), block.max.x()),
                      distance(fountain.center[1], block.min.y(), block.max.y())) <= radius &&
           block.min.z() + 0.5 * s <= scene.domain.min.z() + fountain.height;
  });
}

void look_at_fountain(const Scene& scene, std::size_t k, Real top, Advice& advice) {
  const FountainSettings& fountain = scene.fountains[k];
  const Real s = scene.fluid.spacing;
  if (!holds_water(scene, fountain)) {
    advice.push_back(
        fmt::format("the fountain of line {} holds no water at the start; move it into the water, or give diameter = "
                    "{:.3g} and a height of at least {:.3g}",
                    line_of(scene, "fountain", k), 2.5 * s, 2 * s));
  } else if (fountain.height > top - scene.domain.min.z() + 0.5 * s) {
    advice.push_back(fmt::format(
        "the fountain of line {} ends above the water, at {:.3g} m for {:.3g} m: it pumps what is in the air, "
        "too; end it just below the surface, with height = {:.3g}",
        line_of(scene, "fountain", k), fountain.height, top - scene.domain.min.z(), top - scene.domain.min.z() - s));
  }
}

}  // namespace

Box place_of(const ObstacleSettings& obstacle) {
  const Box bounds = bounds_of(obstacle);
  const BodyMotion motion(obstacle);
  const Pose pose = motion.at(0);
  Box place{Vec3::Constant(INFINITY), Vec3::Constant(-INFINITY)};
  for (int k = 0; k < 8; ++k) {
    const Vec3 corner((k & 1) != 0 ? bounds.max.x() : bounds.min.x(), (k & 2) != 0 ? bounds.max.y() : bounds.min.y(),
                      (k & 4) != 0 ? bounds.max.z() : bounds.min.z());
    const Vec3 there = pose.into_world(corner);
    place.min = place.min.cwiseMin(there);
    place.max = place.max.cwiseMax(there);
  }
  return place;
}

Real open_volume(const Scene& scene) {
  const Vec3 extent = scene.domain.max - scene.domain.min;
  if (!has_solids(scene)) return extent.prod();
  constexpr int samples = 64;  // along each axis
  const FreePlaces places(scene);
  std::int64_t open = 0;
  for (int i = 0; i < samples; ++i) {
    for (int j = 0; j < samples; ++j) {
      for (int k = 0; k < samples; ++k) {
        const Vec3 place = (Vec3(i, j, k).array() + 0.5) / samples;
        open += places.solid_at(scene.domain.min + extent.cwiseProduct(place)) < 0 ? 1 : 0;
      }
    }
  }
  return extent.prod() * static_cast<Real>(open) / (samples * samples * samples);
}

std::vector<std::string> volume_warnings(const Scene& scene, double particles) {
  constexpr Real rounding = 0.02;  // of the samples, and of lattices that only just fit
  const Real s = scene.fluid.spacing, water = particles * s * s * s, open = open_volume(scene);
  if (water <= (1 + rounding) * open) return {};
  return {fmt::format(
      "{:.0f} particles are {:.4g} m³ of water, and {:.4g} m³ of the box are open: it will be crushed; give it less "
      "water, or more space",
      particles, water, open)};
}

Real expected_speed(const Scene& scene) {
  Real speed = 0, top = scene.domain.min.z();
  for (const FountainSettings& fountain : scene.fountains)
    speed = std::max(speed, fountain.top_speed() + fountain.jitter);
  for (const InletSettings& inlet : scene.inlets) {
    speed = std::max(speed, inlet.top_speed() + inlet.jitter);
    top = std::max(top, inlet.center.z());
  }
  const FreePlaces places(scene);
  for (const ParticleSource& source : scene.particles) {
    speed = std::max(speed, BlockStart(source, places).fastest());
    top = std::max(top, source.max.z());
  }
  const Real g = scene.gravity.value_or(Vec3::Zero()).norm();
  return std::max(speed, std::sqrt(2 * g * (top - scene.domain.min.z())));
}

Real longest_step(const Scene& scene, Real cfl) {
  const Real h = scene.fluid.kernel_radius, v = expected_speed(scene), g = scene.gravity.value_or(Vec3::Zero()).norm();
  return std::min(v > 0 ? cfl * h / v : INFINITY, g > 0 ? 0.25 * std::sqrt(h / g) : INFINITY);
}

std::vector<std::string> scene_advice(const Scene& scene) {
  Advice advice;
  const OutputSettings& output = scene.output;
  if (!output.vtu && !output.vtkhdf && output.frames.empty() && !output.series && !output.checkpoint)
    advice.emplace_back("the scene asks for no output; add [output.vtu] for frames, [output.series] for sums");
  look_at_colours(scene, advice);
  for (std::size_t k = 0; k < scene.obstacles.size(); ++k) {
    look_at_obstacle(scene, k, advice);
    look_at_walls(scene, "obstacle", k, scene.obstacles[k], advice);
    if (!scene.obstacles[k].wavemaker) look_at_sheet(scene, "obstacle", k, scene.obstacles[k], advice);
  }
  for (std::size_t k = 0; k < scene.bodies.size(); ++k) {
    look_at_walls(scene, "body", k, scene.bodies[k], advice);
    look_at_sheet(scene, "body", k, scene.bodies[k], advice);
  }
  if (output.gauges && scene.gauges.empty())
    advice.emplace_back("[output.gauges]: there is no [[gauge]], so it writes nothing; add one, or leave it out");
  constexpr Real longest_cfl = 2;  // up to which the default method was found stable
  if (scene.cfl == 0 && scene.dt > longest_step(scene, longest_cfl)) {
    advice.push_back(
        fmt::format("dt = {:.3g} s is long for water of up to {:.3g} m/s, and time.cfl = 0 never splits a step; give "
                    "dt = {:.2g} or "
                    "less, or time.cfl = 2",
                    scene.dt, expected_speed(scene), longest_step(scene, longest_cfl)));
  }
  if (!all_blocks(scene)) return advice;  // the position of water from a file is known only to the file
  Real top = scene.domain.min.z();
  for (std::size_t k = 0; k < scene.particles.size(); ++k) {
    look_at_block(scene, k, advice);
    top = std::max(top, scene.particles[k].max.z());
  }
  look_at_overlaps(scene, advice);
  if (!scene.inlets.empty() || has_solids(scene)) return advice;  // it is not known where the water goes
  for (std::size_t k = 0; k < scene.fountains.size(); ++k) look_at_fountain(scene, k, top, advice);
  return advice;
}

}  // namespace trevi
