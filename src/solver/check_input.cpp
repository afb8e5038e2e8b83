#include "solver/check_input.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "boundary/geometry/closed_mesh.hpp"
#include "boundary/geometry/periods.hpp"
#include "boundary/periodic_domain.hpp"
#include "boundary/waves/check_wavemaker.hpp"
#include "fluid/filters/xsph_viscosity.hpp"
#include "fluid/in_two_dimensions.hpp"
#include "parallel/collective.hpp"
#include "solver/check_bodies.hpp"
#include "solver/check_flow.hpp"
#include "solver/demand.hpp"
#include "solver/density_solver.hpp"
#include "trevi/error.hpp"

namespace trevi {

namespace {

constexpr Real rounding = 1e-9;

void demand_no(const std::string& wrong, const std::string& name) { demand(wrong.empty(), name + " " + wrong); }

void check_plane(const Settings& all) {
  demand(all.fluid.dimensions == 2 || all.fluid.dimensions == 3, "fluid.dimensions must be 2 or 3");
  if (all.fluid.dimensions == 3) return;
  demand(!all.periodic[1], "y cannot be periodic in two dimensions");
  demand(all.slab_axis == 0, "slab_axis must be 0 in two dimensions");
  demand_no(why_not_along_plane(all.gravity.value_or(Vec3::Zero())), "gravity");
  const auto check_solid = [](const ObstacleSettings& one, const std::string& name) {
    const Oscillation swing = one.oscillation.value_or(Oscillation{});
    demand_no(why_not_in_plane(one), name + "shape:");
    for (const Vec3& along : {one.velocity, swing.amplitude}) demand_no(why_not_along_plane(along), name + "velocity");
    for (const Vec3& about : {one.rotate, one.angular_velocity, swing.rotation})
      demand_no(why_not_about_y(about), name + "rotate");
    if (one.wavemaker) demand_no(why_not_along_plane(one.wavemaker->direction), name + "wavemaker.direction");
  };
  for (std::size_t k = 0; k < all.obstacles.size(); ++k)
    check_solid(all.obstacles[k], fmt::format("obstacles[{}].", k));
  for (std::size_t k = 0; k < all.bodies.size(); ++k) check_solid(all.bodies[k], fmt::format("bodies[{}].", k));
  for (const auto& one : all.dampings)
    demand_no(one.direction.given() ? why_not_along_plane(one.direction) : "", "a damping's direction");
  for (const auto& one : all.fountains) demand_no(why_not_along_plane(one.direction), "a fountain's direction");
  for (const auto& one : all.inlets) demand_no(why_not_along_plane(one.direction), "an inlet's direction");
  for (const auto& one : all.drains)
    demand_no(one.shape == DrainShape::plane ? why_not_along_plane(one.axis) : "", "a drain's axis");
  for (const auto& one : all.gauges) demand_no(why_not_along_plane(one.normal), "a gauge's normal");
}

void check_periodic(const Settings& all) {
  const Vec3 extent = all.domain.max - all.domain.min, gravity = all.gravity.value_or(Vec3::Zero());
  for (int a = 0; a < 3; ++a) {
    const bool periodic = all.periodic[static_cast<std::size_t>(a)];
    demand(!periodic || is_whole_period(extent[a], all.fluid.kernel_radius),
           "a periodic axis must be a whole number of kernel_radius long, three at least");
  }
  demand(!all.periodic[2] || gravity.z() == 0, "z cannot be periodic with gravity along it");
  demand(!all.periodic[2] || all.walls.floor_friction == 0, "z cannot be periodic with walls.floor_friction");
  for (const ObstacleSettings& obstacle : all.obstacles) {
    const std::string wrong = why_not_periodic(obstacle, all);
    demand(wrong.empty(), ("an obstacle " + wrong).c_str());
  }
}

void check_numbers(const Settings& all) {
  demand(is_positive(all.dt), "dt must be positive");
  demand(is_amount(all.cfl), "cfl must not be negative");
  demand(all.max_substeps >= 1, "max_substeps must be at least 1");
  demand(!all.gravity || all.gravity->allFinite(), "gravity must be finite");
  demand(all.slab_axis == 0 || all.slab_axis == 1, "slab_axis must be 0 or 1");
  demand(!all.ranks || ((*all.ranks)[0] >= 1 && (*all.ranks)[1] >= 1), "ranks must be positive");
  demand(!all.ranks || !all.ranks_by_model, "ranks must be absent with ranks_by_model");
  demand(is_amount(all.walls.floor_friction), "walls.floor_friction must not be negative");
  demand(all.walls.restitution >= 0 && all.walls.restitution <= 1, "walls.restitution must be from 0 to 1");
  if (all.tensile) {
    demand(is_amount(all.tensile->k) && all.tensile->n >= 0, "tensile.k and n must not be negative");
    demand(all.tensile->dq >= 0 && all.tensile->dq < 1, "tensile.dq must be from 0 to 1");
  }
  demand(!all.vorticity || is_amount(*all.vorticity), "vorticity must not be negative");
}

void check_density(const DensitySettings& density) {
  demand(is_positive(density.crush_limit), "density.crush_limit must be positive");
  demand(density.iterations >= 1, "density.iterations must be at least 1");
  demand(!density.tolerance || is_positive(*density.tolerance), "density.tolerance must be positive");
  demand(is_amount(density.epsilon), "density.epsilon must not be negative");
  demand(is_positive(density.relaxation), "density.relaxation must be positive");
  demand(density.spectral_radius >= 0 && density.spectral_radius < 1, "density.spectral_radius must be from 0 to 1");
  demand(is_amount(density.max_shift), "density.max_shift must not be negative");
  demand(density.method != Method::chebyshev || density.constraint == Constraint::inequality,
         "density.method chebyshev explodes with an equality; use the inequality, or jacobi");
}

void check_viscosity(const Settings& all) {
  const FluidSettings& fluid = all.fluid;
  demand(!all.viscosity || (*all.viscosity >= 0 && *all.viscosity * fluid.rest_density <= 1 + rounding),
         "viscosity must not be negative, and times the rest density not more than 1");
  demand(!all.kinematic_viscosity || is_amount(*all.kinematic_viscosity), "kinematic_viscosity must not be negative");
  demand(!all.viscosity || !all.kinematic_viscosity, "give viscosity or kinematic_viscosity, not both");
  demand(!all.no_slip || all.kinematic_viscosity, "no_slip needs a kinematic_viscosity");
  demand(!all.kinematic_viscosity || all.cfl > 0 ||
             all.dt <= longest_viscous_step(*all.kinematic_viscosity, lattice_of(fluid), fluid.kernel_radius) *
                           (1 + rounding),
         "kinematic_viscosity is too much for dt; lower one of them, or give a cfl, which splits steps");
}

void check_mesh(const ObstacleSettings& obstacle, const std::string& name) {
  demand(obstacle.mesh != nullptr && !obstacle.mesh->triangles.empty(), name + "mesh must have triangles");
  const auto count = static_cast<std::int64_t>(obstacle.mesh->points.size());
  for (const Vec3& p : obstacle.mesh->points) demand(p.allFinite(), name + "mesh has a point that is not finite");
  for (const auto& corners : obstacle.mesh->triangles) {
    for (const std::int32_t corner : corners)
      demand(corner >= 0 && corner < count, name + "mesh has a triangle with a corner that is no point");
  }
  const std::string wrong = why_not_closed(*obstacle.mesh);
  demand(wrong.empty(), name + "mesh is not closed: " + wrong);
  const std::string where = where_shells_overlap(*obstacle.mesh);
  demand(where.empty(), name + "mesh has shells that overlap at " + where);
  demand(!is_flat(*obstacle.mesh), name + "mesh encloses no volume");
}

void check_shape(const ObstacleSettings& one, const std::string& name) {
  using enum ShapeKind;
  const bool is_round = one.shape == sphere || one.shape == cylinder || one.shape == capsule || one.shape == torus;
  demand(!is_round || is_positive(one.radius), name + "radius must be positive");
  demand(one.shape != box || (one.size.allFinite() && one.size.minCoeff() > 0), name + "size must be positive");
  const bool is_tall = one.shape == cylinder || one.shape == capsule;
  demand(!is_tall || is_positive(one.height), name + "height must be positive");
  demand(one.shape != torus || (is_positive(one.tube) && one.tube < one.radius),
         name + "tube must be positive, and less than the radius");
  demand((!is_tall && one.shape != torus) || (one.axis.allFinite() && one.axis.norm() > 0),
         name + "axis must have a length");
  if (one.shape == mesh) check_mesh(one, name);
  if (one.shape != basin) return;
  const bool is_box = !one.size.isZero();
  demand(!is_box || (one.size.allFinite() && one.size.minCoeff() > 0), name + "size must be positive");
  demand(is_box || (is_positive(one.radius) && is_positive(one.height)), name + "radius and height must be positive");
  demand(is_positive(one.wall), name + "wall must be positive");
  demand(!one.inside, name + "inside is not for a basin");
}

void check_obstacle(const ObstacleSettings& one, const std::string& name) {
  check_shape(one, name);
  demand(one.center.allFinite() && one.rotate.allFinite(), name + "center and rotate must be finite");
  demand(one.velocity.allFinite() && one.angular_velocity.allFinite(), name + "velocities must be finite");
  demand(!one.restitution || (*one.restitution >= 0 && *one.restitution <= 1),
         name + "restitution must be from 0 to 1");
  demand(is_amount(one.friction), name + "friction must not be negative");
  if (one.oscillation) {
    const Oscillation& swing = *one.oscillation;
    demand(swing.amplitude.allFinite() && swing.rotation.allFinite(), name + "oscillation must be finite");
    demand(is_positive(swing.period) && is_amount(swing.ramp), name +
                                                                   "oscillation.period must be positive, ramp not "
                                                                   "negative");
    demand(one.knots.empty() && one.velocity.isZero() && one.angular_velocity.isZero(),
           name + "oscillation is in place of knots and velocities");
  }
  demand(!one.wavemaker || (one.knots.empty() && !one.oscillation && one.velocity.isZero() &&
                            one.angular_velocity.isZero() && one.rotate.isZero()),
         name + "wavemaker is in place of all other motion");
  for (std::size_t k = 0; k < one.knots.size(); ++k) {
    demand(std::isfinite(one.knots[k].time) && one.knots[k].center.allFinite(), name + "knots must be finite");
    demand(k == 0 || one.knots[k].time > one.knots[k - 1].time, name + "knots must be in the order of their times");
  }
}

void check_waves(const Settings& all) {
  for (std::size_t k = 0; k < all.obstacles.size(); ++k) {
    if (!all.obstacles[k].wavemaker) continue;
    const std::string name = fmt::format("obstacles[{}].wavemaker.", k);
    const auto wrong = what_is_wrong(*all.obstacles[k].wavemaker, all.domain);
    demand(!wrong, wrong ? name + wrong->key + " " + wrong->why : "");
    demand(all.obstacles[k].wavemaker->gravity == -all.gravity.value_or(Vec3::Zero()).z(),
           name + "gravity must be that of the settings");
  }
  for (std::size_t k = 0; k < all.dampings.size(); ++k) {
    const DampingSettings& zone = all.dampings[k];
    const std::string name = fmt::format("dampings[{}].", k);
    demand(zone.min.allFinite() && zone.max.allFinite() && (zone.max - zone.min).minCoeff() > 0,
           name + "max must be greater than min on every axis");
    demand(is_amount(zone.rate), name + "rate must not be negative");
    demand(zone.direction.given(), name + "direction is missing, and the zone is at no single wall");
    const Vec3 d = zone.direction.value().cwiseAbs();
    demand(d == Vec3::UnitX() || d == Vec3::UnitY(), name + "direction must be along x or y, of length 1");
  }
}

bool stands(const Settings& all) {
  return std::any_of(all.obstacles.begin(), all.obstacles.end(), [](const auto& one) { return !one.moves(); });
}

void check_gauges(const Settings& all) {
  for (std::size_t k = 0; k < all.gauges.size(); ++k) {
    const GaugeSettings& gauge = all.gauges[k];
    const std::string name = fmt::format("gauges[{}].", k);
    demand(gauge.kind == GaugeKind::flow || gauge.kind == GaugeKind::pressure_in_water || is_positive(gauge.radius),
           name + "radius must be positive");
    demand(gauge.center.allFinite(), name + "center must be finite");
    const bool has_normal =
        gauge.kind == GaugeKind::pressure || gauge.kind == GaugeKind::flow || gauge.kind == GaugeKind::run_up;
    demand(!has_normal || is_direction(gauge.normal), name + "normal must have a length");
    demand(gauge.kind != GaugeKind::flow || (is_positive(gauge.size[0]) && is_positive(gauge.size[1])),
           name + "size must be positive");
    demand(gauge.kind != GaugeKind::run_up || gauge.normal.z() == 0, name + "normal must be level");
    demand(gauge.kind != GaugeKind::run_up || stands(all), "a gauge of run-up needs an obstacle that stands");
    demand(gauge.kind != GaugeKind::pressure_in_water ||
               (all.density.coarse_grid && is_downward(all.gravity.value_or(Vec3::Zero()))),
           "a gauge of pressure in the water needs density.coarse_grid and gravity along -z");
    demand(gauge.kind != GaugeKind::pressure || has_solids(all), "a gauge of pressure needs an obstacle or a body");
  }
}

// Ids of all ranks are sent to the rank given by their hash, where two equal ones become adjacent.
GlobalId first_double(MPI_Comm comm, const std::vector<GlobalId>& ids) {
  const int size = size_of(comm);
  const auto owner = [size](GlobalId id) { return static_cast<std::size_t>(id % size); };
  std::vector<int> counts(static_cast<std::size_t>(size), 0), from(counts.size()), begin(counts.size()), place;
  for (const GlobalId id : ids) ++counts[owner(id)];
  MPI_Alltoall(counts.data(), 1, MPI_INT, from.data(), 1, MPI_INT, comm);
  for (std::size_t k = 1; k < counts.size(); ++k) begin[k] = begin[k - 1] + counts[k - 1];
  place = begin;
  std::vector<GlobalId> sorted(ids.size());
  for (const GlobalId id : ids) sorted[static_cast<std::size_t>(place[owner(id)]++)] = id;
  std::vector<int> at(counts.size());
  for (std::size_t k = 1; k < counts.size(); ++k) at[k] = at[k - 1] + from[k - 1];
  std::vector<GlobalId> mine(static_cast<std::size_t>(at.back() + from.back()));
  MPI_Alltoallv(sorted.data(), counts.data(), begin.data(), MPI_INT64_T, mine.data(), from.data(), at.data(),
                MPI_INT64_T, comm);
  std::sort(mine.begin(), mine.end());
  const auto twice = std::adjacent_find(mine.begin(), mine.end());
  return twice == mine.end() ? -1 : *twice;
}

void check_own_particles(const Settings& settings, const Particles& particles) {
  const std::size_t count = particles.id.size();
  const bool in_plane = settings.fluid.dimensions == 2;
  const auto fits = [count](std::size_t length, bool may_be_empty) {
    return length == count || (may_be_empty && length == 0);
  };
  demand(fits(particles.position.size(), false) && fits(particles.velocity.size(), false) &&
             fits(particles.predicted.size(), true) && fits(particles.hue.size(), !particles.has_hue),
         "the fields of the particles have different lengths");
  for (std::size_t i = 0; i < count; ++i) {
    const Vec3 &p = particles.position[i], &v = particles.velocity[i];
    demand(particles.id[i] >= 0, "ids of particles must not be negative");
    if (!settings.domain.contains(p)) {
      throw InputError(fmt::format("particle {} at ({}, {}, {}) is outside the box; enlarge the domain or move it",
                                   particles.id[i], p.x(), p.y(), p.z()));
    }
    if (!v.allFinite()) throw InputError(fmt::format("particle {} has a velocity that is not finite", particles.id[i]));
    if (in_plane && (p.y() != 0 || v.y() != 0))
      throw InputError(fmt::format("particle {} is at y = {}, or has a velocity along y; in two dimensions both are 0",
                                   particles.id[i], p.y()));
  }
}

}  // namespace

bool is_same_solid(const ObstacleSettings& one, const ObstacleSettings& other) {
  if (other.center != one.center || other.shape != one.shape || other.path != one.path) return false;
  const bool same_mesh = one.mesh == other.mesh || (one.mesh && other.mesh && *one.mesh == *other.mesh);
  ObstacleSettings same = other;
  same.mesh = one.mesh;
  return same_mesh && same == one;
}

// Lengths are checked first: with an absurd radius, sums over the lattice would hardly ever end.
Settings checked_and_resolved(const Settings& settings) {
  const FluidSettings& fluid = settings.fluid;
  demand(is_positive(fluid.spacing) && is_positive(fluid.rest_density),
         "fluid.spacing and rest_density must be positive");
  demand(!fluid.kernel_radius.given() || (fluid.kernel_radius >= (min_kernel_ratio - rounding) * fluid.spacing &&
                                          fluid.kernel_radius <= (largest_kernel_ratio + rounding) * fluid.spacing),
         "fluid.kernel_radius must be 1.2 to 4 times the spacing");
  demand(settings.domain.min.allFinite() && settings.domain.max.allFinite(), "the domain must be finite");
  Settings all = resolved(settings);
  const Real h = all.fluid.kernel_radius;
  check_plane(all);
  const Vec3 thickness = fluid.dimensions == 2 ? Vec3(h * Vec3::UnitY()) : Vec3::Zero();  // that of the layer is given
  demand(((all.domain.max - all.domain.min + thickness).array() >= h).all(),
         "the domain must be at least a kernel_radius wide in each axis");
  check_numbers(all);
  check_density(all.density);
  for (std::size_t k = 0; k < all.obstacles.size(); ++k)
    check_obstacle(all.obstacles[k], fmt::format("obstacles[{}].", k));
  for (std::size_t k = 0; k < all.bodies.size(); ++k) check_obstacle(all.bodies[k], fmt::format("bodies[{}].", k));
  for (std::size_t k = 0; k < all.bodies.size(); ++k) {
    demand(all.periodic == std::array<bool, 3>{}, "bodies cannot be in a box with periodic axes");
    const std::string wrong = why_no_body(all, k);
    demand(wrong.empty(), fmt::format("bodies[{}] {}", k, wrong));
  }
  for (std::size_t k = 1; k < all.obstacles.size(); ++k) {
    for (std::size_t j = 0; j < k; ++j)
      demand(!is_same_solid(all.obstacles[k], all.obstacles[j]),
             fmt::format("obstacles[{}] is the same as obstacles[{}], and would count twice", k, j));
  }
  demand(all.density.method != Method::anderson || !has_solids(all),
         "density.method anderson knows no obstacles; use chebyshev or jacobi");
  check_periodic(all);
  check_gauges(all);
  check_waves(all);
  check_viscosity(all);
  check_flow(all);
  check_output(all);
  resolve_flow(all);
  all.domain = PeriodicDomain::fitted(all.domain, all.periodic, h);
  return all;
}

void check_particles(MPI_Comm comm, const Settings& settings, const Particles& particles) {
  all_or_none(comm, [&] { check_own_particles(settings, particles); });
  const GlobalId twice = first_double(comm, particles.id);
  all_or_none(comm, [&] {
    if (twice >= 0) throw InputError(fmt::format("particle {} is there twice; ids are unique over all ranks", twice));
  });
}

void check_extras(MPI_Comm comm, const SolverExtras& extras) {
  const auto is_null = [](const auto& one) { return one == nullptr; };
  all_or_none(comm, [&] {
    demand(std::none_of(extras.forcings.begin(), extras.forcings.end(), is_null), "a forcing is null");
    demand(std::none_of(extras.observers.begin(), extras.observers.end(), is_null), "an observer is null");
    demand(extras.step >= 0 && extras.substeps >= 1, "SolverExtras::step and substeps must not be negative");
  });
}

}  // namespace trevi
