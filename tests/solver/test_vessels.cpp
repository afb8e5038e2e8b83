// Water in vessels and around obstacles, through the whole solver: nobody leaks, still water stays still, forces are
// those of Archimedes and balance with momentum, and the bits do not depend on the ranks.
#include <cmath>
#include <numbers>

#include "boundary/obstacles/body.hpp"
#include "fluid/constraint/density.hpp"
#include "support/cloud.hpp"
#include "support/kept_run.hpp"
#include "support/output_fixture.hpp"
#include "support/tank.hpp"

namespace trevi::test {
namespace {

Scene scene_of(const std::string& text, const std::vector<ObstacleKnot>& knots) {
  Scene scene = parse_scene("test.toml", text, {});
  if (!knots.empty()) scene.obstacles.front().knots = knots;
  return scene;
}

struct VesselRun : KeptRun {
  VesselRun(MPI_Comm comm, const std::string& text, const std::vector<ObstacleKnot>& knots = {})
      : KeptRun(comm, scene_of(text, knots)) {}
  /// The least distance of a particle of this rank to a surface, negative in a solid.
  Real nearest() const {
    Real least = 1e300;
    for (const ObstacleSettings& obstacle : scene.obstacles) {
      const auto shape = make_shape(obstacle);
      const Pose pose = BodyMotion(obstacle).at(solver->clock().time());
      for (const Vec3& p : solver->particles().position) least = std::min(least, shape->distance(pose.into_body(p)));
    }
    return least;
  }
};

const std::string pool = tank_with_gravity({.max = "1.6, 1.2, 1.6", .water = {{"0, 0, 0", "1.6, 1.2, 1.2"}}});

const std::string ball = R"(
[[obstacle]]
type = "sphere"
center = [0.75, 0.6, 0.6]
radius = 0.3
)";

TEST(Vessels, SameBitsOnAnyRanks) {
  const std::string scene = pool + ball +
                            "velocity = [0.3, 0, 0.2]\nangular_velocity = [1, 2, 3]\n[[obstacle]]\ntype = 'box'\n"
                            "center = [0.8, 0.6, 0.8]\nsize = [1.5, 1.1, 1.5]\nrotate = [0, 10, 5]\ninside = true\n";
  for (const char* precision : {"double", "single"}) {
    const std::string text = scene + "[density]\nprecision = '" + precision + "'\n";
    VesselRun together(world, text), alone(MPI_COMM_SELF, text);
    together.steps(15);
    alone.steps(15);
    const Cloud a = gathered(world, together.solver->particles()),
                b = gathered(MPI_COMM_SELF, alone.solver->particles());
    EXPECT_EQ(a.id, b.id);
    EXPECT_EQ(a.position, b.position);
    EXPECT_EQ(a.velocity, b.velocity);
    for (std::size_t k = 0; k < together.forces.back().size(); ++k) {
      EXPECT_EQ(together.forces.back()[k].force, alone.forces.back()[k].force);
      EXPECT_EQ(together.forces.back()[k].torque, alone.forces.back()[k].torque);
    }
    EXPECT_GT(together.nearest(), -1e-9);
  }
}

// The momentum of water with rest density changes by its weight less what obstacles and the box took.
TEST(Vessels, MomentumBalances) {
  VesselRun run(world, pool + ball + "velocity = [1, 0, 0.5]\n");
  run.steps(30);
  const Real count = static_cast<Real>(run.rows.front().particles), mass = 1000 * 1e-3;
  const Real dt = run.scene.dt;
  for (std::size_t k = 1; k < run.rows.size(); ++k) {
    Vec3 taken = Vec3::Zero();
    for (const BodyForce& one : run.forces[k]) taken += one.force;
    const Vec3 change = (run.rows[k].momentum - run.rows[k - 1].momentum) / dt;
    const Vec3 weight(0, 0, -9.8 * count * mass);
    EXPECT_LT((change - (weight - taken)).norm(), 1e-6 * weight.norm()) << k;
  }
}

// In the mean over steps at rest, without a torque about the middle. With the pressure of a cell at the mean height of
// the solid's surface in it plates and boxes at an angle had 0.86 to 0.94 of it, and a torque of 0.012 of it times
// their width.
TEST(Vessels, BuoyancyIsThatOfArchimedes) {
  struct Shape {
    const char* text;
    Real volume;
  };
  const auto ball_of = [](Real radius) { return std::numbers::pi * 4 / 3 * radius * radius * radius; };
  for (const auto& [shape, volume] : {Shape{"type = 'sphere'\nradius = 0.35", ball_of(0.35)},
                                      {"type = 'sphere'\nradius = 0.22", ball_of(0.22)},
                                      {"type = 'box'\nsize = [0.5, 0.44, 0.53]", 0.5 * 0.44 * 0.53},
                                      {"type = 'box'\nsize = [0.6, 0.6, 0.2]\nrotate = [30, 0, 0]", 0.6 * 0.6 * 0.2},
                                      {"type = 'box'\nsize = [0.4, 0.4, 0.4]\nrotate = [20, 35, 50]", 0.064}}) {
    VesselRun run(world, pool + "[[obstacle]]\ncenter = [0.77, 0.61, 0.57]\n" + shape + "\n");
    run.steps(120);
    Vec3 force = Vec3::Zero(), torque = force;
    const Real count = static_cast<Real>(run.forces.size() - 60);
    for (std::size_t k = 60; k < run.forces.size(); ++k) {
      force += run.forces[k][0].force / count;
      torque += run.forces[k][0].torque / count;
    }
    const Real expected = 1000 * 9.8 * volume;
    if (rank_of(world) == 0) std::printf("buoyancy over rho g V: %.4f\n", force.z() / expected);
    EXPECT_NEAR(force.z() / expected, 1, 0.02) << shape;
    EXPECT_LT(std::abs(force.x()) + std::abs(force.y()), 0.02 * expected) << shape;
    EXPECT_LT(torque.norm(), 0.004 * expected * 0.6) << shape;
  }
}

// A gate whose face goes through the middles of cells, from wall to wall and to the lid, along both axes: water presses
// it along its normal, and the walls alike on both sides. As long as its part of the upper wall counted as open it was
// pushed there with an eighth of that.
TEST(Vessels, AGateFromWallToWallIsPressedAlongItsNormal) {
  for (const bool along_x : {true, false}) {
    VesselRun run(world, tank_with_gravity({.max = along_x ? "2.4, 0.8, 1" : "0.8, 2.4, 1",
                                            .water = {{along_x ? "0.5, 0, 0" : "0, 0.5, 0",
                                                       along_x ? "2.4, 0.8, 0.8" : "0.8, 2.4, 0.8"}}}) +
                             "[[obstacle]]\ntype = 'box'\nsize = [3, 3, 3]\n" +
                             (along_x ? "center = [-1, 0.4, 0.5]\n" : "center = [0.4, -1, 0.5]\n"));
    run.steps(3);
    Vec3 force = run.forces.back()[0].force;
    if (!along_x) std::swap(force.x(), force.y());
    EXPECT_NEAR(force.x() / (-1000 * 9.8 * 0.8 * 0.8 * 0.8 / 2), 1, 2e-3);
    EXPECT_LT(std::abs(force.y()), 1e-6 * std::abs(force.x()));
  }
}

// Layers that fill cells, and that end in the middle of one: what stands there above the middle, or in the dry cell
// over the top one, presses, too. Without it one layer pressed with 0.40 of this, three with 0.89.
TEST(Vessels, StillWaterPressesAnUprightSideAsDeepAsItStands) {
  for (const Real depth : {0.1, 0.2, 0.3, 0.5}) {
    VesselRun run(world, tank_with_gravity(
                             {.max = "1.6, 0.8, 1", .water = {{"0.6, 0, 0", "1.6, 0.8, " + std::to_string(depth)}}}) +
                             "[[obstacle]]\ntype = 'box'\nsize = [3, 3, 3]\ncenter = [-0.9, 0.4, 0.5]\n");
    run.steps(3);
    EXPECT_NEAR(run.forces.back()[0].force.x() / (-1000 * 9.8 * 0.8 * depth * depth / 2), 1, 2e-3) << depth;
  }
}

// What the transfer between particles and cells leaves over once had its moment about the origin, so that a torque was
// 50 times as large 64 m from there.
TEST(Vessels, TorquesAreAboutTheCentreWhereverTheOriginIs) {
  const auto torque = [](const std::string& x) {  // m, so that nothing is rounded
    VesselRun run(world, tank_with_gravity({.min = x + ".0, 0, 0",
                                            .max = x + ".75, 0.5, 1",
                                            .water = {{x + ".0, 0, 0", x + ".25, 0.5, 0.5"}},
                                            .spacing = "0.0625"}) +
                             "[[obstacle]]\ntype = 'box'\ncenter = [" + x +
                             ".4375, 0.28125, 0.1875]\nsize = [0.1875, 0.25, 0.375]\n");
    run.steps(15);
    return run.forces.back()[0];
  };
  const BodyForce here = torque("0"), there = torque("64");
  EXPECT_GT(here.force.norm(), 10);
  EXPECT_LT((there.force - here.force).norm(), 1e-3 * here.force.norm());
  EXPECT_LT((there.torque - here.torque).norm(), 1e-3 * here.torque.norm());
}

// Shaken at 10 m/s and 20 g for half a second: a swing of 0.51 m along x, with the same along z a quarter later.
TEST(Vessels, NobodyLeavesAShakenBall) {
  const std::string text =
      tank_with_gravity(
          {.min = "-1.2, -0.7, -1.2", .max = "1.2, 0.7, 1.2", .water = {{"-0.6, -0.6, -0.6", "0.6, 0.6, 0.1"}}}) +
      R"([[obstacle]]
type = "sphere"
center = [0, 0, 0]
radius = 0.6
inside = true
)";
  std::vector<ObstacleKnot> knots;
  constexpr Real speed = 10, acceleration = 20 * 9.8;
  constexpr Real omega = acceleration / speed, swing = speed / omega;
  for (int k = 0; k <= 400; ++k) {
    const Real t = 0.0025 * k;
    knots.push_back({t, Vec3(swing * std::sin(omega * t), 0, swing * (1 - std::cos(omega * t)) * 0.5)});
  }
  VesselRun run(world, text, knots);
  for (int k = 0; k < 30; ++k) {
    run.steps(1);
    ASSERT_GT(run.nearest(), -1e-9) << k;
  }
  EXPECT_EQ(run.rows.back().particles, run.rows.front().particles);
  EXPECT_GT(run.rows.back().speed_max, 3);
}

// About as calm after 8 s as a pool that has to settle in the plain box (1.1e-4 m²/s²): 5.2e-4, and less than 8e-4; and
// its centre of mass is within 0.2 spacings of that of as much in such a box, which is the block's part of it: 0.985 m³
// but for what a lattice that lies anyhow to its walls has by chance.
TEST(Vessels, WaterRestsInATurnedBox) {
  VesselRun run(world, tank_with_gravity({.min = "-1.2, -1.2, 0",
                                          .max = "1.2, 1.2, 2.4",
                                          .water = {{"-1.1, -1.1, 0.1", "1.1, 1.1, 1.1"}},
                                          .end = "8"}) +
                           R"([[obstacle]]
type = "box"
center = [0, 0, 1.2]
size = [1.2, 1.2, 1.6]
rotate = [0, 30, 0]
inside = true
)");
  run.steps(480);
  const Diagnostics& row = run.rows.back();
  const Real energy = row.kinetic_energy / (static_cast<Real>(row.particles) * water_mass(run.scene.fluid));
  if (rank_of(world) == 0) std::printf("kinetic energy %.2e m2/s2, centre of mass %.4f m\n", energy, row.com.z());
  EXPECT_EQ(row.particles, 972);
  EXPECT_LT(energy, 8e-4);
  EXPECT_NEAR(row.com.z(), 0.7737, 0.02);
  EXPECT_GT(run.nearest(), -1e-9);
}

// A block begins without gaps at solids that lie anyhow in it. Into those of half a spacing around them water fell with
// up to 0.87 m/s, and had 3.5e-3 m²/s² after a second.
TEST(Vessels, WaterBesideSolidsBeginsCalm) {
  VesselRun run(world, tank_with_gravity({.max = "2.4, 2.4, 1.6", .water = {{"0, 0, 0", "2.4, 2.4, 0.8"}}}) + R"(
[[obstacle]]
type = "sphere"
center = [0.78, 0.72, 0.47]
radius = 0.42
[[obstacle]]
type = "box"
center = [1.63, 1.5, 0.44]
size = [0.62, 0.8, 0.42]
rotate = [12, 19, 0]
)");
  Real fastest = 0;
  for (int k = 0; k < 60; ++k) {
    run.steps(1);
    fastest = std::max(fastest, run.rows.back().speed_max);
  }
  const Diagnostics& row = run.rows.back();
  const Real energy = row.kinetic_energy / (static_cast<Real>(row.particles) * water_mass(run.scene.fluid));
  if (rank_of(world) == 0) std::printf("kinetic energy %.2e m2/s2, fastest %.2f m/s\n", energy, fastest);
  EXPECT_LT(fastest, 0.5);
  EXPECT_LT(energy, 1e-3);
}

// Three layers whose lattice lies anyhow to the walls, the third in cells of air above those of the surface, and a heap
// on them: the water sloshes for long, as nothing damps waves, but its energy never grows.
TEST(Vessels, TopLayersInCellsOfAirCalm) {
  VesselRun run(
      world, tank_with_gravity({.max = "1.2, 1.2, 1",
                                .water = {{"0.03, 0.07, 0", "1.13, 1.17, 0.3"}, {"0.03, 0.37, 0.3", "1.13, 0.97, 0.4"}},
                                .end = "8"}));
  run.steps(480);
  Real early = 0, late = 0;
  for (std::size_t k = 0; k < run.rows.size(); ++k)
    (k < 120 ? early : late) = std::max(k < 120 || k > 360 ? run.rows[k].kinetic_energy : 0, k < 120 ? early : late);
  EXPECT_LT(late, 0.6 * early);
  for (const Diagnostics& row : run.rows)
    EXPECT_LE(row.kinetic_energy + row.potential_energy, 1.001 * run.rows.front().potential_energy);
}

struct Swing {
  Real time, far;
};

// The first extremes of the way of the centre of mass along x from where it will rest.
std::vector<Swing> swings_of(const VesselRun& run, Real middle) {
  std::vector<Swing> swings;
  for (std::size_t k = 1; k + 1 < run.rows.size(); ++k) {
    const Real before = run.rows[k - 1].com.x(), here = run.rows[k].com.x(), after = run.rows[k + 1].com.x();
    if ((here - before) * (after - here) <= 0 && (swings.empty() || (here - middle) * swings.back().far < 0))
      swings.push_back({static_cast<Real>(k) * run.scene.dt, here - middle});
  }
  return swings;
}

// The walls of the obstacle go through cells of the coarse grid, those of the box do not. As long as cells at upright
// walls counted as ones on the floor, the third swing was an eighth of that in the box, or two fifths. Six cells a
// length are few: with the walls between faces of cells a swing takes some 4 % longer.
TEST(Vessels, ATankMadeOfAnObstacleSloshesAsTheBox) {
  const auto tank = [](const char* box, const char* obstacle) {
    return std::string("[domain]\n") + box + R"(
[fluid]
spacing = 0.1
[[particles]]
min = [0, 0, 0]
max = [0.6, 1.2, 0.6]
[[particles]]
min = [0.6, 0, 0]
max = [1.2, 1.2, 0.5]
[time]
dt = 0.0166666666666666667
end = 3
[gravity]
)" + obstacle;
  };
  VesselRun box(world, tank("min = [0, 0, 0]\nmax = [1.2, 1.2, 1.2]", ""));
  box.steps(140);
  const std::vector<Swing> free = swings_of(box, 0.6);
  for (const char* around : {"min = [-0.333, -0.361, -0.351]\nmax = [1.467, 1.439, 1.449]",
                             "min = [-0.3, -0.3, -0.32]\nmax = [1.5, 1.5, 1.48]"}) {
    VesselRun vessel(world, tank(around,
                                 "[[obstacle]]\ntype = 'box'\ncenter = [0.6, 0.6, 0.6]\nsize = [1.2, 1.2, 1.2]\n"
                                 "inside = true\n"));
    vessel.steps(140);
    const std::vector<Swing> held = swings_of(vessel, 0.6);
    ASSERT_GE(std::min(free.size(), held.size()), 3U) << around;
    for (std::size_t k = 0; k < 3; ++k) {
      std::printf("swing %zu: %.3f s and %.3f of those in the box\n", k, held[k].time / free[k].time,
                  held[k].far / free[k].far);
      EXPECT_NEAR(held[k].time / free[k].time, 1, 0.06) << around << k;
      EXPECT_GT(held[k].far / free[k].far, 0.91) << around << k;
    }
  }
}

// Less than a spacing of air above the water, or a lid: with 1.0.0 4 to 25 J for ever.
TEST(Vessels, WaterUnderALidRests) {
  const auto scene = [](Real height, Real depth, const std::string& more) {
    return "[domain]\nmin = [0, 0, 0]\nmax = [1.2, 0.6, " + std::to_string(height) + "]\n[fluid]\nspacing = 0.1\n" +
           "[[particles]]\nmin = [0, 0, 0]\nmax = [1.2, 0.6, " + std::to_string(depth) +
           "]\n[time]\ndt = 0.016666666666666667\nend = 9\n[gravity]\n" + more;
  };
  const auto lid = [](Real gap) {
    return "[[obstacle]]\ntype = 'box'\ncenter = [0.6, 0.3, " + std::to_string(0.6 + gap) + "]\nsize = [2, 2, 0.2]\n";
  };
  const std::string away = "[[obstacle]]\ntype = 'sphere'\ncenter = [0.6, 0.3, 9]\nradius = 0.1\n";
  for (const std::string& text : {scene(0.5, 0.5, away), scene(0.52, 0.5, away), scene(0.58, 0.5, away),
                                  scene(1, 0.5, lid(0.005)), scene(1, 0.5, lid(0.02))}) {
    VesselRun run(world, text);
    run.steps(120);
    EXPECT_LT(run.rows.back().kinetic_energy, 1e-12 * run.rows.back().potential_energy) << text;
    EXPECT_LT(run.rows.back().compression_mean, 1e-6);
  }
}

// A block falls on a plate that touches no wall: the plate has all of the force, which 1.0.0 shared with the box.
TEST(Vessels, WhatTouchesAPlateAloneIsThePlates) {
  VesselRun run(
      world,
      "[domain]\nmin = [0, 0, 0]\nmax = [2, 2, 2]\n[fluid]\nspacing = 0.1\n[[particles]]\nmin = [0.7, 0.7, 1.05]\n"
      "max = [1.3, 1.3, 1.65]\nvelocity = [0, 0, -3]\n[time]\ndt = 0.00833333333333\nend = 9\n[gravity]\n"
      "[[obstacle]]\ntype = 'box'\ncenter = [1, 1, 0.9]\nsize = [1.4, 1.4, 0.2]\n");
  run.steps(15);
  Real largest = 0;
  for (const auto& forces : run.forces) {
    if (forces.size() < 2) continue;
    largest = std::max(largest, forces[0].force.norm());
    EXPECT_LT(forces[1].force.norm(), 1e-9 * (1 + forces[0].force.norm()));
  }
  EXPECT_GT(largest, 216 * 9.8) << "the block has met the plate";
}

}  // namespace
}  // namespace trevi::test
