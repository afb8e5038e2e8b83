// From settings to a solver: the one place where the features of a step are chosen. A feature that the settings do not
// request is not built: it has no forcing, no filter, no array and no event.
#include "solver/make_solver.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <limits>

#include "base/version.hpp"
#include "boundary/geometry/periods.hpp"
#include "domain/migrate.hpp"
#include "fluid/filters/momentum_conserving.hpp"
#include "fluid/filters/vorticity_confinement.hpp"
#include "fluid/filters/xsph_viscosity.hpp"
#include "fluid/forcings/damping.hpp"
#include "fluid/forcings/floor_friction.hpp"
#include "fluid/forcings/gravity.hpp"
#include "io/writers.hpp"
#include "kernels/kernels.hpp"
#include "parallel/collective.hpp"
#include "parallel/reductions.hpp"
#include "solver/check_input.hpp"
#include "solver/density_solver.hpp"
#include "solver/first_slabs.hpp"
#include "solver/hue.hpp"
#include "solver/pbf_solver.hpp"
#include "trevi/error.hpp"

namespace trevi {

namespace {

// Damping zones precede gravity: they damp the motion, and would make water weigh less if it already included the fall
// in this substep.
std::vector<std::unique_ptr<Forcing>> make_forcings(const Settings& settings,
                                                    std::vector<std::unique_ptr<Forcing>> more) {
  std::vector<std::unique_ptr<Forcing>> forcings;
  for (const DampingSettings& zone : settings.dampings) forcings.push_back(std::make_unique<Damping>(zone));
  if (settings.gravity) forcings.push_back(std::make_unique<Gravity>(*settings.gravity));
  if (settings.walls.floor_friction > 0) {
    forcings.push_back(std::make_unique<FloorFriction>(settings.walls.floor_friction, settings.domain.min.z(),
                                                       settings.fluid.kernel_radius));
  }
  std::move(more.begin(), more.end(), std::back_inserter(forcings));
  return forcings;
}

template <class T>
std::vector<std::unique_ptr<VelocityFilter<T>>> make_filters(const Settings& settings, const DensityModel& model,
                                                             MPI_Comm comm, const Box& walls,
                                                             const std::shared_ptr<Obstacles>& obstacles) {
  std::vector<std::unique_ptr<VelocityFilter<T>>> filters;
  if (settings.vorticity) filters.push_back(std::make_unique<VorticityConfinement<T>>(model, *settings.vorticity));
  if (settings.vorticity && settings.vorticity_form == VorticityForm::projected)
    filters.back() = std::make_unique<MomentumConserving<T>>(comm, std::move(filters.back()));
  if (settings.viscosity) filters.push_back(std::make_unique<XsphViscosity<T>>(*settings.viscosity, model));
  if (settings.kinematic_viscosity) {
    const Real nu = *settings.kinematic_viscosity;
    const PointLattice lattice = lattice_of(settings.fluid);
    filters.push_back(std::make_unique<KinematicViscosity<T>>(
        nu, lattice, model.h, ViscousWalls(nu, settings.no_slip, lattice, model.h, walls, obstacles)));
  }
  return filters;
}

std::optional<AnalyticWallDensity> make_wall_density(const Settings& settings) {
  if (settings.walls.density != WallDensity::analytic) return std::nullopt;
  const bool positions_only = shifts_positions_only(settings.density, settings.gravity.value_or(Vec3::Zero()));
  return AnalyticWallDensity(box_of_walls(settings), kernels_of(settings.fluid).density, settings.fluid.spacing,
                             settings.fluid.kernel_radius,
                             positions_only ? WallSlope::of_positions : WallSlope::of_velocities);
}

std::shared_ptr<Obstacles> make_obstacles(const Settings& settings, const Walls& walls, Real time,
                                          const std::vector<BodyState>& bodies) {
  if (!has_solids(settings)) return nullptr;
  auto obstacles = std::make_shared<Obstacles>(settings, walls, make_wall_density(settings));
  if (!bodies.empty()) obstacles->floating()->set_states(bodies);
  obstacles->move(time, time);
  return obstacles;
}

std::unique_ptr<PressureProbes> make_probes(const Settings& settings) {
  auto probes = std::make_unique<PressureProbes>(settings);
  return probes->count() > 0 ? std::move(probes) : nullptr;
}

std::optional<PeriodicDomain> make_periodic(const Settings& settings, const Vec3& first) {
  if (settings.periodic == std::array<bool, 3>{}) return std::nullopt;
  return PeriodicDomain(settings.domain, settings.periodic, first);
}

template <class T>
void make_fluid(const Settings& settings, SolverParts<T>& parts) {
  const DensityModel model = density_model(settings);
  const Vec3 gravity = settings.gravity.value_or(Vec3::Zero());
  const Real spacing = settings.fluid.spacing;
  const PointLattice lattice = lattice_of(settings.fluid);
  const Walls walls(box_of_walls(settings), settings.walls, 1e-6 * model.h);
  const std::shared_ptr<Obstacles> obstacles = make_obstacles(settings, walls, parts.clock.time(), parts.bodies);
  if (ActiveAbsorption::is_wanted(settings)) {
    parts.absorption = std::make_unique<ActiveAbsorption>(settings, std::move(parts.paddle_offsets));
    parts.absorption->place(*obstacles);
    obstacles->move(parts.clock.time(), parts.clock.time());
  }
  parts.boundary =
      make_boundary({walls, obstacles, make_periodic(settings, parts.box.min), settings.fluid.dimensions == 2});
  parts.constraint =
      std::make_unique<DensityConstraint<T>>(model, tensile_of(settings), make_wall_density(settings), obstacles);
  parts.probes = make_probes(settings);
  parts.density_solver = make_density_solver<T>(
      settings.density, {*parts.comm, *parts.grid, parts.box, model, spacing, gravity, obstacles.get(),
                         parts.probes.get(), parts.flow ? parts.flow->openings() : nullptr, parts.scratch});
  parts.crush_limit = settings.density.crush_limit;
  parts.filters = make_filters<T>(settings, model, *parts.comm, walls.box(), obstacles);
  parts.substep_rule = {settings.cfl, model.h, gravity,
                        longest_viscous_step(settings.kinematic_viscosity.value_or(0), lattice, model.h),
                        settings.max_substeps};
  parts.diagnostics = std::make_unique<DiagnosticsSum>(
      *parts.comm, model,
      DiagnosticsSum::Surroundings{settings.domain, walls.box(), lattice_neighbours(lattice, model.h), gravity,
                                   water_mass(settings.fluid)});
}

// The parts of a solver apart from the settings, which have been checked.
struct Given {
  Particles particles;
  SolverExtras extras;
  FlowParts flow;
  CheckpointInfo info;
};

// The writers of the files that the settings request, which precede the observers of the caller.
std::vector<std::unique_ptr<Observer>> make_observers(MPI_Comm comm, const Settings& settings, const Given& given) {
  if (settings.output.directory.empty()) return {};
  WriterOptions options{settings.output.directory, sum_over_ranks(comm, given.particles.size()), {}, given.info};
  if (given.extras.step > 0) options.restart_step = given.extras.step;
  return make_writers_and_folder(comm, settings, options);
}

bool wants_hue(const Settings& settings) {
  return settings.colour == Colour::rainbow_x && !settings.output.directory.empty();
}

std::unique_ptr<Balance> make_balance(MPI_Comm comm, const Settings& settings) {
  constexpr Real min_gain = 0.01;
  return std::make_unique<Balance>(comm,
                                   settings.slabs == SlabCuts::balanced ? min_gain : std::numeric_limits<Real>::max());
}

template <class T>
std::unique_ptr<Solver> make(MPI_Comm comm, const Settings& settings, Given given) {
  SolverExtras& extras = given.extras;
  check_particles(comm, settings, given.particles);
  SolverParts<T> parts;
  parts.observers = make_observers(comm, settings, given);
  parts.comm = std::make_unique<OwnCommunicator>(comm);
  parts.particles = std::move(given.particles);
  parts.particles.has_hue = max_over_ranks(comm, parts.particles.has_hue ? 1.0 : 0.0) > 0;
  if (wants_hue(settings) && !parts.particles.has_hue) add_hue(comm, parts.particles);
  if (!has_solids(settings) && !given.flow.inlets_and_drains)  // which have fixed places in the box
    parts.first_cell = extras.first_cell ? *extras.first_cell : first_cell(*parts.comm, settings, parts.particles);
  parts.box = PeriodicDomain::turned(settings.domain, settings.fluid.kernel_radius, parts.first_cell);
  if (!settings.domain.contains(parts.box.min) || (parts.box.min.array() >= settings.domain.max.array()).any())
    throw InputError("settings of the solver: SolverExtras::first_cell must be in the box");
  parts.grid = std::make_unique<CellGrid>(cell_grid(settings, parts.box));
  parts.particles.predicted = parts.particles.position;
  const auto rows = [&](const Slabs& slabs) {
    RowWeights weights;
    add_row_weights(*parts.grid, slabs, parts.particles, weights);
    return weights;
  };
  parts.slabs = std::make_unique<Slabs>(first_slabs(*parts.comm, settings, *parts.grid,
                                                    {plane_weights(*parts.comm, *parts.grid, parts.particles), rows}));
  migrate(*parts.comm, parts.particles, &Particles::position, *parts.grid, *parts.slabs);
  parts.balance = make_balance(*parts.comm, settings);
  parts.clock = {extras.step, settings.dt, extras.substeps};
  parts.force_sums = std::move(extras.force_sums);
  parts.corner = settings.domain.min;
  parts.supplied_energy = extras.supplied_energy;
  parts.paddle_offsets = std::move(extras.paddle_offsets);
  parts.bodies = std::move(extras.bodies);
  parts.water_mass = water_mass(settings.fluid);
  parts.gravity = settings.gravity.value_or(Vec3::Zero());
  parts.requests = std::move(extras.requests);
  std::move(extras.observers.begin(), extras.observers.end(), std::back_inserter(parts.observers));
  parts.flow = std::move(given.flow.inlets_and_drains);
  make_fluid(settings, parts);
  std::vector<std::unique_ptr<Forcing>> more;
  for (std::unique_ptr<Fountain>& fountain : given.flow.fountains) {
    if (shifts_positions_only(settings.density, parts.gravity)) fountain->let_fall(parts.gravity);
    more.push_back(std::move(fountain));
  }
  std::move(extras.forcings.begin(), extras.forcings.end(), std::back_inserter(more));
  if (parts.flow) {
    parts.flow->begin(*parts.comm, *parts.boundary, parts.particles);
    for (auto& nozzle : parts.flow->forcings()) more.push_back(std::move(nozzle));
  }
  const std::size_t own = more.size();
  parts.forcings = make_forcings(settings, std::move(more));
  parts.first_own_forcing = parts.forcings.size() - own;
  return std::make_unique<PbfSolver<T>>(std::move(parts));
}

Settings checked(MPI_Comm comm, const Settings& settings, const SolverExtras& extras) {
  Settings all;
  all_or_none(comm, [&] { all = checked_and_resolved(settings); });  // may be wrong on one rank alone
  check_extras(comm, extras);
  return all;
}

std::unique_ptr<Solver> make_checked(MPI_Comm comm, const Settings& all, Given given) {
  if (all.density.precision == Precision::single) return make<float>(comm, all, std::move(given));
  return make<double>(comm, all, std::move(given));
}

}  // namespace

std::unique_ptr<Solver> make_solver(MPI_Comm comm, const Settings& settings, Particles particles, SolverExtras extras) {
  const Settings all = checked(comm, settings, extras);
  Settings of_flow = all;
  of_flow.domain = settings.domain;  // as the program has it, not fitted to its cells
  FlowParts flow = make_flow(comm, of_flow, std::move(extras.flow));
  CheckpointInfo info;
  info.program_version = trevi_version();
  info.seed = static_cast<std::int64_t>(all.seed);
  return make_checked(comm, all, {std::move(particles), std::move(extras), std::move(flow), info});
}

std::unique_ptr<Solver> make_solver_with(MPI_Comm comm, const Settings& settings, Particles particles,
                                         SolverExtras extras, FlowParts flow, const CheckpointInfo& info) {
  const Settings all = checked(comm, settings, extras);
  return make_checked(comm, all, {std::move(particles), std::move(extras), std::move(flow), info});
}

}  // namespace trevi
