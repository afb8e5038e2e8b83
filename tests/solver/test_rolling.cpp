// Bodies without water that bounce and roll, beside what mechanics says.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "body_run.hpp"
#include "support/output_fixture.hpp"

namespace trevi::test {
namespace {

// A particle lies in a corner.
std::string dry_box(const std::string& dt) {
  return tank_text({.max = "4, 4, 4", .water = {{"3.9, 3.9, 0", "4, 4, 0.1"}}, .dt = dt, .end = "10"});
}

// A ball that falls from 1 m rises to the square of its restitution, then to that of that. By its speed at the start of
// the substep, with which it left at once, it rose by v dt more: 4 % a bounce at a restitution of 1, for ever.
TEST(Rolling, ABallBouncesToItsHeight) {
  for (const std::string dt : {"0.01", "0.0166666666666666667"}) {
    for (const Real restitution : {1.0, 0.7}) {
      BodyRun run(world,
                  dry_box(dt) + fmt::format("[gravity]\n[walls]\nrestitution = {0}\n[[body]]\ntype = \"sphere\"\n"
                                            "center = [2, 2, 1.2]\nradius = 0.2\ndensity = 500\n"
                                            "restitution = {0}\n",
                                            restitution));
      Real expected = 1, last = 1, highest = 0;
      int bounces = 0;
      for (Real time = 0; bounces < 3 && time < 6; time += run.scene.dt) {
        run.steps(1);
        const Real height = run.bodies()[0].position.z() - 0.2;
        EXPECT_GE(height, -1e-9);
        if (height > last) highest = height;
        if (height < last && highest > 0) {  // past a peak, of which the steps miss at most g dt²/8
          expected *= restitution * restitution;
          EXPECT_NEAR(highest, expected, 2e-3 * expected + 1.3 * run.scene.dt * run.scene.dt) << dt << ' ' << bounces;
          highest = 0;
          ++bounces;
        }
        last = height;
      }
      EXPECT_EQ(bounces, 3);
    }
  }
}

// Down a slope, for which gravity that leans stands: g sin / (1 + I/(m r²)). On the facets of its surface a ball lost a
// seventh of the way in 0.7 s, and on a level floor three quarters of its speed in 3 s.
TEST(Rolling, RoundBodiesRollDownASlope) {
  const Real r = 0.2, ball = 4. / 3 * r, line = 0.4;  // over the area of a disc
  const std::pair<std::string, Real> cases[] = {
      {"type = \"sphere\"\n", 0.4},
      {"type = \"cylinder\"\nheight = 0.5\naxis = [0, 1, 0]\n", 0.5},
      {"type = \"capsule\"\nheight = 0.8\naxis = [0, 1, 0]\n", (0.5 * line + 0.4 * ball) / (line + ball)}};
  for (const auto& [shape, inertia] : cases) {
    BodyRun run(world, dry_box("0.005") + "[gravity]\nacceleration = [3, 0, -9]\n[walls]\nrestitution = 0\n[[body]]\n" +
                           shape + "center = [1, 2, 0.2]\nradius = 0.2\ndensity = 800\nfriction = 0.8\n");
    run.steps(160);
    const BodyState end = run.bodies()[0];
    EXPECT_NEAR(end.velocity.x(), 3 / (1 + inertia) * 0.8, 1e-9) << shape;
    EXPECT_NEAR(end.angular_velocity.y() * r, end.velocity.x(), 1e-9) << shape;
    EXPECT_NEAR(end.position.z(), r, 1e-12) << shape;
  }
}

TEST(Rolling, ABallThatSlidesEndsWithFiveSeventhsOfItsSpeed) {
  BodyRun run(world, dry_box("0.005") +
                         "[gravity]\n[walls]\nrestitution = 0\n[[body]]\ntype = \"sphere\"\n"
                         "center = [0.5, 2, 0.2]\nradius = 0.2\ndensity = 800\nfriction = 0.3\n"
                         "velocity = [1.4, 0, 0]\n");
  run.steps(300);
  EXPECT_NEAR(run.bodies()[0].velocity.x(), 1, 1e-9);
}

// Second order in the step. It was ahead by half a step, 4 % of the swing at 1/60 s.
TEST(Rolling, ABallOnASpringIsWhereItShouldBe) {
  for (const std::string dt : {"0.0166666666666666667", "0.00416666666666666667"}) {
    BodyRun run(world, dry_box(dt) +
                           "[[body]]\ntype = \"sphere\"\ncenter = [2.1, 2, 2]\nradius = 0.2\nmass = 16\n"
                           "mooring = { anchor = [1, 2, 2], stiffness = 400, length = 1 }\n");
    const Real step = 5 * run.scene.dt;  // of the phase
    for (int k = 1; k * step < 6; ++k) {
      run.steps(1);
      EXPECT_NEAR(run.bodies()[0].position.x(), 2 + 0.1 * std::cos(k * step), 0.1 * 6 * step * step / 20) << dt << k;
      EXPECT_NEAR(run.bodies()[0].velocity.x(), -0.5 * std::sin(k * step), 0.5 * 6 * step * step / 20) << dt << k;
    }
  }
}

// A box that turns and falls on a spring from a corner keeps its energy to the square of the step.
TEST(Rolling, ABoxOnASpringKeepsItsEnergy) {
  Real worst[2] = {};
  for (int half = 0; half < 2; ++half) {
    BodyRun run(world, dry_box(half == 0 ? "0.01" : "0.005") +
                           "[gravity]\n[[body]]\ntype = \"box\"\ncenter = [2, 2, 2]\nsize = [0.8, 0.5, 0.3]\n"
                           "mass = 60\nangular_velocity = [0.3, 0.5, 1]\n"
                           "mooring = { anchor = [2.2, 2.1, 3.5], point = [2.3, 2.1, 2.1], stiffness = 3000 }\n");
    const auto energy = [&] {
      RigidBody body(run.scene.bodies[0], *make_shape(run.scene.bodies[0]), *run.scene.gravity, 1000);
      body.set_state(run.bodies()[0]);
      return body.energy();
    };
    const Real start = energy();
    for (int k = 0; k < 50 * (half + 1); ++k) {
      run.steps(1);
      worst[half] = std::max(worst[half], std::abs(energy() - start));
    }
  }
  EXPECT_LT(worst[0], 1.0);
  EXPECT_LT(worst[1], 0.3 * worst[0]);
}

// In a vessel a ball touches more than one place.
TEST(Rolling, ABallComesToRestInTheCornerOfABasin) {
  BodyRun run(world, dry_box("0.01") +
                         "[gravity]\nacceleration = [3, 2, -9]\n[[obstacle]]\ntype = \"basin\"\n"
                         "center = [2, 2, 1]\nsize = [2, 2, 1]\nwall = 0.4\n[[body]]\ntype = \"sphere\"\n"
                         "center = [2, 2, 1]\nradius = 0.2\ndensity = 800\nrestitution = 0.3\n");
  run.steps(500);
  const BodyState end = run.bodies()[0];
  EXPECT_LT((end.position - Vec3(2.8, 2.8, 0.7)).norm(), 1e-3) << end.position.transpose();
  EXPECT_LT(end.velocity.norm(), 1e-3);
}

// A wall that a body begins in, along an axis on which it is not free, is none to it: it was pushed out of it, and
// turned at 160 rad/s. A wall that it comes to stops it.
TEST(Rolling, ABodyTurnsInTheWallThatItBeginsIn) {
  for (const auto& [place, angular_velocity] : {std::pair{"3.95", 1.0}, std::pair{"3.73", 0.0}}) {
    BodyRun run(world, dry_box("0.0166666666666666667") +
                           fmt::format("[walls]\nrestitution = 0\n[[body]]\ntype = \"box\"\nsize = [0.4, 0.4, 0.4]\n"
                                       "density = 500\nfree = [\"yaw\"]\nrotate = [0, 0, 20]\n"
                                       "angular_velocity = [0, 0, 1]\ncenter = [{}, 2, 2]\n",
                                       place));
    run.steps(20);
    EXPECT_NEAR(run.bodies()[0].angular_velocity.z(), angular_velocity, 1e-6) << place;
  }
}

}  // namespace
}  // namespace trevi::test
