// From settings to a solver: the one place where the features of a step are chosen. A feature that the settings leave
// out is not built: it has no forcing, no filter, no array and no event.
#include <fmt/format.h>

#include <algorithm>
#include <limits>

#include "boundary/geometry/periods.hpp"
#include "domain/migrate.hpp"
#include "fluid/filters/momentum_conserving.hpp"
#include "fluid/filters/no_slip.hpp"
#include "fluid/filters/vorticity_confinement.hpp"
#include "fluid/filters/xsph_viscosity.hpp"
#include "fluid/forcings/floor_friction.hpp"
#include "fluid/forcings/gravity.hpp"
#include "kernels/kernels.hpp"
#include "parallel/collective.hpp"
#include "solver/density_solver.hpp"
#include "solver/first_slabs.hpp"
#include "solver/pbf_solver.hpp"
#include "trevi/error.hpp"

namespace trevi {

namespace {

std::vector<std::unique_ptr<Forcing>> make_forcings(const Settings& settings,
                                                    std::vector<std::unique_ptr<Forcing>> more) {
  std::vector<std::unique_ptr<Forcing>> forcings;
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
  const auto velocity = std::make_shared<VelocityField<T>>();
  if (settings.vorticity)
    filters.push_back(std::make_unique<VorticityConfinement<T>>(model, *settings.vorticity, velocity));
  if (settings.vorticity && settings.vorticity_form == VorticityForm::projected)
    filters.back() = std::make_unique<MomentumConserving<T>>(comm, std::move(filters.back()));
  if (settings.viscosity) filters.push_back(std::make_unique<XsphViscosity<T>>(*settings.viscosity, model, velocity));
  if (settings.kinematic_viscosity)
    filters.push_back(std::make_unique<KinematicViscosity<T>>(*settings.kinematic_viscosity, settings.fluid.spacing,
                                                              model.h, velocity));
  if (settings.no_slip)
    filters.push_back(std::make_unique<NoSlip<T>>(*settings.kinematic_viscosity, settings.fluid, walls, obstacles));
  return filters;
}

std::optional<AnalyticWallDensity> make_wall_density(const Settings& settings) {
  if (settings.walls.density != WallDensity::analytic) return std::nullopt;
  return AnalyticWallDensity(box_of_walls(settings.domain, settings.periodic), kernels_of(settings.fluid).density,
                             settings.fluid.spacing, settings.fluid.kernel_radius);
}

void check_inside(MPI_Comm comm, const Settings& settings, const Particles& particles) {
  all_or_none(comm, [&] {
    const auto bad = std::find_if(particles.position.begin(), particles.position.end(),
                                  [&](const Vec3& p) { return !settings.domain.contains(p); });
    if (bad == particles.position.end()) return;
    throw InputError(fmt::format("particle {} at ({}, {}, {}) is outside the box; enlarge the domain or move it",
                                 particles.id[static_cast<std::size_t>(bad - particles.position.begin())], bad->x(),
                                 bad->y(), bad->z()));
  });
}

void demand(bool holds, const char* rule) {
  if (!holds) throw InputError(std::string("settings of the solver: ") + rule);
}

void check_periodic(const Settings& all) {
  const Vec3 extent = all.domain.max - all.domain.min, gravity = all.gravity.value_or(Vec3::Zero());
  for (int a = 0; a < 3; ++a) {
    const bool periodic = all.periodic[static_cast<std::size_t>(a)];
    demand(!periodic || is_whole_period(extent[a], all.fluid.kernel_radius),
           "a periodic axis must be a whole number of kernel_radius long, three at least");
  }
  demand(!all.periodic[2] || gravity.z() == 0, "z cannot be periodic with gravity along it");
  for (const ObstacleSettings& obstacle : all.obstacles) {
    const std::string wrong = why_not_periodic(obstacle, all);
    demand(wrong.empty(), ("an obstacle " + wrong).c_str());
  }
}

// What a scene's reader has checked before, with the line at fault; a program may hand over anything. Comparisons are
// written so that a NaN fails. Lengths first: sums over the lattice would hardly end with an absurd radius.
Settings checked_and_resolved(const Settings& settings) {
  constexpr Real rounding = 1e-9;
  const FluidSettings& fluid = settings.fluid;
  demand(fluid.spacing > 0 && fluid.rest_density > 0, "fluid.spacing and rest_density must be positive");
  demand(!fluid.kernel_radius.given() || (fluid.kernel_radius >= (min_kernel_ratio - rounding) * fluid.spacing &&
                                          fluid.kernel_radius <= (largest_kernel_ratio + rounding) * fluid.spacing),
         "fluid.kernel_radius must be 1.2 to 4 times the spacing");
  Settings all = resolved(settings);
  const Real h = all.fluid.kernel_radius;
  demand(((all.domain.max - all.domain.min).array() >= h).all(),
         "the domain must be at least a kernel_radius wide in each axis");
  check_periodic(all);
  for (const GaugeSettings& gauge : all.gauges) {
    demand(gauge.radius > 0 && gauge.normal.allFinite(), "a gauge must have a radius and a normal");
    demand(gauge.kind != GaugeKind::pressure || !all.obstacles.empty(), "a gauge of pressure needs an obstacle");
  }
  demand(all.dt > 0, "dt must be positive");
  demand(all.max_substeps >= 1 && all.max_compression > 0, "max_substeps and max_compression must be positive");
  demand(all.density.iterations >= 1, "density.iterations must be at least 1");
  demand(all.density.method != Method::chebyshev || all.density.constraint == Constraint::inequality,
         "density.method chebyshev explodes with an equality; use the inequality, or jacobi");
  demand(all.density.method != Method::anderson || all.obstacles.empty(),
         "density.method anderson knows no obstacles; use chebyshev or jacobi");
  all.domain = PeriodicDomain::fitted(all.domain, all.periodic, h);
  demand(!all.viscosity || !all.kinematic_viscosity, "give viscosity or kinematic_viscosity, not both");
  demand(!all.no_slip || all.kinematic_viscosity, "no_slip needs a kinematic_viscosity");
  demand(!all.kinematic_viscosity || all.cfl > 0 ||
             all.dt <= longest_viscous_step(*all.kinematic_viscosity, fluid.spacing, h) * (1 + rounding),
         "kinematic_viscosity is too much for dt; lower one of them, or give a cfl, which splits steps");
  return all;
}

std::shared_ptr<Obstacles> make_obstacles(const Settings& settings, const Walls& walls, Real time) {
  if (settings.obstacles.empty()) return nullptr;
  auto obstacles = std::make_shared<Obstacles>(settings, walls, make_wall_density(settings));
  obstacles->move(time, time);
  return obstacles;
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
  const Walls walls(box_of_walls(settings.domain, settings.periodic), settings.walls, 1e-6 * model.h);
  const std::shared_ptr<Obstacles> obstacles = make_obstacles(settings, walls, parts.clock.time());
  parts.boundary = make_boundary({walls, obstacles, make_periodic(settings, parts.box.min)});
  parts.constraint =
      std::make_unique<DensityConstraint<T>>(model, tensile_of(settings), make_wall_density(settings), obstacles);
  parts.density_solver = make_density_solver<T>(
      settings.density, {*parts.comm, *parts.grid, parts.box, model, spacing, gravity, obstacles.get()});
  parts.max_compression = settings.max_compression;
  parts.filters = make_filters<T>(settings, model, *parts.comm, walls.box(), obstacles);
  parts.substep_rule = {settings.cfl, model.h, gravity,
                        longest_viscous_step(settings.kinematic_viscosity.value_or(0), spacing, model.h),
                        settings.max_substeps};
  parts.diagnostics = std::make_unique<DiagnosticsSum>(
      *parts.comm, model,
      DiagnosticsSum::Surroundings{settings.domain, walls.box(), lattice_neighbours(spacing, model.h), gravity,
                                   water_mass(settings.fluid)});
}

template <class T>
std::unique_ptr<Solver> make(MPI_Comm comm, const Settings& settings, Particles particles, SolverExtras extras) {
  SolverParts<T> parts;
  parts.comm = std::make_unique<OwnCommunicator>(comm);
  parts.particles = std::move(particles);
  check_inside(*parts.comm, settings, parts.particles);
  if (settings.obstacles.empty() && !extras.flow)  // which stand where they are in the box
    parts.first_cell = extras.first_cell ? *extras.first_cell : first_cell(*parts.comm, settings, parts.particles);
  parts.box = PeriodicDomain::turned(settings.domain, settings.fluid.kernel_radius, parts.first_cell);
  demand(settings.domain.contains(parts.box.min) && (parts.box.min.array() < settings.domain.max.array()).all(),
         "the first cell must be in the box");
  parts.grid = std::make_unique<CellGrid>(cell_grid(settings, parts.box));
  parts.particles.predicted = parts.particles.position;
  parts.slabs = std::make_unique<Slabs>(
      first_slabs(settings, *parts.grid, plane_weights(*parts.comm, *parts.grid, parts.particles), size_of(comm)));
  migrate(*parts.comm, parts.particles, &Particles::position, *parts.grid, *parts.slabs);
  constexpr Real min_gain = 0.01;
  parts.balance = std::make_unique<Balance>(
      *parts.comm, settings.slabs == SlabCuts::balanced ? min_gain : std::numeric_limits<Real>::max());
  parts.clock = {extras.step, settings.dt, extras.substeps};
  parts.requests = std::move(extras.requests);
  parts.observers = std::move(extras.observers);
  parts.flow = std::move(extras.flow);
  if (parts.flow) {
    parts.flow->begin(*parts.comm, parts.particles);
    for (auto& nozzle : parts.flow->forcings()) extras.forcings.push_back(std::move(nozzle));
  }
  parts.forcings = make_forcings(settings, std::move(extras.forcings));
  make_fluid(settings, parts);
  return std::make_unique<PbfSolver<T>>(std::move(parts));
}

}  // namespace

std::unique_ptr<Solver> make_solver(MPI_Comm comm, const Settings& settings, Particles particles, SolverExtras extras) {
  const Settings all = checked_and_resolved(settings);
  if (all.density.precision == Precision::single)
    return make<float>(comm, all, std::move(particles), std::move(extras));
  return make<double>(comm, all, std::move(particles), std::move(extras));
}

}  // namespace trevi
