// Water without a surface, whose pressure has no origin of its own: vessels that are full move as one with their water,
// whatever room is above them in the box, and full compartments rest beside those that are not.
#include <cmath>
#include <numbers>

#include <fmt/format.h>

#include "base/threads.hpp"
#include "support/cloud.hpp"
#include "support/tank.hpp"

namespace trevi::test {
namespace {

constexpr Real amplitude = 0.25, period = 1;  // m, s

std::string vessel_of(const std::string& shape) {
  return tank_with_gravity({.min = "-1.6, -1, -1.4",
                            .max = "1.6, 1, 1.6",
                            .water = {{"-1.2, -0.9, -0.9", "1.2, 0.9, 0.9"}},
                            .end = "0.5"}) +
         fmt::format(R"([[obstacle]]
{}
center = [0, 0, 0]
inside = true
motion = {{ type = "sine", amplitude = [{}, 0, {}], period = {}, ramp = 0.2 }}
)",
                     shape, amplitude, amplitude / 2, period);
}

const std::vector<std::string> full_vessels{"type = \"box\"\nsize = [0.83, 0.83, 0.83]",
                                            "type = \"box\"\nsize = [0.8, 0.8, 0.8]\nrotate = [15, 25, 35]",
                                            "type = \"sphere\"\nradius = 0.6"};

/// Displacement of the vessel along x at a time; along z it is half of it.
Real displacement(Real time) {
  const Real u = std::min(time / 0.2, 1.0);
  return amplitude * u * u * (3 - 2 * u) * std::sin(2 * std::numbers::pi * time / period);
}

// A full tank, a wall, and a tank that is half full; the ceiling closes the first.
const std::string compartments =
    tank_with_gravity({.max = "3.2, 1, 1", .water = {{"0, 0, 0", "1.5, 1, 1"}, {"1.7, 0, 0", "3.2, 1, 0.5"}}}) +
    R"([[obstacle]]
type = "box"
center = [1.6, 0.5, 0.5]
size = [0.2, 1.2, 1.2]
)";

Cloud after_steps(MPI_Comm comm, const Scene& scene, int steps, int threads) {
  const int before = thread_count();
  use_threads(threads);
  const std::unique_ptr<Solver> solver = make_solver(comm, scene, initial_particles(comm, scene));
  for (int k = 0; k < steps; ++k) solver->step();
  use_threads(before);
  return gathered(comm, solver->particles());
}

// The vessel only translates, so the circulation of its water remains zero, and the water translates with it.
TEST(EnclosedWater, OfAFullVesselMovesAsOneWithIt) {
  for (const std::string& shape : full_vessels) {
    SCOPED_TRACE(shape);
    const Scene scene = scene_with(vessel_of(shape), {});
    const int steps = 30;
    const Cloud end = after_steps(world, scene, steps, 1);
    const Real along = (displacement(steps * scene.dt) - displacement((steps - 1) * scene.dt)) / scene.dt;
    Real sum = 0;
    for (const Vec3& v : end.velocity) sum += (v - Vec3(along, 0, along / 2)).squaredNorm();
    const Real fastest = 2 * std::numbers::pi * amplitude / period;

    EXPECT_LT(std::sqrt(sum / static_cast<Real>(end.velocity.size())), 0.02 * fastest);
  }
}

TEST(EnclosedWater, OfAFullCompartmentRests) {
  const Cloud end = after_steps(world, scene_with(compartments, {}), 30, 1);
  Real sum = 0;
  for (const Vec3& v : end.velocity) sum += v.squaredNorm();
  EXPECT_LT(sum / 2 / static_cast<Real>(end.velocity.size()), 1e-6) << "m²/s²";
}

// Three layers in a tank 3 m long, thrown along it at 0.1 m/s, and a lid with its lower face at `lid`, m: how far they
// have come in a quarter of a second, in which their waves stay below 0.29 m.
Real way_below(std::optional<Real> lid) {
  const std::string tank = tank_with_gravity(
      {.max = "3, 0.8, 0.8", .water = {{"0, 0, 0", "3, 0.8, 0.3", "velocity = [0.1, 0, 0]"}}, .dt = "0.0083333333"});
  const std::string solid = !lid ? ""
                                 : fmt::format(R"([[obstacle]]
type = "box"
center = [1.5, 0.4, {}]
size = [3.2, 1.2, 0.6]
)",
                                               *lid + 0.3);
  const Cloud end = after_steps(world, scene_with(tank + solid, {}), 30, 1);
  Real sum = 0;
  for (const Vec3& p : end.position) sum += p.x();
  return sum / static_cast<Real>(end.position.size()) - 1.5;
}

// Cells that solids close from above once counted as full from three tenths on, and the water as enclosed: it stood.
TEST(EnclosedWater, DoesNotIncludeWaterThatALidIsAbove) {
  const Real without = way_below({});
  EXPECT_GT(without, 0.01);
  EXPECT_NEAR(way_below(0.5), without, 0.05 * without);
  EXPECT_GT(way_below(0.4), 0.5 * without) << "half a cell above the water";
}

TEST(EnclosedWater, SameBitsOnAnyRanksAndThreads) {
  const std::string rows_are_cut = fmt::format("domain.ranks=[1, {}]", size_of(world));
  for (const std::string& text : {vessel_of(full_vessels[1]), compartments}) {
    for (const std::string axis : {"domain.slab_axis='x'", "domain.slab_axis='y'"}) {
      SCOPED_TRACE(text + axis);
      const Cloud alone = after_steps(MPI_COMM_SELF, scene_with(text, {axis}), 4, 1);
      expect_same_bits(after_steps(world, scene_with(text, {axis}), 4, 2), alone);
      expect_same_bits(after_steps(world, scene_with(text, {axis, rows_are_cut}), 4, 1), alone);
    }
  }
}

}  // namespace
}  // namespace trevi::test
