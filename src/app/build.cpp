#include "app/build.hpp"

#include <filesystem>
#include <limits>

#include "app/initial_particles.hpp"
#include "app/obstacle_files.hpp"
#include "app/scene_changes.hpp"
#include "app/scene_place.hpp"
#include "fluid/density.hpp"
#include "fluid/fountain.hpp"
#include "io/obstacle_series.hpp"
#include "io/output_directory.hpp"
#include "io/series.hpp"
#include "io/vtkhdf.hpp"
#include "io/vtu.hpp"
#include "live/live_view.hpp"
#include "music/music.hpp"
#include "parallel/reductions.hpp"
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
  scale.total = particles;
  return scale;
}

// A run that is asked to stop leaves a checkpoint, whether the scene has a table for them or not.
CheckpointOptions checkpoint_options(MPI_Comm comm, const Scene& scene, const std::string& directory,
                                     std::optional<std::int64_t> restart_step) {
  CheckpointOptions options;
  options.directory = directory;
  options.info = {scene.text, TREVI_VERSION, static_cast<std::int64_t>(scene.seed), scene.overrides,
                  music_checksums(comm, scene), obstacle_checksums(scene)};
  options.restart_step = restart_step;
  options.when = scene.output.checkpoint ? CheckpointTimes::scheduled : CheckpointTimes::asked_for;
  if (scene.output.checkpoint) {
    options.schedule = scene.output.checkpoint->schedule;
    options.keep = scene.output.checkpoint->keep;
  }
  return options;
}

// The viewer's rainbow is the scene's, or else goes by the places in the start lattice.
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
  if (live.colour.by == Colour::blue || live.colour.by == Colour::speed) live.colour.by = Colour::rainbow_id;
  return make_live_view(comm, std::move(live));
}

std::vector<std::unique_ptr<Observer>> build_observers(MPI_Comm comm, const Scene& scene, const BuildOptions& options,
                                                       GlobalId particles) {
  std::vector<std::unique_ptr<Observer>> observers;
  std::optional<std::int64_t> restart_step;
  if (options.restart) restart_step = options.restart->step;
  const OutputSettings& output = scene.output;
  if (!options.directory.empty()) make_output_directory(comm, options.directory);
  if (options.lock != nullptr) options.lock->take();
  if (output.series) {
    const int fountains = static_cast<int>(scene.fountains.size());
    observers.push_back(std::make_unique<SeriesWriter>(
        comm, SeriesOptions{options.directory, *output.series, fountains, restart_step, options.energy}));
  }
  if (output.series && !scene.obstacles.empty()) {
    observers.push_back(std::make_unique<ObstacleSeries>(
        comm, ObstacleSeriesOptions{options.directory, *output.series, static_cast<int>(scene.obstacles.size()),
                                    restart_step}));
  }
  if (output.vtu) {
    observers.push_back(make_vtu_writer(comm, {options.directory, output.vtu->schedule, output.vtu->fields,
                                               colour_scale(scene, particles), restart_step}));
  }
  if (output.vtkhdf) {
    observers.push_back(make_vtkhdf_writer(comm, {options.directory, output.vtkhdf->schedule, output.vtkhdf->fields,
                                                  colour_scale(scene, particles), restart_step}));
  }
  observers.push_back(
      std::make_unique<CheckpointWriter>(comm, checkpoint_options(comm, scene, options.directory, restart_step)));
  observers.push_back(std::make_unique<Progress>(
      comm, ProgressOptions{
                .mode = options.progress, .first_step = restart_step.value_or(0), .last_step = options.last_step}));
  // Last, as it may hold the run: all other observers have then written the step.
  if (options.viewed) observers.push_back(build_live_view(comm, scene, options, particles));
  return observers;
}

}  // namespace

std::shared_ptr<EnergyRise> make_energy_rise(const Scene& scene) {
  if (!scene.output.series || !scene.fountains.empty()) return nullptr;
  const Real g = scene.gravity.value_or(Vec3::Zero()).norm();
  return std::make_shared<EnergyRise>(particle_mass(scene.fluid) * g * scene.fluid.kernel_radius);
}

std::vector<std::unique_ptr<Forcing>> make_fountains(MPI_Comm comm, const Scene& scene) {
  std::vector<std::unique_ptr<Forcing>> forcings;
  std::shared_ptr<LiveSound> live;
  int index = 0;
  for (const FountainSettings& fountain : scene.fountains) {
    std::unique_ptr<Pump> pump = std::make_unique<ConstantPump>(fountain.speed);
    if (fountain.music) {
      pump = told_at(scene, fountain.line, "[[fountain]] music",
                     [&] { return make_music_pump(comm, *fountain.music, live); });
    }
    forcings.push_back(
        std::make_unique<Fountain>(fountain, std::move(pump), scene.domain.min.z(), scene.seed, index++));
  }
  return forcings;
}

std::unique_ptr<Solver> build_solver(MPI_Comm comm, const Scene& scene, BuildOptions options) {
  Particles particles = options.restart ? restored_particles(comm, scene, std::move(options.restart->rows))
                                        : initial_particles(comm, scene);
  SolverExtras extras;
  if (options.restart) {
    extras.step = options.restart->step;
    extras.substeps = options.restart->substeps;
  }
  extras.requests = options.requests;
  extras.forcings = make_fountains(comm, scene);
  extras.observers = build_observers(comm, scene, options, sum_over_ranks(comm, particles.size()));
  return make_solver(comm, scene, std::move(particles), std::move(extras));
}

}  // namespace trevi
