#include "app/build.hpp"

#include <filesystem>
#include <limits>

#include "app/initial_particles.hpp"
#include "app/scene_changes.hpp"
#include "app/scene_place.hpp"
#include "fluid/floor_friction.hpp"
#include "fluid/fountain.hpp"
#include "fluid/gravity.hpp"
#include "fluid/kernels.hpp"
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

// Lengths of the report are in units of its spacing, 0.1 m.
Real refinement(const Scene& scene) {
  const Real ratio = scene.fluid.spacing / 0.1;
  return ratio * ratio;
}

std::optional<Tensile> tensile_of(const Scene& scene) {
  if (!scene.tensile) return std::nullopt;
  return Tensile{scene.tensile->k * refinement(scene), scene.tensile->n, scene.tensile->dq};
}

template <class T>
std::vector<std::unique_ptr<VelocityFilter<T>>> build_filters(const Scene& scene, const DensityModel& model) {
  std::vector<std::unique_ptr<VelocityFilter<T>>> filters;
  const auto velocity = std::make_shared<VelocityField<T>>();
  if (scene.vorticity) filters.push_back(std::make_unique<VorticityConfinement<T>>(model, *scene.vorticity, velocity));
  std::optional<XsphFactor> xsph;
  if (scene.viscosity) xsph = xsph_of_share(*scene.viscosity, model);
  if (scene.kinematic_viscosity) xsph = xsph_of_viscosity(*scene.kinematic_viscosity, scene.fluid.spacing, model.h);
  if (xsph) filters.push_back(std::make_unique<XsphViscosity<T>>(*xsph, model.h, velocity));
  return filters;
}

std::optional<AnalyticWallDensity> build_wall_density(const Scene& scene) {
  if (scene.walls.density != WallDensity::analytic) return std::nullopt;
  return AnalyticWallDensity({scene.domain_min, scene.domain_max}, scene.fluid.density_kernel, scene.fluid.spacing,
                             scene.fluid.kernel_radius);
}

ColourScale colour_scale(const Scene& scene, GlobalId particles) {
  ColourScale scale;
  if (scene.colour) scale.by = *scene.colour;
  scale.bottom = scene.domain_min.z();
  scale.top = scene.domain_max.z();
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
                  music_checksums(comm, scene)};
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
  live.scene.min = scene.domain_min;
  live.scene.max = scene.domain_max;
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
  // Last, as it may hold the run, which then has written all of its step.
  if (options.viewed) observers.push_back(build_live_view(comm, scene, options, particles));
  return observers;
}

template <class T>
std::unique_ptr<Solver> build(MPI_Comm comm, const Scene& scene, BuildOptions options) {
  const DensityModel model = density_model(scene);
  SolverParts<T> parts;
  parts.comm = comm;
  parts.box = {scene.domain_min, scene.domain_max};
  parts.grid = std::make_unique<CellGrid>(scene.domain_min, scene.domain_max, model.h, scene.slab_axis);
  InitialState state = options.restart ? restored_particles(comm, scene, *parts.grid, std::move(options.restart->rows))
                                       : initial_particles(comm, scene, *parts.grid);
  parts.slabs = std::make_unique<Slabs>(std::move(state.slabs));
  constexpr Real least_gain = 0.01;
  parts.balance = std::make_unique<Balance>(
      comm, scene.slabs == SlabCuts::balanced ? least_gain : std::numeric_limits<Real>::max());
  parts.particles = std::move(state.particles);
  parts.clock.dt = scene.dt;
  if (options.restart) {
    parts.clock.step = options.restart->step;
    parts.clock.substeps = options.restart->substeps;
  }
  parts.requests = options.requests;
  parts.walls = std::make_unique<Walls>(parts.box, scene.walls, 1e-6 * model.h);
  parts.constraint = std::make_unique<DensityConstraint<T>>(model, tensile_of(scene), build_wall_density(scene));
  parts.method = make_density_method<T>(
      scene.density, {comm, *parts.grid, parts.box, model, scene.fluid.spacing, scene.gravity.value_or(Vec3::Zero())});
  parts.forcings = build_forcings(comm, scene);
  parts.filters = build_filters<T>(scene, model);
  parts.substeps = {scene.cfl, scene.gravity.value_or(Vec3::Zero()),
                    longest_viscous_step(scene.kinematic_viscosity.value_or(0), scene.fluid.spacing, model.h)};
  parts.diagnostics = std::make_unique<DiagnosticsSum>(
      comm, parts.box, model, lattice_neighbours(scene.fluid.spacing, model.h), parts.substeps.gravity);
  parts.observers = build_observers(comm, scene, options, sum_over_ranks(comm, parts.particles.size()));
  return std::make_unique<PbfSolver<T>>(std::move(parts));
}

}  // namespace

DensityModel density_model(const Scene& scene) {
  return {particle_mass(scene.fluid), scene.fluid.rest_density,
          scene.fluid.kernel_radius,  scene.density.epsilon / refinement(scene),
          scene.density.constraint,   scene.fluid.density_kernel};
}

std::shared_ptr<EnergyRise> make_energy_rise(const Scene& scene) {
  if (!scene.output.series || !scene.fountains.empty()) return nullptr;
  const Real g = scene.gravity.value_or(Vec3::Zero()).norm();
  return std::make_shared<EnergyRise>(particle_mass(scene.fluid) * g * scene.fluid.kernel_radius);
}

std::vector<std::unique_ptr<Forcing>> build_forcings(MPI_Comm comm, const Scene& scene) {
  std::vector<std::unique_ptr<Forcing>> forcings;
  if (scene.gravity) forcings.push_back(std::make_unique<Gravity>(*scene.gravity));
  if (scene.walls.floor_friction > 0) {
    forcings.push_back(
        std::make_unique<FloorFriction>(scene.walls.floor_friction, scene.domain_min.z(), scene.fluid.kernel_radius));
  }
  std::shared_ptr<LiveSound> live;
  int index = 0;
  for (const FountainSettings& fountain : scene.fountains) {
    std::unique_ptr<Pump> pump = std::make_unique<ConstantPump>(fountain.speed);
    if (fountain.music) {
      pump = told_at(scene, fountain.line, "[[fountain]] music",
                     [&] { return make_music_pump(comm, *fountain.music, live); });
    }
    forcings.push_back(
        std::make_unique<Fountain>(fountain, std::move(pump), scene.domain_min.z(), scene.seed, index++));
  }
  return forcings;
}

std::unique_ptr<Solver> build_solver(MPI_Comm comm, const Scene& scene, BuildOptions options) {
  if (scene.density.precision == Precision::single) return build<float>(comm, scene, std::move(options));
  return build<double>(comm, scene, std::move(options));
}

}  // namespace trevi
