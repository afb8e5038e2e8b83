// Bodies in two dimensions: they stay in the plane, fall, float and turn there as they should, and several of them that
// close water off between each other, the floor and the walls neither throw it nor each other.
#include <cmath>
#include <numbers>

#include "base/threads.hpp"
#include "body_run.hpp"
#include "boundary/geometry/mass_properties.hpp"
#include "support/cloud.hpp"
#include "trevi/error.hpp"

namespace trevi::test {
namespace {

// A pool 3 m long and a metre deep.
std::string pool_in_plane(const std::string& bodies, Real length = 3, Real depth = 1) {
  return tank_with_gravity({.min = "0, 0",
                            .max = fmt::format("{}, 3", length),
                            .water = {{"0, 0", fmt::format("{}, {}", length, depth)}},
                            .spacing = "0.05",
                            .domain = "dimensions = 2"}) +
         bodies;
}

std::string cylinder_at(Real x, Real z, Real density, const std::string& more = "") {
  return fmt::format("[[body]]\ntype = \"cylinder\"\nradius = 0.2\ncenter = [{}, {}]\ndensity = {}\n{}", x, z, density,
                     more);
}

TEST(PlaneBodies, HaveTheMassOfTheLayer) {
  const std::string bodies =
      cylinder_at(0.5, 2, 500) +
      "[[body]]\ntype = \"box\"\nsize = [0.6, 7, 0.4]\ncenter = [1.5, 2]\nmass = 3\n"
      "[[body]]\ntype = \"basin\"\nsize = [0.5, 0.3]\nwall = 0.2\ncenter = [2.3, 2]\ndensity = 700\n";
  BodyRun run(world, pool_in_plane(bodies));
  const std::vector<BodySettings>& all = run.scene.bodies;
  EXPECT_NEAR(mass_properties(all[0]).volume, std::numbers::pi * 0.04 * 0.05, 1e-12);
  EXPECT_NEAR(mass_properties(all[1]).volume, 0.6 * 0.4 * 0.05, 1e-12);
  EXPECT_NEAR(mass_properties(all[2]).volume, (0.9 * 0.5 - 0.5 * 0.3) * 0.05, 1e-12) << "without walls along y";
  EXPECT_NEAR(mass_properties(all[2]).center.z(), -(0.45 * 0.1) / (0.45 - 0.15), 1e-12);
  for (const BodySettings& one : all) EXPECT_EQ(one.free, (std::array<bool, 6>{true, false, true, false, true, false}));
}

TEST(PlaneBodies, FlyOnAParabolaAndTurnAtTheirRate) {
  BodyRun run(world, pool_in_plane("[[body]]\ntype = \"box\"\nsize = [0.5, 0.3]\ncenter = [1, 2]\ndensity = 800\n"
                                   "velocity = [1, 2]\nangular_velocity = [0, 3, 0]\n"));
  run.steps(24);
  const Real t = 24 * run.scene.dt;
  const BodyState body = run.bodies()[0];
  EXPECT_NEAR(body.position.z(), 2 + 2 * t - 9.8 / 2 * t * t, 1e-9);
  EXPECT_NEAR(body.position.x(), 1 + t, 1e-12);
  EXPECT_EQ(body.position.y(), 0);
  EXPECT_NEAR(body.angular_velocity.y(), 3, 1e-9);
  EXPECT_EQ(body.angular_velocity.x(), 0);
}

// A force of 25.7 N on a cylinder of 200 kg/m³ moves it by the mass of the layer and of the water that goes with
// it, 1.07 of what it displaces between these walls. Without gravity the pressure behind it is negative; it was taken
// to be 0, and the cylinder got 1.3 times the speed.
TEST(PlaneBodies, AreAsHardToMoveInAFullTankWithoutGravity) {
  for (const Real g : {9.8, 0.0}) {
    BodyRun run(world,
                tank_text({.min = "0, 0",
                           .max = "4, 4",
                           .water = {{"0, 0", "4, 4"}},
                           .spacing = "0.05",
                           .domain = "dimensions = 2"}) +
                    fmt::format("[gravity]\nacceleration = [0, {}]\n[[body]]\ntype = \"cylinder\"\nradius = 0.5\n"
                                "center = [2, 2]\ndensity = 200\nfree = [\"x\"]\nmooring = {{ anchor = [42, 2], "
                                "stiffness = 0.64178, length = 0 }}\n",
                                -g));
    run.steps(12);
    EXPECT_NEAR(run.bodies()[0].velocity.x() / (12 * run.scene.dt), 25.67 / (7.85 + 1.069 * 39.27), 0.03) << g;
  }
}

// Cylinders lie as deep as they are heavy in the water whose level they raise.
TEST(PlaneBodies, FloatAsDeepAsTheyAreHeavy) {
  BodyRun run(world,
              pool_in_plane("[[body]]\ntype = \"box\"\nsize = [0.8, 0.4]\ncenter = [1.5, 1.01]\ndensity = 500\n"));
  run.steps(240);
  const Real level = (static_cast<Real>(run.rows.front().particles) * 0.05 * 0.05 + 0.8 * 0.4 / 2) / 3;
  EXPECT_NEAR(run.bodies()[0].position.z(), level, 0.1 * 0.05);
  EXPECT_LT(std::abs(run.bodies()[0].orientation[2]), 0.005) << "upright";
  EXPECT_NEAR(run.forces.back()[0].force.z(), 0.8 * 0.4 * 0.05 * 500 * 9.8, 0.01 * 78);
}

// Two heavy cylinders that roll together on the floor close the water between them off. With links between cells that
// were halved on each level of the multigrid, and slits of a ten-thousandth of a face, its pressure grew without bound
// within a step: they were thrown at 8 km/s. The same happened in three dimensions.
TEST(PlaneBodies, ThoseThatCloseWaterOffStayWhereTheyAre) {
  for (const Real gap : {0.005, 0.011, 0.03}) {
    BodyRun run(world, pool_in_plane(cylinder_at(1.6, 0.2, 3000, "velocity = [0.2, 0]\n") +
                                         cylinder_at(2 + gap, 0.2, 3000, "velocity = [-0.2, 0]\n"),
                                     4, 0.8));
    const Real start = run.energy();
    Real fastest = 0;
    for (int k = 0; k < 90; ++k) {
      run.steps(1);
      for (const BodyState& body : run.bodies()) fastest = std::max(fastest, body.velocity.norm());
    }
    EXPECT_LT(fastest, 0.5) << gap;
    EXPECT_LT(run.energy(), start + 0.5) << gap;
  }
}

TEST(PlaneBodies, SameBitsOfWaterThatBodiesCloseOff) {
  const std::string text = pool_in_plane(
      cylinder_at(1.6, 0.2, 3000, "velocity = [0.2, 0]\n") + cylinder_at(2.005, 0.2, 3000, "velocity = [-0.2, 0]\n") +
          "[[body]]\ntype = \"box\"\nsize = [0.4, 0.3]\ncenter = [1.8, 0.66]\ndensity = 300\nrotate = [0, 20, 0]\n",
      4, 0.8);
  BodyRun alone(MPI_COMM_SELF, text);
  alone.steps(45);
  const int before = thread_count();
  for (const int threads : {1, 2}) {
    use_threads(threads);
    BodyRun together(world, text);
    together.steps(45);
    expect_same_bits(gathered(world, together.solver->particles()), gathered(MPI_COMM_SELF, alone.solver->particles()));
    EXPECT_EQ(together.bodies(), alone.bodies());
  }
  use_threads(before);
}

TEST(PlaneBodies, WhatHasNoPlaceThereIsRefused) {
  const auto refuses = [](const std::string& body, const std::string& why) {
    try {
      BodyRun run(world, pool_in_plane("[[body]]\ncenter = [1.5, 2]\ndensity = 500\n" + body));
      ADD_FAILURE() << body;
    } catch (const InputError& error) {
      EXPECT_NE(std::string(error.what()).find(why), std::string::npos) << error.what();
    }
  };
  refuses("type = \"sphere\"\nradius = 0.2\n", "take type = \"cylinder\"");
  refuses("type = \"cylinder\"\nradius = 0.2\nvelocity = [0, 1, 0]\n", "must be 0 along y");
  refuses("type = \"cylinder\"\nradius = 0.2\nangular_velocity = [1, 0, 0]\n", "must be about y");
  refuses("type = \"cylinder\"\nradius = 0.2\nfree = [\"y\", \"yaw\"]\n", "free to do nothing in the plane");
}

}  // namespace
}  // namespace trevi::test
