// Solids that move deep under water: no air gets to them, so the pressure on them changes as smoothly as their motion.
// Cells that they had just left counted as dry, as too few particles were there, and pressure fell to that of the air.
#include <algorithm>
#include <cmath>
#include <memory>
#include <numbers>

#include "body_run.hpp"
#include "support/cloud.hpp"
#include "support/joined_mesh.hpp"

namespace trevi::test {
namespace {

const std::string deep = tank_with_gravity({.max = "2.4, 1.6, 2.2", .water = {{"0, 0, 0", "2.4, 1.6, 1.8"}}});

// At that speed drag is a hundredth of the weight of the water that it displaces.
TEST(Submerged, ABallThatIsPulledFeelsItsBuoyancyInEachStep) {
  const Real radius = 0.4, weight = 1000 * 9.81 * 4 / 3 * std::numbers::pi * std::pow(radius, 3);
  for (const char* const height : {"0.8", "0.83"}) {
    BodyRun run(world, deep +
                           "[[obstacle]]\ntype = 'sphere'\nradius = 0.4\nvelocity = [0.4, 0, 0]\ncenter = [0.8, 0.8, " +
                           height + "]\n");
    run.steps(90);
    for (std::size_t k = 3; k < run.forces.size(); ++k) {
      const Vec3 part = run.forces[k][0].force / weight;
      ASSERT_NEAR(part.x(), 0, 0.15) << "step " << k << ", at height " << height;
      ASSERT_NEAR(part.z(), 1, 0.1) << "step " << k << ", at height " << height;
    }
  }
}

// There is no direction up, but no air, either. It takes the water's momentum in the first step, and drag alone later;
// 150 times the head of its speed pushed it back in the fourth step. Where it lies symmetrically to the cells the force
// still comes to 12 heads, in one step of each cell that it goes.
TEST(Submerged, NoAirOpensBehindACylinderInAFullTankWithoutGravity) {
  BodyRun run(world,
              "[domain]\nmin = [0, 0, 0]\nmax = [2.4, 1.6, 2.4]\n[fluid]\nspacing = 0.1\n[time]\ndt = 0.0166666667\n"
              "end = 1.0\n[[particles]]\nmin = [0, 0, 0]\nmax = [2.4, 1.6, 2.4]\n[[obstacle]]\ntype = 'cylinder'\n"
              "axis = [0, 1, 0]\nheight = 6\nradius = 0.4\ncenter = [0.83, 0.8, 1.17]\nvelocity = [0.4, 0, 0]\n");
  run.steps(30);
  const Real head = 500 * 0.4 * 0.4 * 0.8 * 1.6;
  for (std::size_t k = 4; k < run.forces.size(); ++k) EXPECT_LT(run.forces[k][0].force.norm(), 6 * head) << k;
}

// Pulled by a spring, a ball takes half of the water that it displaces along (Lamb, Hydrodynamics, 6th ed., §92), and a
// little more in a tank. It came to 0.44 of its start in 0.6 of the period, as the flow about it was damped as noise.
TEST(Submerged, ABallOnASpringSwingsAsAnIdealFluidLetsIt) {
  const Real radius = 0.3, start = 0.15, stiffness = 432, volume = 4 * std::numbers::pi / 3 * std::pow(radius, 3);
  BodyRun run(world, tank_with_gravity({.max = "2, 2, 2.4", .water = {{"0, 0, 0", "2, 2, 2"}}}) +
                         "[[body]]\ntype = 'sphere'\nradius = 0.3\ndensity = 500\nfree = ['x']\n"
                         "center = [1.15, 1, 1]\nmooring = { anchor = [0, 1, 1], stiffness = 432, length = 1 }\n");
  const Real half_period = std::numbers::pi * std::sqrt((500 + 500) * volume / stiffness), dt = run.scene.dt;
  Real farthest = 0, middle = 0;  // m on the other side; when it goes through the middle, s
  for (Real time = dt, last = start; time < 1.1 * half_period; time += dt) {
    run.steps(1);
    const Real here = run.bodies()[0].position.x() - 1;
    if (last > 0 && here <= 0) middle = time - dt * here / (here - last);
    farthest = std::max(farthest, -here);
    last = here;
  }
  EXPECT_GT(farthest, 0.85 * start);
  EXPECT_NEAR(2 * middle / half_period, 1, 0.05);
}

// Balls two cells across and of the mass of two particles: cells see their surface as stairs, by which they were spun,
// the faster the faster they turned, to 1e4 rad/s. That a ball has axes about which nothing turns it helps no mesh.
TEST(Submerged, ASmallLightBallIsNotSpun) {
  struct Ball {
    std::string text;
    bool is_mesh;
  };
  for (const auto& [ball, is_mesh] : {Ball{"radius = 0.12\ncenter = [0.4986, 0.47256, 0.3]\n", false},
                                      Ball{"radius = 0.132\ncenter = [0.4986, 0.47256, 0.3]\n", false},
                                      Ball{"radius = 0.12\ncenter = [0.48, 0.48, 0.3]\n", true}}) {
    Scene scene =
        parse_scene("test.toml",
                    "[domain]\nmin = [0, 0, 0]\nmax = [0.96, 0.96, 3]\n[fluid]\nspacing = 0.06\n[gravity]\n[time]\n"
                    "dt = 0.0166666667\nend = 1\n[[particles]]\nmin = [0, 0, 0]\nmax = [0.96, 0.96, 1.5]\n[[body]]\n"
                    "type = 'sphere'\ndensity = 50\n" +
                        ball,
                    {});
    BodySettings& solid = scene.bodies[0];
    if (is_mesh) {
      solid.mesh = std::make_shared<TriangleMesh>(joined(make_shape(solid)->surface(0.02)));
      solid.shape = ShapeKind::mesh;
    }
    BodyRun run(world, scene);
    for (int k = 0; k < 40; ++k) {
      run.steps(1);
      ASSERT_LT(run.bodies()[0].angular_velocity.norm(), 20) << "step " << k;
      ASSERT_LT(run.bodies()[0].velocity.norm(), 4) << "step " << k;
    }
  }
}

// Where nothing holds the water a ball that spins leaves it at rest, and goes on. Its cells saw stairs that turn: they
// gave 64 J to the water in half a second.
TEST(Submerged, ABallThatSpinsMovesNoWater) {
  BodyRun run(world, tank_with_gravity({.max = "1.6, 1.6, 2", .water = {{"0, 0, 0", "1.6, 1.6, 1.6"}}}) +
                         "[[body]]\ntype = 'sphere'\nradius = 0.3\ndensity = 1000\ncenter = [0.83, 0.79, 0.8]\n"
                         "angular_velocity = [0, 0, 10]\n");
  run.steps(60);
  EXPECT_NEAR(run.bodies()[0].angular_velocity.z(), 10, 1e-4);
  EXPECT_LT(run.rows.back().kinetic_energy, 0.3);
}

// Water that sloshes takes a ball of its density along, and back. In a standing wave its path is that of the water, to
// second order in how small the ball is. Of the 0.06 m of the surface whole layers of the lattice leave 0.048 in the
// first harmonic, by which the water there goes 0.065 m in linear theory. By the particles that happened to be in the
// cells that it cuts the ball came 0.9 spacings too far back in the first period.
TEST(Submerged, ABallOfTheWatersDensityGoesWithSloshingWater) {
  BodyRun run(world,
              "[domain]\nmin = [0, 0, 0]\nmax = [2, 0.4, 1.3]\n[fluid]\nspacing = 0.04\n[gravity]\n[time]\n"
              "dt = 0.0166666667\nend = 2\n[[particles]]\nmin = [0, 0, 0]\nmax = [2, 0.4, 1]\n"
              "surface = '0.8 + 0.06 * cos(pi * x / 2)'\n[[body]]\ntype = 'sphere'\nradius = 0.12\n"
              "density = 1000\ncenter = [0.6, 0.2, 0.5]\n");
  const Real k = std::numbers::pi / 2, g = 9.81, depth = 0.8;
  const Real half_period = std::numbers::pi / std::sqrt(g * k * std::tanh(k * depth));
  const auto after = static_cast<int>(std::lround(60 * half_period));
  run.steps(after);
  EXPECT_NEAR(run.bodies()[0].position.x(), 0.665, 0.012);
  run.steps(after);
  EXPECT_NEAR(run.bodies()[0].position.x(), 0.6, 0.012);
  EXPECT_NEAR(run.bodies()[0].position.y(), 0.2, 0.002);
  EXPECT_NEAR(run.bodies()[0].position.z(), 0.5, 0.012);
}

// Water that falls presses nothing, and a ball in it falls as it does: in any step it was ahead by g dt t/2.
TEST(Submerged, ABallOfTheWatersDensityFallsWithIt) {
  BodyRun run(world,
              "[domain]\nmin = [0, 0, 0]\nmax = [1.6, 1.6, 3]\n[fluid]\nspacing = 0.05\n[gravity]\n[time]\n"
              "dt = 0.0166666667\nend = 1\n[[particles]]\nmin = [0.4, 0.4, 2]\nmax = [1.2, 1.2, 2.8]\n[[body]]\n"
              "type = 'sphere'\nradius = 0.2\ndensity = 1000\ncenter = [0.81, 0.78, 2.4]\n");
  run.steps(30);
  const Real time = 30 * run.scene.dt;
  EXPECT_NEAR(run.bodies()[0].position.z(), 2.4 + (*run.scene.gravity).z() * time * time / 2, 0.1 * 0.05);
  EXPECT_NEAR(run.bodies()[0].velocity.z(), (*run.scene.gravity).z() * time, 0.02);
}

// By less and less as it gets faster and nears the surface, from (rho - rho_b)/(rho_b + rho/2) g on (Lamb,
// Hydrodynamics, 6th ed., §92), less in a narrow tank. It was thrown back by as much in the 14th step, and twice as far
// on in the 15th.
TEST(Submerged, ALightBallIsPushedUpInEachStep) {
  BodyRun run(world, deep + "[[body]]\ntype = 'sphere'\nradius = 0.4\ndensity = 300\nfree = ['z']\n" +
                         "center = [1.2, 0.8, 0.6]\n");
  const Real at_first = 0.7 / 0.8 * 9.81 / 60;
  for (Real last = 0; run.rows.size() < 19;) {
    run.steps(1);
    const Real now = run.bodies()[0].velocity.z();
    EXPECT_GT(now - last, 0.3 * at_first) << "step " << run.rows.size() - 1;
    EXPECT_LT(now - last, 1.1 * at_first) << "step " << run.rows.size() - 1;
    last = now;
  }
}

// A box of a twentieth of the water's density, at an angle. Water that is taken along by the ends of a side resists its
// turning more than by the middles; when only those counted, its answers to the pressure overshot more and more.
TEST(Submerged, ALightBoxIsPushedUpInEachStep) {
  BodyRun run(world, deep + "[[body]]\ntype = 'box'\nsize = [0.3, 0.57, 0.69]\ndensity = 50\n" +
                         "center = [1.2, 0.8, 0.8]\nrotate = [8, 50, 77]\n");
  const Real start = run.energy();
  for (Vec3 last = Vec3::Zero(); run.rows.size() < 13;) {
    run.steps(1);
    const BodyState now = run.bodies()[0];
    EXPECT_LT((now.velocity - last).norm(), 0.7) << "step " << run.rows.size() - 1;
    EXPECT_LT(now.angular_velocity.norm(), 3) << "step " << run.rows.size() - 1;
    EXPECT_LT(run.energy(), start) << "step " << run.rows.size() - 1;
    last = now.velocity;
  }
}

// Water that it pushes away is not much faster than itself, and water and body have no more energy than at the start:
// the few particles in the cells that its upper side cuts were told to leave them as the flow beside it said, and at
// short steps had three times its speed.
TEST(Submerged, ALightBoxThrowsNoWater) {
  BodyRun run(
      world,
      tank_with_gravity({.max = "1.2, 1.2, 2.0", .water = {{"0, 0, 0", "1.2, 1.2, 1.2"}}}) +
          "[[body]]\ntype = 'box'\nsize = [0.563, 0.464, 0.582]\ndensity = 70\ncenter = [0.611, 0.569, 0.435]\n",
      {"time.dt=0.004166666666666667"});
  const Real start = run.energy(), buoyancy = 930 * 9.81 * 0.563 * 0.464 * 0.582;
  Real largest = 0, highest = 0;
  while (run.rows.size() < 49) {
    run.steps(1);
    largest = std::max(largest, run.rows.back().speed_max / run.bodies()[0].velocity.norm());
    highest = std::max(highest, (run.energy() - start) / buoyancy);
  }
  EXPECT_LT(largest, 2.5);
  EXPECT_LT(highest, 0.001);  // m
}

// Beside a wall, and above a floor, that are obstacles, half a cell away: a body of the water's density, or half of it,
// stays where it is, as beside the walls of the box. When the pressure on what else is solid in a cell that a body cuts
// counted as the body's, it was drawn there at some metres per second squared.
TEST(Submerged, NothingDrawsABodyToAnObstacle) {
  const std::string solid = "[[obstacle]]\ntype = 'box'\n", body = "[[body]]\ntype = 'box'\nsize = [0.4, 0.4, 0.4]\n";
  BodyRun wall(world, pool + solid + "size = [2, 4, 6]\ncenter = [-0.6, 0.6, 1]\n" + body +
                          "density = 500\ncenter = [0.7, 0.6, 1]\n");
  BodyRun floor(world, pool + solid + "size = [6, 4, 2]\ncenter = [0.8, 0.6, -0.6]\n" + body +
                           "density = 1000\ncenter = [0.8, 0.6, 0.7]\n");
  for (BodyRun* run : {&wall, &floor}) {
    run->steps(6);
    EXPECT_LT(run->bodies().front().velocity.norm(), 0.02);
  }
}

}  // namespace
}  // namespace trevi::test
