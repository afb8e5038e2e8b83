// Water that runs into solids and past them: what it gives to them does not depend on which of the two moves, on the
// step, or on cells that it has only begun to fill.
#include <cmath>

#include "body_run.hpp"
#include "support/cloud.hpp"

namespace trevi::test {
namespace {

// A cube of a metre that moves at `water` m/s along x, and in front of it a ball of 2.4 spacings and 400 kg/m³ at
// `ball` m/s.
std::string cube_and_ball(Real water, Real ball, Real g, int steps_per_second) {
  return tank_text({.max = "5, 3, 3",
                    .water = {{"1, 1, 1", "2, 2, 2", fmt::format("velocity = [{}, 0, 0]", water)}},
                    .dt = fmt::format("{:.17g}", 1.0 / steps_per_second),
                    .spacing = "0.0625"}) +
         fmt::format(
             "[gravity]\nacceleration = [0, 0, {}]\n[[body]]\ntype = \"sphere\"\ncenter = [2.181, 1.513, 1.521]\n"
             "radius = 0.15\nvelocity = [{}, 0, 0]\ndensity = 400\n",
             -g, ball);
}

// The ball's speed beyond that of its start, after 0.3 s. With gravity it falls together with the water.
Real speed_given(Real water, Real ball, Real g, int steps_per_second) {
  BodyRun run(world, cube_and_ball(water, ball, g, steps_per_second));
  run.steps(3 * steps_per_second / 10);
  return run.bodies()[0].velocity.x() - ball;
}

// A cell that a solid cuts was taken to be full as soon as some water came into it. The water was stopped a cell in
// front of the ball, which got up to 3.9 m/s in place of 1.4, the more the shorter the step.
TEST(Impacts, OfWaterOnABallAreThoseOfTheBallOnWater) {
  for (const Real g : {9.8, 0.0}) {
    for (const int steps_per_second : {60, 240}) {
      const Real hit = speed_given(2, 0, g, steps_per_second), hits = speed_given(0, -2, g, steps_per_second);
      EXPECT_NEAR(hits, 1.31, 0.06) << g  // 1.21 to 1.26 with half the spacing
                                    << " " << steps_per_second;
      EXPECT_NEAR(hit, hits, 0.35) << g << " " << steps_per_second;
    }
  }
}

// The impulse on a ball that is fixed, or moves on, as water and ball meet without gravity. The water was stopped a
// cell in front of the fixed one, which got twice the impulse.
TEST(Impacts, OfWaterOnAnObstacleAreThoseOfTheObstacleOnWater) {
  const auto impulse = [](Real water, const std::string& motion) {
    BodyRun run(world, tank_text({.max = "5, 3, 3",
                                  .water = {{"1, 1, 1", "2, 2, 2", fmt::format("velocity = [{}, 0, 0]", water)}},
                                  .dt = "0.004166666666666667",
                                  .spacing = "0.0625"}) +
                           "[gravity]\nacceleration = [0, 0, 0]\n[[obstacle]]\ntype = \"sphere\"\n"
                           "center = [2.181, 1.513, 1.521]\nradius = 0.15\n" +
                           motion);
    run.steps(72);
    return 1000 * water - run.rows.back().momentum.x();
  };
  // A sine of 40 s, whose velocity differs from -2 m/s by 0.2 % at most.
  const Real hits = impulse(0,
                            "[obstacle.motion]\ntype = \"sine\"\namplitude = [-12.7324, 0, 0]\nperiod = 40\n"
                            "ramp = 0\n");
  EXPECT_NEAR(impulse(2, "") / hits, 1, 0.3);
}

// Nothing happens to a ball at the surface of a drop with which it moves. Without gravity it left it at 3 to 8 m/s.
TEST(Impacts, ABallMovesAlongWithItsDrop) {
  for (const int steps_per_second : {128, 1024}) {
    BodyRun run(world, tank_text({.max = "6, 6, 6",
                                  .water = {{"2.5, 2.5, 2.5", "3, 3, 3", "velocity = [0, 0, 1]"}},
                                  .dt = fmt::format("{:.17g}", 1.0 / steps_per_second),
                                  .spacing = "0.0625"}) +
                           "[gravity]\nacceleration = [0, 0, 0]\n[[body]]\ntype = \"sphere\"\n"
                           "center = [2.75, 2.75, 2.95]\nradius = 0.15\nvelocity = [0, 0, 1]\ndensity = 400\n");
    run.steps(steps_per_second / 4);
    EXPECT_LT((run.bodies()[0].velocity - Vec3::UnitZ()).norm(), 1e-9) << steps_per_second;
  }
}

// Water that flies past a ball at a spacing, both in free fall, gives it next to nothing (0.57 m/s before).
TEST(Impacts, WaterThatFliesPastGivesNothing) {
  BodyRun run(world, tank_text({.max = "5, 3, 3",
                                .water = {{"1, 1, 1", "2, 2, 1.25", "velocity = [2, 0, 0]"}},
                                .dt = "0.00390625",
                                .spacing = "0.0625"}) +
                         "[gravity]\n[[body]]\ntype = \"sphere\"\ncenter = [2.25, 1.5, 1.4625]\nradius = 0.15\n"
                         "density = 100\n");
  run.steps(64);
  EXPECT_LT(std::abs(run.bodies()[0].velocity.x()), 0.1);
}

// Particles give a ball without friction no spin, wherever its centre is on its way when it meets them. They gave 1.4
// rad/s.
TEST(Impacts, AThrownBallGetsNoSpin) {
  const std::string thrown =
      pool +
      "[[body]]\ntype = \"sphere\"\ncenter = [0.4, 0.6, 1.25]\nradius = 0.2\nvelocity = [2, 0, -1]\n"
      "density = 100\n";
  BodyRun smooth(world, thrown), rough(world, thrown + "friction = 0.5\n");
  smooth.steps(40);
  rough.steps(40);
  EXPECT_LT(smooth.bodies()[0].angular_velocity.norm(), 1e-9);
  EXPECT_GT(rough.bodies()[0].angular_velocity.norm(), 0.1) << "with friction it is spun";
}

}  // namespace
}  // namespace trevi::test
