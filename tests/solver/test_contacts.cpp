// Contacts of bodies with obstacles, the box and each other, with next to no water.
#include <fmt/format.h>

#include <cmath>

#include "body_run.hpp"
#include "support/output_fixture.hpp"

namespace trevi::test {
namespace {

const std::string dry = tank_with_gravity({.max = "2, 2, 2", .water = {{"0, 0, 0", "0.2, 0.2, 0.2"}}});

TEST(Contacts, ABallBouncesAsHighAsItsRestitutionSays) {
  BodyRun run(world, dry +
                         "[walls]\nrestitution = 0.8\n[[body]]\ntype = \"sphere\"\ncenter = [1.2, 1.2, 1.2]\n"
                         "radius = 0.2\ndensity = 500\n");
  Real lowest = 2, highest = 0;
  for (int k = 0; k < 60; ++k) {
    run.steps(1);
    const Real z = run.bodies()[0].position.z();
    lowest = std::min(lowest, z);
    if (run.bodies()[0].velocity.z() > 0 || highest > 0) highest = std::max(highest, z);
  }
  EXPECT_GT(lowest, 0.2 - 0.005);
  EXPECT_NEAR(highest - 0.2, 0.64, 0.1);
}

// And nothing is in anything by more than 0.05 spacings.
TEST(Contacts, AStackRests) {
  std::string text = dry + "[walls]\nrestitution = 0\n";
  for (int k = 0; k < 3; ++k)
    text += fmt::format(
        "[[body]]\ntype = \"box\"\ncenter = [1.2, 1.2, {}]\nsize = [0.4, 0.4, 0.3]\ndensity = 500\n"
        "friction = 0.5\n",
        0.2 + 0.4 * k);
  BodyRun run(world, text);
  for (int k = 0; k < 120; ++k) {
    run.steps(1);
    for (std::size_t n = 0; n < 3; ++n)
      EXPECT_GT(run.bodies()[n].position.z(), 0.15 + 0.3 * static_cast<Real>(n) - 0.005 * static_cast<Real>(n + 1));
  }
  for (std::size_t n = 0; n < 3; ++n) {
    EXPECT_NEAR(run.bodies()[n].position.z(), 0.15 + 0.3 * static_cast<Real>(n), 0.01);
    EXPECT_LT(run.bodies()[n].velocity.norm(), 0.02);
  }
}

// Gravity that leans stands for a slope.
TEST(Contacts, FrictionHoldsABoxOnASlope) {
  for (const Real slope : {0.3, 0.5}) {
    BodyRun run(world,
                dry + fmt::format("acceleration = [{}, 0, -9]\n[walls]\nrestitution = 0\n[[body]]\ntype = \"box\"\n"
                                  "center = [0.8, 1.2, 0.15]\nsize = [0.6, 0.6, 0.3]\ndensity = 500\n"
                                  "friction = 0.4\n",
                                  9 * slope));
    run.steps(30);
    const Real slid = slope > 0.4 ? 9 * (slope - 0.4) * 0.125 : 0;
    EXPECT_NEAR(run.bodies()[0].position.x() - 0.8, slid, 0.02) << slope;
  }
}

// At an angle to the axes, too: against its way, and by no more than along them.
TEST(Contacts, FrictionBrakesAgainstTheWay) {
  for (const Real angle : {0.0, 0.5, 0.8}) {
    BodyRun run(world,
                dry + fmt::format("[walls]\nrestitution = 0\n[[body]]\ntype = \"box\"\ncenter = [0.5, 0.5, 0.1]\n"
                                  "size = [0.4, 0.4, 0.2]\ndensity = 800\nvelocity = [{}, {}, 0]\n"
                                  "friction = 0.3\n",
                                  2 * std::cos(angle), 2 * std::sin(angle)));
    run.steps(30);
    const Real time = run.solver->clock().time();
    const Vec3 way = run.bodies()[0].position - Vec3(0.5, 0.5, 0.1), v = run.bodies()[0].velocity;
    EXPECT_NEAR(std::atan2(way.y(), way.x()), angle, 0.005);
    EXPECT_NEAR(v.norm(), 2 - 0.3 * run.scene.gravity->norm() * time, 0.02) << angle;
  }
}

// A force through the middle of a ball turns it not, whatever it lies on. At rest on two edges it was thrown out at 37
// rad/s; one that slid off a table at 0.4 m/s left it at 1.7.
TEST(Contacts, EdgesTurnNoBallThatHasNoFriction) {
  const std::string block = "[[obstacle]]\ntype = \"box\"\nsize = [0.8, 1.0, 0.6]\nrestitution = 0\n";
  const std::string ball = "[walls]\nrestitution = 0\n[[body]]\ntype = \"sphere\"\nradius = 0.25\ndensity = 2000\n";
  BodyRun rests(world, dry + block + "center = [0.55, 1, 0.3]\n" + block + "center = [1.65, 1, 0.3]\n" + ball +
                           "center = [1.1, 1, 0.800001]\n");
  rests.steps(120);
  EXPECT_NEAR((rests.bodies()[0].position - Vec3(1.1, 1, 0.8)).norm(), 0, 1e-3);
  EXPECT_LT(rests.bodies()[0].angular_velocity.norm(), 1e-9);
  BodyRun slides(world,
                 dry + block + "center = [0.6, 1, 0.3]\n" + ball + "center = [0.9, 1, 0.85]\nvelocity = [0.4, 0, 0]\n");
  while (slides.bodies()[0].position.z() > 0.4) slides.steps(1);
  // It leaves the edge where what is left of its weight is what keeps it on its circle.
  const Real g = slides.scene.gravity->norm(), radius = 0.25, start = 0.4 * 0.4;
  const Real cosine = (2 * g * radius + start) / (3 * g * radius);
  EXPECT_NEAR(slides.bodies()[0].velocity.x(), std::sqrt(cosine * g * radius) * cosine, 0.05);
  EXPECT_LT(slides.bodies()[0].angular_velocity.norm(), 1e-9);
}

// Between the points of its own surface. It fell through, and stood on the floor with the wall in it.
TEST(Contacts, ABoxStandsOnAThinWall) {
  for (const Real wall : {1.0, 1.05}) {
    BodyRun run(world,
                dry + fmt::format("[[obstacle]]\ntype = \"box\"\nsize = [0.02, 1.0, 0.6]\ncenter = [{}, 1, 0.3]\n"
                                  "[walls]\nrestitution = 0\n[[body]]\ntype = \"box\"\nsize = [0.5, 0.5, 0.5]\n"
                                  "center = [1, 1, 0.95]\ndensity = 800\nfree = [\"z\"]\n",
                                  wall));
    run.steps(90);
    EXPECT_NEAR(run.bodies()[0].position.z(), 0.85, 0.005) << wall;
  }
}

}  // namespace
}  // namespace trevi::test
