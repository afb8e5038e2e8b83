#include "app/build.hpp"

#include <algorithm>
#include <filesystem>
#include <limits>

#include "fluid/constraint/density.hpp"
#include "io/run_directory/output_directory.hpp"
#include "io/writers.hpp"
#include "live/live_view.hpp"
#include "parallel/reductions.hpp"
#include "scene/initial_particles.hpp"
#include "scene/scene_flow.hpp"
#include "solver/density_solver.hpp"
#include "solver/make_solver.hpp"
#include "trevi/error.hpp"

namespace trevi {

namespace {

// The viewer shows the colours of the scene; without them, colours by the places in the initial lattice.
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
  if (!options.directory.empty()) make_output_directory(comm, options.directory);
  if (options.lock != nullptr) options.lock->take();
  observers = make_writers(comm, scene, {options.directory, particles, restart_step, options.info, options.energy});
  observers.push_back(std::make_unique<Progress>(
      comm, ProgressOptions{
                .mode = options.progress, .first_step = restart_step.value_or(0), .last_step = options.last_step}));
  // Last, because it may hold the run: all other observers have then written the step.
  if (options.viewed) observers.push_back(build_live_view(comm, scene, options, particles));
  return observers;
}

}  // namespace

std::shared_ptr<EnergyRise> make_energy_rise(const Scene& scene) {
  if (!scene.output.series) return nullptr;
  const Vec3 gravity = scene.gravity.value_or(Vec3::Zero());
  for (std::size_t a = 0; a < 3; ++a)  // water falls for ever along a periodic axis
    if (scene.periodic[a] && gravity[static_cast<Eigen::Index>(a)] != 0) return nullptr;
  const Real g = gravity.norm();
  auto energy = std::make_shared<EnergyRise>(water_mass(scene.fluid), g, scene.fluid.kernel_radius, scene.dt);
  const Vec3 extent = scene.domain.max - scene.domain.min;
  if (!has_solids(scene) && !is_supplied(scene) && is_downward(gravity))
    energy->set_tank(extent.x() * extent.y(), scene.fluid.spacing);
  return energy;
}

std::unique_ptr<Solver> build_solver(MPI_Comm comm, const Scene& scene, BuildOptions options) {
  Particles particles = options.restart ? restored_particles(comm, scene, std::move(options.restart->rows))
                                        : initial_particles(comm, scene);
  SolverExtras extras;
  if (options.restart) {
    extras.flow = options.restart->flow;
    extras.step = options.restart->step;
    extras.substeps = options.restart->substeps;
    extras.first_cell = options.restart->first_cell;
    extras.force_sums = options.restart->force_sums;
    extras.supplied_energy = options.restart->supplied_energy;
    extras.paddle_offsets = options.restart->paddle_offsets;
    extras.bodies = options.restart->bodies;
  }
  extras.requests = options.requests;
  FlowParts flow = make_scene_flow(comm, scene, std::move(extras.flow));
  extras.observers = build_observers(comm, scene, options, sum_over_ranks(comm, particles.size()));
  Settings settings = scene;
  settings.output.directory.clear();  // they have been built, with what restarts need
  return make_solver_with(comm, settings, std::move(particles), std::move(extras), std::move(flow), options.info);
}

}  // namespace trevi
