#include "app/preflight/envelope.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "app/preflight/wave_text.hpp"
#include "base/simd.hpp"
#include "fluid/forcings/inlet.hpp"
#include "io/writers.hpp"
#include "solver/density_solver.hpp"

namespace trevi {

namespace {

// Where pools of 1 to 200 layers kept their energy within 0.5 % for 20 s (postprocess/results/stability.md): down to
// this time step at a spacing of 0.1 m and 9.8 m/s², and at these h/spacing.
constexpr Real shortest_step = 1.0 / 960, narrowest = 1.5, widest = 4.0;

// m²/s; 0.015 at a spacing of 0.1 m and 9.8 m/s². A disturbed pool of 10 layers rests below 1e-5 m²/s² with it, and a
// wave of 4 m loses 3 % of its amplitude in half a period (postprocess/results/water.md).
Real quieting_viscosity(const Scene& scene) {
  const Real s = scene.fluid.spacing, g = scene.gravity.value_or(Vec3::Zero()).norm();
  return 0.15 * std::sqrt(g * s * s * s);
}

bool is_gravity(const Scene& scene) { return scene.gravity && !scene.gravity->isZero(); }

}  // namespace

std::vector<std::string> envelope_warnings(const Scene& scene) {
  const Real g = scene.gravity.value_or(Vec3::Zero()).norm();
  if (g == 0) return {};
  if (!scene.density.coarse_grid) {
    std::vector<std::string> warnings{
        "the density solve has no coarse grid, and without it water at rest gained energy in most cases of the "
        "stability study; leave out density.preset and density.method, or set density.coarse_grid = true"};
    if (!scene.bodies.empty())
      warnings.emplace_back(
          "without the coarse grid, whose pressure carries them, bodies float too deep, by up to two and a half "
          "spacings; leave out density.preset and density.method, or set density.coarse_grid = true");
    return warnings;
  }
  if (!is_downward(*scene.gravity)) {
    return {
        "gravity does not point down, along -z, and the coarse grid serves no other direction: without it deep water "
        "at "
        "rest gains energy; turn the scene"};
  }
  std::vector<std::string> warnings;
  const FluidSettings& fluid = scene.fluid;
  const Real ratio = fluid.kernel_radius / fluid.spacing;
  // A value outside by less than this is a rounded number, such as 0.0166666 for 1/60, not a choice.
  constexpr Real rounded = 0.01;
  if (ratio < narrowest * (1 - rounded) || ratio > widest * (1 + rounded)) {
    warnings.push_back(fmt::format(
        "kernel_radius is {:.4g} spacings; the stability study found water at rest stable from {:g} to {:g}; "
        "use a radius between",
        ratio, narrowest, widest));
  }
  // In units of the time in which a particle falls by one spacing.
  const Real shortest = shortest_step * std::sqrt(9.8 / 0.1) * std::sqrt(fluid.spacing / g);
  if (scene.dt < shortest * (1 - rounded)) {
    warnings.push_back(
        fmt::format("dt = {:.4g} s is shorter than the {:.4g} s down to which the stability study looked; use "
                    "a longer dt, or watch the energy",
                    scene.dt, shortest));
  }
  return warnings;
}

std::vector<std::string> start_warnings(const Scene& scene) {
  std::vector<std::string> warnings;
  if (!has_fused_multiply_add()) {
    warnings.push_back(fmt::format(
        "{} has no fused multiply-add: results agree with those of other instruction sets to rounding, not in bits",
        instruction_set_name()));
  }
  if (scene.density.method == Method::anderson) {
    warnings.emplace_back(
        "the dot products of density.method = \"anderson\" are PETSc's: results agree with those on another number of "
        "ranks to its tolerance, not in bits");
  }
  for (std::string& warning : envelope_warnings(scene)) warnings.push_back(std::move(warning));
  for (std::string& warning : wave_warnings(scene)) warnings.push_back(std::move(warning));
  return warnings;
}

std::vector<std::string> energy_warnings(const Scene& scene, const EnergyRise& energy) {
  constexpr Real mark = 0.005, mark_of_motion = 0.1;
  std::vector<std::string> warnings;
  // The pressure in front of openings in walls does work that is not accounted for.
  const auto in_wall = [](const auto& one) { return one.is_in_wall(); };
  if (std::any_of(scene.inlets.begin(), scene.inlets.end(), in_wall) ||
      std::any_of(scene.drains.begin(), scene.drains.end(), in_wall))
    return warnings;
  if (!scene.density.coarse_grid && !scene.inlets.empty()) return warnings;  // the same for any other inlet
  const std::string remedy =
      is_gravity(scene) ? fmt::format("; set [viscosity] nu = {:.2g} m²/s, which damps it", quieting_viscosity(scene))
                        : std::string("; use a smaller dt, or time.cfl");
  const char* source = scene.vorticity ? ", to which [vorticity] adds; lower its epsilon" : "";
  if (energy.fraction() > mark) {
    warnings.push_back(fmt::format(
        "the total energy rose by {:.2g} % above {}{}{}", 100 * energy.fraction(),
        is_supplied(scene) ? "what pumps, inlets and moving obstacles gave it" : "its start although nothing pumps",
        source, remedy));
  }
  if (energy.fraction_of_motion() > mark_of_motion) {
    warnings.push_back(
        fmt::format("the moving part of the energy, what waves have above water at rest, rose by {:.0f} % of itself{}; "
                    "use a smaller spacing for waves as low as this",
                    100 * energy.fraction_of_motion(), source));
  }
  return warnings;
}

std::vector<std::string> crush_warnings(const Scene& scene, const Solver::Counters::Compression& seen) {
  if (seen.first_crushed < 0) return {};
  return {
      fmt::format("the water is crushed from step {} on: its mean compression is up to {:.0f} %, and "
                  "density.crush_limit is {:.0f} %; look for particles that lie on one another, for more water than "
                  "space, for solids that press it, or use more density.iterations",
                  seen.first_crushed, 100 * seen.largest, 100 * scene.density.crush_limit)};
}

std::vector<std::string> flow_warnings(const Scene& scene, const FlowState* flow) {
  std::vector<std::string> warnings;
  constexpr Real missed = 0.02;
  for (std::size_t k = 0; flow != nullptr && k < scene.inlets.size(); ++k) {
    const FlowState::Stream& stream = flow->streams.at(k);
    const Real less = stream.covered + stream.blocked, asked = stream.asked() - stream.dry;
    const InletLattice lattice(scene.inlets[k], scene.fluid.spacing);
    if (less < std::max(missed * asked, static_cast<Real>(lattice.open_places()))) continue;
    warnings.push_back(fmt::format(
        "inlet {} made {:.0f} of the {:.0f} particles asked of it: for {:.0f} a solid, or a wall, is in the opening or "
        "less than the path of a substep ahead of it, for {:.0f} other water was; move it, or ask for less",
        k, stream.made, asked, stream.covered, stream.blocked));
  }
  return warnings;
}

}  // namespace trevi
