// Bodies in water at rest: they float as deep as they are heavy, do not turn, and stay where they are.
#include <cmath>

#include "body_run.hpp"
#include "support/cloud.hpp"

namespace trevi::test {
namespace {

TEST(Floating, OfTheWatersDensityStaysWhereItIs) {
  BodyRun run(world, pool + "[[body]]\ntype = \"sphere\"\ncenter = [0.75, 0.6, 0.5]\nradius = 0.3\ndensity = 1000\n");
  const Vec3 start = run.bodies()[0].position;
  run.steps(300);
  EXPECT_LT((run.bodies()[0].position - start).norm(), 0.05);
  EXPECT_LT(run.bodies()[0].angular_velocity.norm(), 0.01);
}

// What pushes along normals cannot turn a ball, however it moves: weight and pressure meet in one point.
TEST(Floating, ABallThatDriftsDoesNotTurn) {
  BodyRun run(world, pool +
                         "[[body]]\ntype = \"sphere\"\ncenter = [0.6, 0.57, 0.5]\nradius = 0.3\ndensity = 1000\n"
                         "velocity = [0.2, 0, 0]\n");
  run.steps(60);
  EXPECT_GT(run.bodies()[0].position.x(), 0.65);
  EXPECT_LT(run.bodies()[0].angular_velocity.norm(), 0.02);
}

// At the lower end of the box along the slab axis, beside an obstacle: what the cells before the first plane are of is
// not asked for. It was read from before the array of cells, and ended runs with a segmentation fault.
TEST(Floating, AtTheFirstWallBesideAnObstacle) {
  const std::string box =
      tank_with_gravity({.max = "3.2, 3.2, 1.84", .water = {{"0, 0, 0", "3.2, 3.2, 0.9"}}, .spacing = "0.08"});
  BodyRun run(world, box +
                         "[[obstacle]]\ntype = \"box\"\ncenter = [0.3, 0.5, 0.3]\nsize = [0.5, 0.4, 0.5]\n"
                         "[[body]]\ntype = \"box\"\ncenter = [0.16, 0.9, 0.5]\nsize = [0.3, 0.3, 0.4]\n"
                         "density = 700\n");
  run.steps(12);
  EXPECT_NEAR(run.bodies()[0].position.x(), 0.16, 0.04);
}

// By Archimedes: a box of the density rho floats rho/rho0 of its height deep, in water that it has lifted.
TEST(Floating, FloatAsDeepAsTheyAreHeavy) {
  for (const Real part : {0.25, 0.5, 0.75}) {
    BodyRun run(world, pool + fmt::format("[[body]]\ntype = \"box\"\ncenter = [0.8, 0.6, {}]\nsize = [0.6, 0.6, 0.6]\n"
                                          "density = {}\nfree = [\"z\"]\n",
                                          1.3 - 0.6 * part, 1000 * part));
    run.steps(240);
    Real sum = 0;
    for (int k = 0; k < 60; ++k) {
      run.steps(1);
      sum += run.bodies()[0].position.z() / 60;
    }
    const Real water = static_cast<Real>(run.rows.front().particles) * 1e-3, area = 1.6 * 1.2, wet = 0.6 * part;
    const Real level = (water + 0.36 * wet) / area;
    EXPECT_NEAR(level - (sum - 0.3), wet, 0.03) << part;
  }
}

// Its bottom is in the cells below the surface, which is that of a cell, and its sides hang over those above. Their
// pressure was three times as high where the water stood a hair below the top of a cell, and small cells above it
// counted as full: such a body sailed at 0.07 m/s.
TEST(Floating, AShallowBodyRestsWhereTheSurfaceIsThatOfACell) {
  const std::string tank = tank_with_gravity({.max = "2.4, 2.4, 2.2", .water = {{"0, 0, 0", "2.4, 2.4, 1"}}});
  for (const char* const x : {"1.2", "1.14"}) {
    BodyRun run(world, tank + "[[body]]\ntype = 'sphere'\ndensity = 60\nradius = 0.6\nfree = ['x']\ncenter = [" + x +
                           ", 1.2, 1.46]\n");
    Real fastest = 0;
    while (run.rows.size() < 300) {
      run.steps(1);
      fastest = std::max(fastest, std::abs(run.bodies()[0].velocity.x()));
    }
    EXPECT_LT(fastest, 0.02) << x;
  }
}

// As cells beside it were wet on one side and dry on the other by the slightest heel, it sailed on at 0.11 m/s.
TEST(Floating, ABoxThatIsPushedStopsWhereCellsAreHalfFull) {
  const std::string tank = tank_with_gravity({.max = "4, 2.4, 2", .water = {{"0, 0, 0", "4, 2.4, 1.1"}}});
  Real fastest = 0, sum = 0;  // of three places to start from
  for (const char* const x : {"1.6", "1.63", "1.7"}) {
    BodyRun run(world, tank + "[[body]]\ntype = 'box'\ndensity = 500\nsize = [1, 0.8, 0.6]\n" +
                           "velocity = [0.15, 0, 0]\ncenter = [" + x + ", 1.2, 1.1]\n");
    for (run.steps(240), fastest = 0; run.rows.size() < 300; run.steps(1))
      fastest = std::max(fastest, run.bodies()[0].velocity.head<2>().norm());
    sum += fastest;
  }
  EXPECT_LT(sum / 3, 0.05);
}

// A jet on a plate that lies on a spring in the air, 0.12 m³/s of water that comes with 4.9 m/s: 584 N, and 60 N of the
// film on it. What is left of the water's momentum went to the box, as a drop of it touched that, and the plate was
// told 277 N.
TEST(Floating, AJetPressesAPlateInTheAir) {
  BodyRun run(world,
              "[domain]\nmin = [0, 0, 0]\nmax = [1.2, 1.2, 1.4]\n[fluid]\nspacing = 0.05\n[gravity]\n[time]\n"
              "dt = 0.0041666667\nend = 3\n[[particles]]\nmin = [0, 0, 0]\nmax = [0.1, 0.1, 0.1]\n[walls]\n"
              "restitution = 0\n[[body]]\ntype = 'box'\nsize = [0.6, 0.6, 0.1]\ncenter = [0.6, 0.6, 0.35]\n"
              "density = 1500\nrestitution = 0\nfree = ['z']\nmooring = { anchor = [0.6, 0.6, 0], stiffness = 20000, "
              "damping = 1500, length = 0.37646 }\n[[inlet]]\ntype = 'rectangle'\ncenter = [0.6, 0.6, 1.2]\n"
              "size = [0.2, 0.2]\ndirection = [0, 0, -1]\nspeed = 3\n[[drain]]\nmin = [-0.1, -0.1, -0.1]\n"
              "max = [1.3, 1.3, 0.1]\n");
  run.steps(240);
  Real lower = 0;
  constexpr int steps = 240;
  for (int n = 0; n < steps; ++n) {
    run.steps(1);
    lower += (0.35 - run.bodies()[0].position.z()) / steps;
  }
  EXPECT_NEAR(20000 * lower, 640, 130);
}

}  // namespace
}  // namespace trevi::test
