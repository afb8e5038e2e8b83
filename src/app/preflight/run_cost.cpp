#include "app/preflight/run_cost.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>

#include "app/build.hpp"
#include "fluid/in_two_dimensions.hpp"
#include "io/frames/frame_sets.hpp"
#include "io/writers.hpp"
#include "scene/lattice.hpp"

namespace trevi {

namespace {

double outputs(const Schedule& schedule, const Scene& scene) {
  const auto steps = static_cast<double>(scene.steps());
  if (schedule.every_steps > 0) return std::floor(steps / static_cast<double>(schedule.every_steps)) + 1;
  if (schedule.every > 0) return std::min(std::floor(steps * scene.dt / schedule.every), steps) + 1;
  return 2;  // the start and the end
}

double field_bytes(const std::vector<std::string>& fields) {
  double bytes = 0;
  for (const std::string& field : fields)
    bytes += field == "velocity" ? 12 : field == "id" ? 8 : field == "rgb" ? 3 : 4;
  return bytes;
}

// An upper bound: how many are near the surface is not known, and water in a box may be a tenth denser than its
// lattice.
double selected_particles(const Scene& scene, const FrameSetSettings& set, double particles) {
  double selected = particles;
  if (set.box) {
    const Vec3 extent = set.box->max.cwiseMin(scene.domain.max) - set.box->min.cwiseMax(scene.domain.min);
    selected = std::min(selected, 1.1 * extent.prod() / std::pow(scene.fluid.spacing, 3));
  }
  return selected / static_cast<double>(set.one_in);
}

// The sample: a basin this many spacings wide, filled to two thirds. Enough water for all loops, and a second of work.
Scene sample_of(const Scene& scene) {
  constexpr int deep = 24, high = 36, long_layer = 200;
  const int wide = scene.fluid.dimensions == 2 ? long_layer : deep;
  Scene sample = scene;
  const Real s = scene.fluid.spacing;
  sample.domain.min = Vec3::Zero();
  sample.domain.max = Vec3(wide, wide, high) * s;
  lay_in_plane(sample);
  sample.slab_axis = 0;
  sample.ranks.reset();
  sample.ranks_by_model = false;  // each rank computes a sample of its own
  ParticleSource pool;
  pool.min = sample.domain.min;
  pool.max = sample.domain.max;
  pool.max.z() = deep * s;
  sample.particles = {pool};
  sample.fountains.clear();
  sample.inlets.clear();
  sample.drains.clear();
  sample.dampings.clear();
  sample.gauges.clear();
  sample.bodies.clear();
  std::erase_if(sample.obstacles, [](const ObstacleSettings& obstacle) { return obstacle.wavemaker.has_value(); });
  sample.output = {};
  return sample;
}

}  // namespace

FrameSetCost cost_of(const Scene& scene, const FrameSetSettings& set, double particles) {
  FrameSetCost cost;
  cost.frames = outputs(set.schedule, scene);
  const double fields = field_bytes(fields_of(set));
  if (set.what == FrameContent::cells) {
    cost.bytes = static_cast<double>(coarse_cells(scene, set).total()) * fields;
  } else {
    const double points = set.precision == Precision::single ? 12 : 24,
                 cells = set.format == FrameFormat::vtkhdf ? 8 : 0;
    cost.bytes = selected_particles(scene, set, particles) * (points + cells + fields);
  }
  return cost;
}

double output_bytes(const Scene& scene, double particles) {
  const OutputSettings& output = scene.output;
  double bytes = 0;
  if (output.vtu) bytes += outputs(output.vtu->schedule, scene) * particles * (24 + field_bytes(output.vtu->fields));
  // Cells take as much as points there: connectivity, offset, type.
  if (output.vtkhdf)
    bytes += outputs(output.vtkhdf->schedule, scene) * particles * (41 + field_bytes(output.vtkhdf->fields));
  for (const FrameSetSettings& set : output.frames) {
    const FrameSetCost cost = cost_of(scene, set, particles);
    bytes += cost.frames * cost.bytes;
  }
  if (output.checkpoint) {
    // One more than are kept while it is being written.
    const double kept = std::min(outputs(output.checkpoint->schedule, scene), output.checkpoint->keep + 1.0);
    bytes += kept * particles * (scene.colour == Colour::rainbow_x ? 60 : 56);
  }
  // For tables: numbers per row, each about 20 characters with its comma.
  constexpr double letters = 20, of_series = 25, of_solid = 6, of_body = 19, of_velocity = 3;
  if (output.series) {
    const double numbers = of_series + of_solid * static_cast<double>(scene.obstacles.size()) +
                           of_body * static_cast<double>(scene.bodies.size());
    bytes += outputs(*output.series, scene) * numbers * letters;
  }
  if (const std::optional<Schedule> rows = schedule_of_gauges(scene)) {
    double numbers = 0;
    for (const GaugeSettings& gauge : scene.gauges) numbers += gauge.kind == GaugeKind::velocity ? of_velocity : 1;
    bytes += outputs(*rows, scene) * numbers * letters;
  }
  return bytes;
}

std::vector<std::string> disk_warnings(double bytes, const std::string& directory) {
  namespace fs = std::filesystem;
  std::error_code problem;
  fs::path place = fs::absolute(directory, problem);
  while (!fs::exists(place, problem) && place.has_relative_path()) place = place.parent_path();
  const fs::space_info space = fs::space(place, problem);
  if (problem || bytes <= static_cast<double>(space.available)) return {};
  return {fmt::format(
      "the output may take up to {}, and {} has {} free; write fewer frames (every), fewer fields, or choose another "
      "--output",
      size_text(bytes), place.string(), size_text(static_cast<double>(space.available)))};
}

std::string size_text(double bytes) {
  for (const auto& [unit, name] : {std::pair{1e12, "TB"}, {1e9, "GB"}, {1e6, "MB"}})
    if (bytes >= unit) return fmt::format("{:.3g} {}", bytes / unit, name);
  return fmt::format("{:.3g} kB", bytes / 1e3);
}

MeasuredSpeed measured_speed(const Scene& scene) {
  const Scene sample = sample_of(scene);
  BuildOptions options;
  options.progress = ProgressMode::none;
  const std::unique_ptr<Solver> solver = build_solver(MPI_COMM_SELF, sample, std::move(options));
  solver->start();
  solver->step();  // the first step sorts everything anew
  const Solver::Counters before = solver->counters();
  for (int k = 0; k < 3; ++k) solver->step();
  const Solver::Counters after = solver->counters();
  MeasuredSpeed speed;
  speed.particles = static_cast<int>(Lattice(sample.particles[0], sample.fluid.spacing).size());
  speed.substeps = (after.substeps - before.substeps) / 3;
  speed.substep =
      (after.seconds - before.seconds) / static_cast<double>(after.substeps - before.substeps) / speed.particles;
  return speed;
}

}  // namespace trevi
