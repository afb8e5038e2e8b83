#include "trevi/app/envelope.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "trevi/fluid/velocity_filter.hpp"

namespace trevi {

namespace {

// Down to what time step, at a spacing of 0.1 m and 9.8 m/s², and up to what h/spacing columns of 5 to 40 layers at
// rest gained less than 0.5 % of energy in 2 s (postprocess/results/stability.md).
struct Envelope {
  Real shortest_step, widest;
};

Envelope envelope_of(const Scene& scene) {
  const FluidSettings& fluid = scene.fluid;
  const Real viscous_step =
      longest_viscous_step(scene.kinematic_viscosity.value_or(0), fluid.spacing, fluid.kernel_radius);
  const bool damped = std::max(scene.viscosity.value_or(0) * fluid.rest_density, scene.dt / viscous_step) >= 0.2;
  const bool spiky = scene.fluid.density_kernel == Kernel::spiky;
  return {damped ? 1.0 / 480 : spiky ? 1.0 / 200 : 1.0 / 60, spiky ? 4.0 : damped ? 3.0 : 2.0};
}

std::string damping_of(const FluidSettings& fluid) {
  return fmt::format("set {}[viscosity] c = {:g}, which damps it",
                     fluid.density_kernel == Kernel::spiky ? "" : "fluid.density_kernel = \"spiky\", or ",
                     0.2 / fluid.rest_density);
}

}  // namespace

std::vector<std::string> envelope_warnings(const Scene& scene) {
  const Real g = scene.gravity.value_or(Vec3::Zero()).norm();
  if (g == 0) return {};
  if (!scene.density.coarse_grid) {
    return {
        "the density solve has no coarse grid, and without it water at rest gained energy in most cases of the "
        "stability study; leave out density.preset and density.method, or set density.coarse_grid = true"};
  }
  std::vector<std::string> warnings;
  const Envelope envelope = envelope_of(scene);
  const FluidSettings& fluid = scene.fluid;
  const Real ratio = fluid.kernel_radius / fluid.spacing;
  // What is outside by less than this is a rounded number, such as 0.0166666 for 1/60, and no choice.
  constexpr Real rounded = 0.01;
  const std::string remedy = damping_of(fluid);
  if (ratio < 1.5 * (1 - rounded) || ratio > envelope.widest * (1 + rounded)) {
    warnings.push_back(
        fmt::format("kernel_radius is {:.4g} spacings; the stability study found water at rest stable "
                    "from 1.5 to {:g}; use a radius between{}",
                    ratio, envelope.widest, ratio > 2 ? ", or " + remedy : ""));
  }
  // In units of the time in which a particle falls by a spacing.
  const Real shortest = envelope.shortest_step * std::sqrt(9.8 / 0.1) * std::sqrt(fluid.spacing / g);
  if (scene.dt < shortest * (1 - rounded)) {
    warnings.push_back(
        fmt::format("dt = {:.4g} s is shorter than the {:.4g} s down to which the stability study found "
                    "water at rest stable: shallow water warms up; use a longer dt, or {}",
                    scene.dt, shortest, remedy));
  }
  const int fewest = fluid.density_kernel == Kernel::spiky ? 3 : 2;
  if (scene.density.iterations < fewest) {
    warnings.push_back(
        fmt::format("density.iterations = {}: deep columns at rest gained 0.8 to 1.5 % energy with fewer "
                    "than {}; use {} or more",
                    scene.density.iterations, fewest, fewest));
  }
  return warnings;
}

std::vector<std::string> energy_warnings(const Scene& scene, Real share) {
  constexpr Real mark = 0.005;
  if (!(share > mark)) return {};
  return {fmt::format(
      "the total energy rose by {:.2g} % above its start although nothing pumps{}; use a longer dt, or {}", 100 * share,
      scene.vorticity ? ", to which [vorticity] adds; lower its epsilon" : ": the method adds it",
      damping_of(scene.fluid))};
}

}  // namespace trevi
