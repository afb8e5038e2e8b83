#include "trevi/app/envelope.hpp"

#include <fmt/format.h>

#include <cmath>

namespace trevi {

std::vector<std::string> envelope_warnings(const Scene& scene) {
  const Real g = scene.gravity.value_or(Vec3::Zero()).norm();
  if (g == 0) return {};
  if (!scene.density.coarse_grid) {
    return {
        "the density solve has no coarse grid, and without it water at rest gained energy in most cases of the "
        "stability study; leave out density.preset and density.method, or set density.coarse_grid = true"};
  }
  std::vector<std::string> warnings;
  const FluidSettings& fluid = scene.fluid;
  const Real ratio = fluid.kernel_radius / fluid.spacing;
  constexpr Real hair = 1e-9;
  if (ratio < 1.5 * (1 - hair) || ratio > 3 * (1 + hair)) {
    warnings.push_back(
        fmt::format("kernel_radius is {:.3g} spacings; the stability study covers 1.5 to 3, and at 3.5 a "
                    "column at rest gained 39 % energy; use a radius between",
                    ratio));
  }
  // 1/240 s at a spacing of 0.1 m and 9.8 m/s², in units of the time in which a particle falls by a spacing.
  const Real shortest = 1.0 / 240 * std::sqrt(9.8 / 0.1) * std::sqrt(fluid.spacing / g);
  if (scene.dt < shortest * (1 - hair)) {
    warnings.push_back(
        fmt::format("dt = {:.3g} s is shorter than the {:.3g} s down to which the stability study found "
                    "columns stable (at half of it one gained 5 % energy){}",
                    scene.dt, shortest, scene.viscosity ? "" : "; use a longer dt, or [viscosity], which damps it"));
  }
  if (scene.density.iterations < 2) {
    warnings.emplace_back("density.iterations = 1: a column of 80 layers gained 0.8 % energy with it; use 2 or more");
  }
  return warnings;
}

}  // namespace trevi
