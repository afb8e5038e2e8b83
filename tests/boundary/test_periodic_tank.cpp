// Water under gravity in a tank that is periodic sideways: the coarse grid goes around, too.
#include <cmath>
#include <complex>
#include <numbers>

#include <fmt/format.h>

#include "base/threads.hpp"
#include "support/cloud.hpp"
#include "support/tank.hpp"

namespace trevi::test {
namespace {

const std::string tank = tank_with_gravity({.min = "0.4, -1.2, 0.25",
                                            .max = "2.0, 0.2, 1.65",
                                            .water = {{"0.4, -1.2, 0.25", "2.0, 0.2, 1.05"}},
                                            .dt = "0.0166666667",
                                            .end = "1.0",
                                            .domain = "periodic = [\"x\", \"y\"]"}) +
                         R"(acceleration = [0.3, -0.2, -9.8]
)";

const std::string solids = rod_and_ball("1.2, -0.5, 0.5", 4, "1.2, -0.5, 0.9", 0.1);

/// Torn water that sloshes, everywhere in the box.
Cloud wild_water(const Scene& scene) { return random_cloud(1300, scene.domain, 1, 0.05); }

void advance(Solver& solver, int steps) {
  for (int k = 0; k < steps; ++k) solver.step();
}

Cloud after_steps(MPI_Comm comm, const Scene& scene, const Cloud& cloud, int threads) {
  const int before = thread_count();
  use_threads(threads);
  const std::unique_ptr<Solver> solver = solver_of(comm, scene, cloud);
  advance(*solver, 3);
  use_threads(before);
  return gathered(comm, solver->particles());
}

// Eight and seven cells around; the ends of the box at cuts between ranks or within one.
TEST(PeriodicTank, SameBitsOnAnyRanksAndThreads) {
  for (const char* axes : {"['x']", "['y']", "['x', 'y']"}) {
    for (const char* more : {"density.precision='single'", "domain.slab_axis='y'"}) {
      for (const bool with_solids : {false, true}) {
        SCOPED_TRACE(fmt::format("{} {} {}", axes, more, with_solids));
        const Scene scene =
            scene_with(with_solids ? tank + solids : tank, {fmt::format("domain.periodic={}", axes), more});
        const Cloud cloud = wild_water(scene);
        expect_same_bits(after_steps(world, scene, cloud, 2), after_steps(MPI_COMM_SELF, scene, cloud, 1));
      }
    }
  }
}

// Forty layers, with gravity straight down: nothing moves but by rounding.
TEST(PeriodicTank, AStillOneRests) {
  const Scene scene = scene_with(
      tank, {"gravity.acceleration=[0, 0, -9.8]", "domain.max=[1.4, -0.6, 5.25]", "particles.0.max=[1.4, -0.6, 4.25]"});
  const std::unique_ptr<Solver> solver = make_solver(world, scene, initial_particles(world, scene));
  const Cloud start = gathered(world, solver->particles());
  advance(*solver, 30);
  const Cloud end = gathered(world, solver->particles());
  ASSERT_EQ(end.id, start.id);
  for (std::size_t i = 0; i < end.id.size(); ++i) {
    EXPECT_LT(std::abs(end.position[i].z() - start.position[i].z()), 1e-6);
    EXPECT_LT(end.velocity[i].norm(), 1e-5);
  }
}

// By linear theory omega² = g k tanh(k d). The surface is the sum of exp(−i k x), which turns by pi in half a period.
TEST(PeriodicTank, AWaveRunsAroundAtItsSpeed) {
  const Real length = 4, depth = 1, height = 0.05, g = 9.8, k = 2 * std::numbers::pi / length;
  const Real omega = std::sqrt(g * k * std::tanh(k * depth));
  const Scene scene =
      scene_with(tank, {"gravity.acceleration=[0, 0, -9.8]", "domain.min=[0, 0, 0]", "domain.max=[4.0, 0.6, 2.4]",
                        "particles.0.min=[0, 0, 0]", "particles.0.max=[4.0, 0.6, 1.0]"});
  Particles particles = initial_particles(world, scene);
  for (std::size_t i = 0; i < particles.id.size(); ++i) {
    Vec3& p = particles.position[i];
    const Real along = height * std::cosh(k * p.z()) / std::sinh(k * depth), x = k * p.x();
    const Real up = height * std::sinh(k * p.z()) / std::sinh(k * depth);
    particles.velocity[i] = omega * Vec3(along * std::cos(x), 0, up * std::sin(x));
    p += Vec3(-along * std::sin(x), 0, up * std::cos(x));
    p.x() -= length * std::floor(p.x() / length);
  }
  const std::unique_ptr<Solver> solver = make_solver(world, scene, std::move(particles));
  const auto surface = [&] {
    std::complex<Real> sum = 0;
    for (const Vec3& p : gathered(world, solver->particles()).position) sum += std::polar(1.0, -k * p.x());
    return sum;
  };
  const std::complex<Real> start = surface();
  advance(*solver, 50);
  const std::complex<Real> turn = surface() / start * std::polar(1.0, omega * solver->clock().time());
  EXPECT_LT(std::abs(std::arg(turn)), 0.03 * omega * solver->clock().time());
  EXPECT_GT(std::abs(turn), 0.8);
  EXPECT_LT(std::abs(turn), 1.1);
}

}  // namespace
}  // namespace trevi::test
