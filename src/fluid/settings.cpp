#include "trevi/settings.hpp"

#include <algorithm>
#include <cmath>

#include "fluid/constraint/density.hpp"
#include "fluid/forcings/music_kind.hpp"
#include "fluid/in_two_dimensions.hpp"
#include "kernels/kernels.hpp"

namespace trevi {

namespace {

// (spacing / 0.1 m)², by which k and epsilon are scaled (inputs/README.md, Resolution).
Real refinement(const Settings& settings) {
  const Real ratio = settings.fluid.spacing / 0.1;
  return ratio * ratio;
}

// Default under-relaxation: a fraction of 2/mu, the value at which some wave on the lattice begins to grow
// (lattice_jacobi_eigenvalue). The fractions are those that were measured to be stable at h = 2 spacings, where with
// Poly6 they mean 0.7 and 0.5; the safeguard of the Chebyshev iteration allows the larger one.
Real stable_relaxation(const Settings& settings) {
  constexpr Real with_safeguard = 0.9587, without = 0.685;
  const DensityModel model = density_model(settings);
  const Real largest = lattice_jacobi_eigenvalue(model.kernels, lattice_of(settings.fluid), model.h,
                                                 model.mass / model.rest_density, model.epsilon);
  const Real fraction = settings.density.method == Method::chebyshev ? with_safeguard : without;
  return fraction * 2 / largest;
}

// Without gravity there is no coarse grid, which would stop water before it meets other water: bodies that meet overlap
// in longer steps, and parting them adds energy.
Real stable_cfl(const Settings& settings) {
  if (settings.density.method != Method::chebyshev) return 0;
  const bool falls = settings.gravity && !settings.gravity->isZero();
  return falls ? 2 : 0.2;
}

// The direction to the nearest wall among those between which the zone does not extend from end to end of the box.
std::optional<Vec3> end_of_zone(const DampingSettings& zone, const Settings& settings) {
  const Vec3 below = zone.min - settings.domain.min, above = settings.domain.max - zone.max;
  const Real reach = settings.fluid.kernel_radius;
  Real nearest = INFINITY;
  std::optional<Vec3> end;
  for (Eigen::Index axis = 0; axis < 2; ++axis) {
    if (settings.periodic[static_cast<std::size_t>(axis)] || std::max(below[axis], above[axis]) < reach) continue;
    if (below[axis] < nearest) end = -Vec3::Unit(axis);
    nearest = std::min(nearest, below[axis]);
    if (above[axis] < nearest) end = Vec3::Unit(axis);
    nearest = std::min(nearest, above[axis]);
  }
  return end;
}

}  // namespace

DensityModel density_model(const Settings& settings) {
  return {particle_mass(settings.fluid), settings.fluid.rest_density,
          settings.fluid.kernel_radius,  settings.density.epsilon / refinement(settings),
          settings.density.constraint,   kernels_of(settings.fluid)};
}

std::optional<Tensile> tensile_of(const Settings& settings) {
  if (!settings.tensile) return std::nullopt;
  return Tensile{settings.tensile->k * refinement(settings), settings.tensile->n, settings.tensile->dq};
}

Settings resolved(Settings settings) {
  lay_in_plane(settings);
  const Vec3 extent = settings.domain.max - settings.domain.min;
  settings.slab_axis.set_default(extent.y() > extent.x() ? 1 : 0);
  settings.fluid.kernel_radius.set_default(2 * settings.fluid.spacing);
  settings.fluid.gradient_kernel.set_default(std::string(kernels_of(settings.fluid).gradient.name));
  settings.cfl.set_default(stable_cfl(settings));
  // Depends on the value of the method, not on whether the key is given, so that writing out a default changes nothing.
  // The other methods run as the literature describes them.
  const bool default_method = settings.density.method == DensitySettings{}.method;
  settings.density.coarse_grid.set_default(default_method);
  settings.density.iterations.set_default(settings.density.coarse_grid ? 3 : 4);
  settings.density.max_shift.set_default(default_method ? 0.1 : 0);
  const auto resolve_music = [](PumpSettings& pump) {
    if (pump.music) resolve(*pump.music);
  };
  std::for_each(settings.fountains.begin(), settings.fountains.end(), resolve_music);
  std::for_each(settings.inlets.begin(), settings.inlets.end(), resolve_music);
  for (DampingSettings& zone : settings.dampings) {
    if (const auto end = end_of_zone(zone, settings)) zone.direction.set_default(*end);
  }
  if (!settings.density.relaxation.given()) settings.density.relaxation = stable_relaxation(settings);
  return settings;
}

Settings report_settings() {
  Settings settings;
  settings.density.method = Method::jacobi;
  settings.density.iterations = 4;
  settings.density.relaxation = 1;
  settings.density.coarse_grid = false;
  settings.density.max_shift = 0;
  settings.density.constraint = Constraint::equality;
  settings.fluid.mass = Mass::volume;
  settings.fluid.density_kernel = "poly6";
  settings.walls.density = WallDensity::none;
  settings.walls.reflection = Reflection::report;
  settings.cfl = 0;
  settings.tensile = TensileSettings{};
  settings.vorticity = 0.002;
  settings.viscosity = 0.001;
  return settings;
}

}  // namespace trevi
