// Walls that hold the water: shear in a straight line stays, a channel comes to its parabola, what the wall of a pipe
// has taken balances with the water's momentum, one that turns takes water along as fast as it turns, and the
// bits do not depend on the ranks.
#include <cmath>
#include <cstdio>

#include "boundary/obstacles/obstacles.hpp"
#include "fluid/constraint/density.hpp"
#include "support/cloud.hpp"
#include "support/kept_run.hpp"
#include "support/output_fixture.hpp"

namespace trevi::test {
namespace {

struct Flow : KeptRun {
  Flow(MPI_Comm comm, const std::string& text) : KeptRun(comm, parse_scene("test.toml", text, {})) {}
};

// 20 across, pulled along x, which repeats.
const std::string pulled = R"(
[fluid]
spacing = 0.05
kernel_radius = 0.2
density_kernel = "wendland_c2"
[[particles]]
min = [0, 0, 0]
max = [0.6, 0.6, 1]
[time]
dt = 0.01
end = 1
[viscosity]
nu = 0.2
no_slip = true
[gravity]
)";
const std::string channel =
    "[domain]\nmin = [0, 0, 0]\nmax = [0.6, 0.6, 1]\nperiodic = ['x', 'y']\n" + pulled + "acceleration = [1.6, 0, 0]\n";
const std::string pipe = "[domain]\nmin = [0, -0.2, -0.2]\nmax = [0.6, 1.2, 1.2]\nperiodic = ['x']\n" + pulled +
                         "acceleration = [3.2, 0.5, 0]\n"
                         "[[obstacle]]\ntype = 'cylinder'\ninside = true\ncenter = [0.3, 0.5, 0.5]\naxis = [1, 0, 0]\n"
                         "radius = 0.5\nheight = 4\n";
const std::string turning =
    "[[obstacle]]\ntype = 'cylinder'\ncenter = [0.3, 0.5, 0.5]\naxis = [1, 0, 0]\nradius = 0.2\n"
    "height = 4\nangular_velocity = [5, 0, 0]\n";

// Between plates the parabola g z (1 - z)/(2 nu), 1 m/s in the middle here.
TEST(NoSlip, AChannelComesToItsParabola) {
  Flow flow(world, channel);
  flow.steps(250);
  const Cloud all = gathered(world, flow.solver->particles());
  if (rank_of(world) != 0) return;
  Real wrong = 0, mean = 0;
  for (std::size_t i = 0; i < all.position.size(); ++i) {
    const Real z = all.position[i].z();
    wrong += std::pow(all.velocity[i].x() - 4 * z * (1 - z), 2);
    mean += all.velocity[i].x();
  }
  const auto count = static_cast<Real>(all.position.size());
  std::printf("root mean square %.4f m/s, mean over that of the parabola %.4f\n", std::sqrt(wrong / count),
              mean / count / (2.0 / 3));
  EXPECT_LT(std::sqrt(wrong / count), 0.1);
  EXPECT_NEAR(mean / count / (2.0 / 3), 1, 0.1);
}

// The momentum of water with rest density changes by its weight less what the pipe and the box took.
TEST(NoSlip, WhatThePipeTakesBalances) {
  Flow flow(world, pipe + turning);
  flow.steps(40);
  const Real mass = 1000 * std::pow(0.05, 3), water = mass * static_cast<Real>(flow.rows.front().particles);
  for (std::size_t k = 1; k < flow.rows.size(); ++k) {
    const Vec3 taken = flow.forces[k][0].force + flow.forces[k][1].force + flow.forces[k][2].force;
    const Vec3 change = (flow.rows[k].momentum - flow.rows[k - 1].momentum) / flow.scene.dt;
    EXPECT_LT((change - (water * *flow.scene.gravity - taken)).norm(), 1e-6 * water * 3.2) << k;
  }
}

// As what goes with it at the place of the water.
TEST(NoSlip, GoesAsFastAsItTurns) {
  const Scene scene = parse_scene("test.toml", pipe + turning, {});
  Obstacles obstacles(scene, Walls(scene.domain, scene.walls, 1e-7),
                      AnalyticWallDensity(scene.domain, kernels_of(scene.fluid).density, scene.fluid.spacing,
                                          scene.fluid.kernel_radius, WallSlope::of_positions));
  obstacles.move(0, 0.01);
  int met = 0;
  for (const Real distance : {0.01, 0.05, 0.1, 0.15}) {
    obstacles.for_each_near({0.3, 0.5, 0.7 + distance}, [&](std::size_t k, Real, const Vec3&, const Vec3& way) {
      EXPECT_LT((way - Vec3(0, k == 1 ? -5 * (0.2 + distance) * 0.01 : 0, 0)).norm(), 0.0005) << distance;
      met += k == 1;
    });
  }
  EXPECT_EQ(met, 4);
}

TEST(NoSlip, SameBitsOnAnyRanks) {
  for (const std::string& text : {channel, pipe + turning, pipe + "[density]\nprecision = 'single'\n"}) {
    Flow together(world, text), alone(MPI_COMM_SELF, text);
    together.steps(8);
    alone.steps(8);
    expect_same_bits(gathered(world, together.solver->particles()), gathered(MPI_COMM_SELF, alone.solver->particles()));
    for (std::size_t k = 0; k < together.forces.back().size(); ++k)
      EXPECT_EQ(together.forces.back()[k].force, alone.forces.back()[k].force);
  }
}

}  // namespace
}  // namespace trevi::test
