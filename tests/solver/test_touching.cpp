// Bodies beside solids and on them: these take nothing of what the water does to a body, and the film of water in
// a contact has the pressure of the water around it.
#include <array>
#include <cmath>
#include <numbers>

#include "base/threads.hpp"
#include "body_run.hpp"
#include "fluid/constraint/density.hpp"
#include "support/cloud.hpp"

namespace trevi::test {
namespace {

constexpr Real pi = std::numbers::pi, half = 0.25;

struct Shape {
  std::string text;
  Real volume;
};
const std::vector<Shape> shapes{
    {"type = \"sphere\"\nradius = 0.25", 4.0 / 3 * pi* half* half* half},
    {"type = \"box\"\nsize = [0.5, 0.5, 0.5]", 0.125},
    {"type = \"cylinder\"\nradius = 0.25\nheight = 0.5\naxis = [1, 0, 0]", pi* half* half * 0.5}};

std::string body_of(const std::string& shape, Real x, Real z, Real density) {
  return fmt::format("[[body]]\n{}\ncenter = [{}, 0.8, {}]\ndensity = {}\n", shape, x, z, density);
}

// A metre of water on the floor of the box, or on that of an obstacle.
std::string water_on(std::optional<Real> floor) {
  const std::string tank = tank_with_gravity({.min = floor ? "0, 0, -0.6" : "0, 0, 0",
                                              .max = "1.8, 1.6, 2",
                                              .water = {{fmt::format("0, 0, {}", floor.value_or(0)), "1.8, 1.6, 1"}}});
  return !floor ? tank
                : tank + fmt::format("[[obstacle]]\ntype = \"box\"\ncenter = [0.9, 0.8, {}]\nsize = [2.2, 2, 0.8]\n",
                                     *floor - 0.4);
}

/// The force of water at rest on the last body of a scene over that by Archimedes' principle.
Vec3 buoyancy(const std::string& text, Real volume) {
  BodyRun run(world, text);
  run.steps(1);
  return run.forces.back()[run.scene.obstacles.size() + run.scene.bodies.size() - 1].force / (9800 * volume);
}

// A floor beneath a body was given what the water above it presses on the body: a third of its weight was missing
// or more, at gaps of up to two spacings.
TEST(Touching, AFloorNearbyTakesNothingOfTheBuoyancy) {
  for (const std::optional<Real> floor : {std::optional<Real>{}, std::optional<Real>(0.0), std::optional<Real>(0.03)}) {
    for (const Shape& shape : shapes) {
      for (const Real gap : {0.0, 0.05, 0.1, 0.15, 0.2, 0.3}) {
        const Vec3 lift =
            buoyancy(water_on(floor) + body_of(shape.text, 0.87, floor.value_or(0) + gap + half, 1000), shape.volume);
        EXPECT_NEAR(lift.z(), 1, gap > 0 ? 0.025 : 0.04) << shape.text << " " << floor.value_or(-1) << " " << gap;
        EXPECT_LT(std::hypot(lift.x(), lift.y()), 0.035) << shape.text << " " << floor.value_or(-1) << " " << gap;
      }
    }
  }
}

TEST(Touching, AnotherBodyNearbyTakesNothingOfTheBuoyancy) {
  const std::string below = body_of("type = \"box\"\nsize = [0.8, 0.8, 0.3]", 0.87, 0.15, 1000);
  for (const Shape& shape : shapes) {
    for (const Real gap : {0.0, 0.05, 0.1}) {
      const Vec3 lift =
          buoyancy(water_on({}) + below + body_of(shape.text, 0.87, 0.3 + gap + half, 1000), shape.volume);
      EXPECT_NEAR(lift.z(), 1, gap > 0 ? 0.03 : 0.13) << shape.text << " " << gap;
    }
  }
}

// Each of two bodies on each other or side by side has what it closes of a face and fills of a cell. With each face and
// cell given to the nearest body, one of them had up to four times its buoyancy, and the other what was missing.
TEST(Touching, BodiesOnEachOtherHaveTheirOwnBuoyancy) {
  struct Pair {
    Real under, off;  // height of the lower one, and what it is off the faces of cells
    Vec3 size;
    Real above, gap = 0;  // size of the other one, and how far it is off
  };
  const auto at = [](const Vec3& size, Real x, Real z) {
    return fmt::format("[[body]]\ntype = \"box\"\nsize = [{}, {}, {}]\ncenter = [{}, 0.6, {}]\ndensity = 1000\n",
                       size.x(), size.y(), size.z(), x, z);
  };
  const std::string tank =
      tank_with_gravity({.max = "2, 1.2, 1.6", .water = {{"0, 0, 0", "2, 1.2, 1"}}, .spacing = "0.05"});
  for (const auto& [under, off, size, above, gap] :
       {Pair{0.1, 0, {0.4, 0.4, 0.4}, 0.4}, Pair{0.1, 0, {0.4, 0.4, 0.4}, 0.4, 0.01},
        Pair{0.1, 0.02, {0.4, 0.4, 0.4}, 0.4}, Pair{0.1, 0.02, {0.4, 0.4, 0.4}, 0.2},
        Pair{0.2, 0, {0.2, 0.2, 0.2}, 0.4}, Pair{0.2, 0.02, {0.2, 0.2, 0.2}, 0.4}, Pair{0, 0, {0.4, 0.4, 0.2}, 0.4}}) {
    const Real touch = under + off + size.z();
    BodyRun run(world,
                tank + at(size, 1, touch - size.z() / 2) + at(Vec3::Constant(above), 1.03, touch + gap + above / 2));
    run.steps(1);
    const std::vector<BodyForce>& forces = run.forces.back();
    const std::array<Real, 2> lift{forces[0].force.z() / (9800 * size.prod()),
                                   forces[1].force.z() / (9800 * above * above * above)};
    for (const Real one : lift)
      EXPECT_NEAR(one, 1, gap > 0 ? 0.16 : 0.1) << under << " " << off << " " << size.x() << " " << above;
  }
}

// The film beside a body has the pressure of its depth: it pushes as strongly as the water on the other side, and does
// not turn the body. It had the mean of what is around the contact, and a box on a wall was pressed onto it by a tenth
// of its weight, one in a corner of the floor by a third.
TEST(Touching, NothingPressesABodyOntoWhatStandsBesideIt) {
  struct Place {
    Vec3 center, size;
  };
  const std::string tank =
      tank_with_gravity({.max = "1.6, 1.2, 1.6", .water = {{"0, 0, 0", "1.6, 1.2, 1"}}, .spacing = "0.05"});
  for (const auto& [center, size] : {Place{{0.8, 0.2, 0.5}, {0.4, 0.4, 0.4}}, Place{{0.2, 0.6, 0.4}, {0.4, 0.4, 0.4}},
                                     Place{{0.2, 0.2, 0.2}, {0.4, 0.4, 0.4}}, Place{{0.8, 0.2, 0.5}, {0.4, 0.4, 0.8}},
                                     Place{{1.3, 0.2, 0.65}, {0.6, 0.4, 0.4}}}) {
    BodyRun run(world, tank + fmt::format("[[body]]\ntype = \"box\"\nsize = [{}, {}, {}]\ncenter = [{}, {}, {}]\n"
                                          "density = 1000\n",
                                          size.x(), size.y(), size.z(), center.x(), center.y(), center.z()));
    run.steps(1);
    const BodyForce& force = run.forces.back()[0];
    const Real weight = 9800 * size.prod();
    EXPECT_LT(std::hypot(force.force.x(), force.force.y()), 0.015 * weight) << center.transpose();
    EXPECT_LT(force.torque.norm(), 0.01 * weight * size.z()) << center.transpose();
  }
}

// Four floats that touch one another, off the cells.
TEST(Touching, ARaftStaysTogether) {
  std::string text =
      tank_with_gravity({.max = "1.8, 1.8, 1.4", .water = {{"0, 0, 0", "1.8, 1.8, 0.8"}}, .spacing = "0.05"});
  for (const Real x : {0.713, 1.113}) {
    for (const Real y : {0.713, 1.113})
      text += fmt::format("[[body]]\ntype = \"box\"\nsize = [0.4, 0.4, 0.2]\ncenter = [{}, {}, 0.76]\ndensity = 700\n",
                          x, y);
  }
  BodyRun run(world, text);
  run.steps(60);
  for (std::size_t k = 0; k < 4; ++k)
    EXPECT_LT((run.bodies()[k].position - run.scene.bodies[k].center).norm(), 0.03) << k;
}

// A wide body that rises by a hair has a gap below it into which its cells let no water.
TEST(Touching, AWideBodyRisesFromTheFloorOfShallowWater) {
  BodyRun run(world,
              tank_with_gravity({.max = "1.6, 1.2, 2", .water = {{"0, 0, 0", "1.6, 1.2, 0.4"}}, .spacing = "0.05"}) +
                  "[[body]]\ntype = \"box\"\nsize = [0.4, 0.4, 1]\ncenter = [0.8, 0.6, 0.5]\ndensity = 300\nfree = "
                  "[\"z\"]\n");
  run.steps(90);
  EXPECT_GT(run.bodies()[0].position.z(), 0.55);
}

// The cells around its sides are nearly filled by it, so that they are no gaps.
TEST(Touching, ABodyWithItsSidesNextToTheFacesOfCellsRisesFromTheFloor) {
  BodyRun run(world,
              tank_with_gravity({.max = "1.6, 1.6, 1.6", .water = {{"0, 0, 0", "1.6, 1.6, 1"}}, .spacing = "0.05"}) +
                  "[[body]]\ntype = \"box\"\nsize = [0.584, 0.584, 0.6]\ncenter = [0.8, 0.8, 0.3]\ndensity = 500\n");
  run.steps(30);
  EXPECT_GT(run.bodies()[0].position.z(), 0.5);
}

// They stayed on it, as if it were sealed to them.
TEST(Touching, LightBodiesRiseFromTheFloor) {
  for (const std::optional<Real> floor : {std::optional<Real>{}, std::optional<Real>(0.0), std::optional<Real>(0.03)}) {
    for (const Shape& shape : shapes) {
      BodyRun run(world, water_on(floor) + body_of(shape.text, 0.87, floor.value_or(0) + half, 500));
      const Real start = run.bodies()[0].position.z();
      run.steps(60);
      EXPECT_GT(run.bodies()[0].position.z(), start + 0.2) << shape.text << " " << floor.value_or(-1);
    }
  }
}

TEST(Touching, HeavyBodiesStayOnTheFloor) {
  for (const Shape& shape : shapes) {
    BodyRun run(world, water_on(0.03) + body_of(shape.text, 0.87, 0.03 + half, 1500));
    run.steps(60);
    EXPECT_NEAR(run.bodies()[0].position.z(), 0.03 + half, 0.002) << shape.text;
  }
}

// Water in the cell above one that an obstacle cuts follows that cell. While the pressure was still being found, this
// read displacements that were not known yet, and ended runs with a segmentation fault.
TEST(Touching, ABodyMayRiseAlongAnObstacle) {
  BodyRun run(world,
              tank_with_gravity({.min = "-0.6, 0, 0", .max = "1.8, 1.6, 2", .water = {{"0, 0, 0", "1.8, 1.6, 1.2"}}}) +
                  "[[obstacle]]\ntype = \"box\"\ncenter = [-0.45, 0.8, 1]\nsize = [0.9, 2, 2.4]\n" +
                  body_of(shapes[1].text, half, 0.6, 500));
  run.steps(60);
  EXPECT_GT(run.bodies()[0].position.z(), 0.9);
}

// On the faces of cells next to none of a body is in a cell with water. What was to put its centroid right there acted
// with an arm of thousands of metres, and the first step ended the run.
TEST(Touching, BoxesMayLieOnEachOtherAndSideBySideOnTheFacesOfCells) {
  const auto box = [](Real x, Real y, Real z, Real height, Real density) {
    return fmt::format("[[body]]\ntype = \"box\"\nsize = [0.4, 0.4, {}]\ncenter = [{}, {}, {}]\ndensity = {}\n", height,
                       x, y, z, density);
  };
  const std::string tank =
      tank_with_gravity({.max = "2.4, 1.2, 1.6", .water = {{"0, 0, 0", "2.4, 1.2, 0.8"}}, .spacing = "0.05"});
  for (const std::string& bodies : {box(1, 0.6, 0.1, 0.2, 2000) + box(1, 0.6, 0.3, 0.2, 2000),
                                    box(1, 0.6, 0.8, 0.4, 500) + box(1.4, 0.6, 0.8, 0.4, 500),
                                    box(1, 0.4, 0.8, 0.4, 500) + box(1, 0.8, 0.8, 0.4, 500)}) {
    BodyRun run(world, tank + bodies);
    run.steps(20);
    for (std::size_t k = 0; k < 2; ++k)
      EXPECT_LT((run.bodies()[k].position - run.scene.bodies[k].center).norm(), 0.02) << bodies;
  }
}

// Water in a tank without air, under the ceiling of the box or a lid that closes it.
std::string full_tank(bool lid) {
  return tank_with_gravity({.max = lid ? "1.2, 1.2, 1.4" : "1.2, 1.2, 0.8",
                            .water = {{"0, 0, 0", "1.2, 1.2, 0.8"}},
                            .spacing = "0.05"}) +
         (lid ? "[[obstacle]]\ntype = \"box\"\nsize = [2, 2, 0.4]\ncenter = [0.6, 0.6, 1]\n" : "");
}

std::string float_in_full_tank(Real x, Real z, Real density) {
  return fmt::format("[[body]]\ntype = \"box\"\nsize = [0.4, 0.4, 0.2]\ncenter = [{}, 0.607, {}]\ndensity = {}\n", x, z,
                     density);
}

// As it closed the gap beneath the lid, the pressure there threw the water out at up to 40 m/s, and did not act on the
// body: the energy rose by 5.8 kJ in a step.
TEST(Touching, ALightBodyThatClosesAGapThrowsNoWater) {
  for (const bool lid : {true, false}) {
    BodyRun run(world, full_tank(lid) + float_in_full_tank(0.613, 0.45, 50));
    Real least = run.energy();
    for (int k = 0; k < 50; ++k) {
      run.steps(1);
      EXPECT_LT(run.energy(), least + 2.5) << lid << " " << k;
      EXPECT_LT(run.rows.back().speed_max, 7) << lid << " " << k;
      least = std::min(least, run.energy());
    }
    EXPECT_NEAR(run.bodies()[0].position.z(), 0.7, 0.01) << lid;
  }
}

// The pressure of the water is zero at the top of the tank, also in the contact. It was zero half a cell lower, and no
// film can pull: a quarter was missing.
TEST(Touching, ABodyAtTheTopOfAFullTankHasItsBuoyancy) {
  for (const bool lid : {true, false}) {
    BodyRun run(world, full_tank(lid) + float_in_full_tank(0.6, 0.7, 200));
    run.steps(20);
    EXPECT_NEAR(run.forces.back()[run.scene.obstacles.size()].force.z(), 9800 * 0.032, 0.03 * 9800 * 0.032) << lid;
  }
}

// A slab has a contact with each of its piers. The film was that of one of them alone, which lifted it off the floor.
TEST(Touching, ABridgeRestsOnItsPiers) {
  const auto block = [](Real x, Real z, Real length, Real height) {
    return fmt::format("[[body]]\ntype = \"box\"\nsize = [{}, 0.4, {}]\ncenter = [{}, 0.6, {}]\ndensity = 1500\n",
                       length, height, x, z);
  };
  BodyRun run(world, tank_with_gravity({.max = "2, 1.2, 1", .water = {{"0, 0, 0", "2, 1.2, 0.7"}}, .spacing = "0.05"}) +
                         block(0.6, 0.15, 0.3, 0.3) + block(1.4, 0.15, 0.3, 0.3) + block(1, 0.375, 1.1, 0.15));
  run.steps(20);
  constexpr int steps = 40;  // whose mean counts: between the piers the weight of the slab shifts from step to step
  std::array<Real, 3> force{};
  for (int n = 0; n < steps; ++n) {
    run.steps(1);
    for (std::size_t k = 0; k < 3; ++k) force[k] += run.forces.back()[k].force.z() / steps;
  }
  const std::array<Real, 3> displaced{0.036, 0.036, 0.066};
  for (std::size_t k = 0; k < 3; ++k) {
    EXPECT_NEAR(force[k] / (9800 * displaced[k]), 1, 0.05) << k;
    EXPECT_LT((run.bodies()[k].position - run.scene.bodies[k].center).norm(), 1e-3) << k;
  }
}

const std::string touching = water_on(0.03) + body_of(shapes[1].text, 0.5, 0.03 + half, 600) +
                             body_of("type = \"box\"\nsize = [0.6, 0.6, 0.3]", 1.3, 0.18, 2000) +
                             body_of("type = \"box\"\nsize = [0.25, 0.3, 0.4]", 0.875, 0.23, 800) +
                             body_of(shapes[0].text, 1.3, 0.33 + half, 700);

TEST(Touching, SameBitsOnAnyRanksAndThreads) {
  BodyRun alone(MPI_COMM_SELF, touching);
  alone.steps(20);
  const int before = thread_count();
  for (const int threads : {1, 2}) {
    use_threads(threads);
    BodyRun together(world, touching,
                     threads == 1 ? std::vector<std::string>{}
                                  : std::vector<std::string>{fmt::format("domain.ranks=[1, {}]", size_of(world))});
    together.steps(20);
    expect_same_bits(gathered(world, together.solver->particles()), gathered(MPI_COMM_SELF, alone.solver->particles()));
    EXPECT_EQ(together.bodies(), alone.bodies());
  }
  use_threads(before);
}

// Cells that a body has left, or is about to reach, may be nearest to it or to an obstacle, as they were last measured.
// What is beside them was that of the one or of the other, and forces of obstacles depended on ranks and restarts.
TEST(Touching, ForcesOfObstaclesAreTheSameOnAnyRanks) {
  const std::string text =
      tank_with_gravity({.min = "0.10299, 0, 0",
                         .max = "3.37178, 0.9458, 1.23595",
                         .water = {{"2.28887, 0.52389, 0.74377", "3.37178, 0.9458, 1.08916",
                                    "velocity = [1.88019, -1.41684, 0.20642]"}},
                         .spacing = "0.06"}) +
      "[[obstacle]]\ntype = \"torus\"\ncenter = [2.32045, 0.05114, 0.23866]\nradius = 0.13585\ntube = 0.05301\n"
      "[[body]]\ntype = \"capsule\"\ncenter = [2.01304, 0.58873, 0.84639]\nradius = 0.13925\nheight = 0.53999\n"
      "density = 500\n";
  BodyRun alone(MPI_COMM_SELF, text), together(world, text);
  for (int k = 0; k < 30; ++k) {
    alone.steps(1);
    together.steps(1);
    for (std::size_t of = 0; of < alone.forces.back().size(); ++of) {
      EXPECT_EQ(alone.forces.back()[of].force, together.forces.back()[of].force) << k << " " << of;
      EXPECT_EQ(alone.forces.back()[of].torque, together.forces.back()[of].torque) << k << " " << of;
    }
  }
}

// What a film gives to a body it takes from what the body touches.
TEST(Touching, MomentumBalances) {
  BodyRun run(world, water_on(0.03) + body_of(shapes[1].text, 0.87, 0.03 + half, 500));
  Real through = 0;
  const auto momentum = [&]() -> Vec3 { return run.rows.back().momentum + run.bodies()[0].momentum; };
  const Real mass =
      static_cast<Real>(run.rows.front().particles) * water_mass(run.scene.fluid) + 500 * shapes[1].volume;
  Vec3 expected = momentum();
  for (int k = 0; k < 10; ++k) {
    run.steps(1);
    const std::vector<BodyForce>& forces = run.forces.back();
    expected += run.scene.dt * (mass * *run.scene.gravity - forces[0].force - forces.back().force);
    for (const BodyForce& one : forces) through += run.scene.dt * one.force.norm();
    EXPECT_LT((momentum() - expected).norm(), 1e-6 * through) << k;
  }
}

}  // namespace
}  // namespace trevi::test
