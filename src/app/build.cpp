#include "app/build.hpp"

#include <algorithm>
#include <filesystem>
#include <limits>

#include "app/preflight/envelope.hpp"
#include "fluid/constraint/density.hpp"
#include "io/frames/vtkhdf.hpp"
#include "io/frames/vtu.hpp"
#include "io/run_directory/output_directory.hpp"
#include "io/tables/gauge_series.hpp"
#include "io/tables/obstacle_series.hpp"
#include "io/tables/series.hpp"
#include "live/live_view.hpp"
#include "music/music.hpp"
#include "parallel/reductions.hpp"
#include "scene/initial_particles.hpp"
#include "scene/make_flow.hpp"
#include "scene/obstacle_files.hpp"
#include "scene/scene_changes.hpp"
#include "solver/density_solver.hpp"
#include "trevi/error.hpp"

namespace trevi {

namespace {

ColourScale colour_scale(const Scene& scene, GlobalId particles) {
  ColourScale scale;
  if (scene.colour) scale.by = *scene.colour;
  scale.bottom = scene.domain.min.z();
  scale.top = scene.domain.max.z();
  for (const FountainSettings& fountain : scene.fountains)
    scale.speed_max = std::max(scale.speed_max, fountain.top_speed());
  for (const InletSettings& inlet : scene.inlets) scale.speed_max = std::max(scale.speed_max, inlet.top_speed());
  scale.total = particles;
  return scale;
}

// A run that is asked to stop leaves a checkpoint, whether the scene has a table for them or not.
CheckpointOptions checkpoint_options(const Scene& scene, const BuildOptions& build,
                                     std::optional<std::int64_t> restart_step) {
  CheckpointOptions options;
  options.directory = build.directory;
  options.info = build.info;
  options.restart_step = restart_step;
  options.when = scene.output.checkpoint ? CheckpointTimes::scheduled : CheckpointTimes::asked_for;
  if (scene.output.checkpoint) {
    options.schedule = scene.output.checkpoint->schedule;
    options.keep = scene.output.checkpoint->keep;
  }
  return options;
}

std::shared_ptr<const ObstacleSurfaces> obstacle_surfaces(const Scene& scene) {
  if (scene.obstacles.empty()) return nullptr;
  return std::make_shared<const ObstacleSurfaces>(scene.obstacles, scene.fluid.spacing / 50);
}

// The viewer's own colours are the scene's, or else go by the places in the start lattice.
std::unique_ptr<Observer> build_live_view(MPI_Comm comm, const Scene& scene, const BuildOptions& options,
                                          GlobalId particles) {
  LiveViewOptions live;
  live.link = options.viewer;
  live.requests = options.requests;
  live.scene.name = scene.name;
  live.scene.directory = std::filesystem::absolute(options.directory).string();
  live.scene.min = scene.domain.min;
  live.scene.max = scene.domain.max;
  live.scene.spacing = scene.fluid.spacing;
  live.scene.rest_density = scene.fluid.rest_density;
  live.scene.ranks = size_of(comm);
  live.scene.last_step = options.last_step;
  live.cell = scene.fluid.kernel_radius;
  live.colour = colour_scale(scene, particles);
  if (!scene.colour) live.colour.by = Colour::rainbow_id;
  return make_live_view(comm, std::move(live));
}

std::vector<std::unique_ptr<Observer>> build_observers(MPI_Comm comm, const Scene& scene, const BuildOptions& options,
                                                       GlobalId particles) {
  std::vector<std::unique_ptr<Observer>> observers;
  std::optional<std::int64_t> restart_step;
  if (options.restart) restart_step = options.restart->step;
  const OutputSettings& output = scene.output;
  const auto surfaces = obstacle_surfaces(scene);
  if (!options.directory.empty()) make_output_directory(comm, options.directory);
  if (options.lock != nullptr) options.lock->take();
  if (output.series) {
    const int fountains = static_cast<int>(scene.fountains.size() + scene.inlets.size());
    const bool flow = !scene.inlets.empty() || !scene.drains.empty();
    observers.push_back(
        std::make_unique<SeriesWriter>(comm, SeriesOptions{options.directory, *output.series, fountains, restart_step,
                                                           options.energy, flow, is_supplied(scene)}));
  }
  const TableOptions table{options.directory, output.series.value_or(Schedule{}), restart_step};
  if (output.series && !scene.obstacles.empty())
    observers.push_back(std::make_unique<ObstacleSeries>(comm, table, scene.obstacles.size()));
  if (output.series && !scene.gauges.empty()) observers.push_back(std::make_unique<GaugeSeries>(comm, table, scene));
  if (output.vtu) {
    observers.push_back(make_vtu_writer(comm, {options.directory, output.vtu->schedule, output.vtu->fields,
                                               colour_scale(scene, particles), restart_step, surfaces}));
  }
  if (output.vtkhdf) {
    observers.push_back(make_vtkhdf_writer(comm, {options.directory, output.vtkhdf->schedule, output.vtkhdf->fields,
                                                  colour_scale(scene, particles), restart_step, surfaces}));
  }
  observers.push_back(std::make_unique<CheckpointWriter>(comm, checkpoint_options(scene, options, restart_step)));
  observers.push_back(std::make_unique<Progress>(
      comm, ProgressOptions{
                .mode = options.progress, .first_step = restart_step.value_or(0), .last_step = options.last_step}));
  // Last, as it may hold the run: all other observers have then written the step.
  if (options.viewed) observers.push_back(build_live_view(comm, scene, options, particles));
  return observers;
}

}  // namespace

CheckpointInfo checkpoint_info(MPI_Comm comm, const Scene& scene) {
  return {scene.text,
          TREVI_VERSION,
          static_cast<std::int64_t>(scene.seed),
          scene.overrides,
          music_checksums(comm, scene),
          obstacle_checksums(scene)};
}

std::shared_ptr<EnergyRise> make_energy_rise(const Scene& scene) {
  if (!scene.output.series) return nullptr;
  const Vec3 gravity = scene.gravity.value_or(Vec3::Zero());
  for (std::size_t a = 0; a < 3; ++a)  // water falls for ever along a periodic axis
    if (scene.periodic[a] && gravity[static_cast<Eigen::Index>(a)] != 0) return nullptr;
  const Real g = gravity.norm();
  auto energy = std::make_shared<EnergyRise>(water_mass(scene.fluid), g, scene.fluid.kernel_radius);
  const Vec3 extent = scene.domain.max - scene.domain.min;
  if (scene.obstacles.empty() && !is_supplied(scene) && is_downward(gravity))
    energy->set_tank(extent.x() * extent.y(), scene.fluid.spacing);
  return energy;
}

std::unique_ptr<Solver> build_solver(MPI_Comm comm, const Scene& scene, BuildOptions options) {
  Particles particles = options.restart ? restored_particles(comm, scene, std::move(options.restart->rows))
                                        : initial_particles(comm, scene);
  SolverExtras extras;
  std::optional<FlowState> flow;
  if (options.restart) {
    flow = options.restart->flow;
    extras.step = options.restart->step;
    extras.substeps = options.restart->substeps;
    extras.first_cell = options.restart->first_cell;
    extras.force_sums = options.restart->force_sums;
    extras.supplied_energy = options.restart->supplied_energy;
  }
  extras.requests = options.requests;
  std::shared_ptr<LiveSound> live;
  extras.forcings = make_fountains(comm, scene, live);
  extras.flow = make_flow(comm, scene, std::move(flow), live);
  extras.observers = build_observers(comm, scene, options, sum_over_ranks(comm, particles.size()));
  return make_solver(comm, scene, std::move(particles), std::move(extras));
}

}  // namespace trevi
