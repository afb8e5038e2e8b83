// Paths of particles among obstacles, that nothing passes. See test_obstacle_leaks.cpp for leaks, and
// test_obstacle_meshes.cpp for meshes.
#include <gtest/gtest.h>

#include <cmath>

#include "some_obstacles.hpp"

namespace trevi::test {
namespace {

struct Tank {
  Settings settings;
  std::unique_ptr<Obstacles> obstacles;

  explicit Tank(std::vector<ObstacleSettings> solids) {
    settings.domain = {Vec3(-3, -3, -3), Vec3(3, 3, 3)};
    settings.fluid.spacing = spacing;
    settings.obstacles = std::move(solids);
    settings = resolved(settings);
    const Walls walls(settings.domain, settings.walls, 1e-6 * h);
    const AnalyticWallDensity law(settings.domain, kernel_named("spiky"), spacing, h, WallSlope::of_positions);
    obstacles = std::make_unique<Obstacles>(settings, walls, law);
  }
  Real distance(const Vec3& p) const {
    Real nearest = 1e300;
    for (std::size_t k = 0; k < obstacles->count(); ++k) {
      const Body& body = obstacles->body(k);
      nearest = std::min(nearest, body.shape().distance(body.now().into_body(p)));
    }
    return nearest;
  }
};

// A sheet of one spacing from wall to wall, 100 m/s: nobody is on the other side, by motion or by shift.
TEST(Paths, NoSpeedPassesASheet) {
  ObstacleSettings sheet = box({8, 8, spacing});
  sheet.rotate = {20, 10, 0};
  Tank tank({sheet});
  const Vec3 up = BodyMotion(sheet).at(0).turn.col(2);
  std::mt19937 generator(5);
  for (int k = 0; k < 20000; ++k) {
    Vec3 p = random_point(generator, 2.5);
    if (tank.distance(p) <= 0) continue;
    const Real side = p.dot(up) > 0 ? 1 : -1;
    const Vec3 end = tank.obstacles->predict(p, random_point(generator, 100), 1.0 / 60);
    EXPECT_GT(side * end.dot(up), spacing / 2 - 1e-9);
    const Vec3 shifted = tank.obstacles->collide(p, random_point(generator, 3));
    EXPECT_GT(side * shifted.dot(up), spacing / 2 - 1e-9);
    EXPECT_TRUE(tank.settings.domain.contains(end) && tank.settings.domain.contains(shifted));
  }
}

TEST(Paths, NobodyEntersAnyShape) {
  std::mt19937 generator(6);
  for (const ObstacleSettings& settings : shapes()) {
    for (const bool inside : {false, true}) {
      ObstacleSettings one = settings;
      one.inside = inside;
      one.rotate = {30, 40, 50};
      one.center = {0.1, -0.2, 0.3};
      Tank tank({one});
      for (int k = 0; k < 1500; ++k) {
        Vec3 p = random_point(generator, 1.5);
        if (tank.distance(p) <= 1e-3) continue;
        for (int step = 0; step < 5; ++step) {
          p = tank.obstacles->predict(p, random_point(generator, 50), 0.02);
          EXPECT_GT(tank.distance(p), -1e-9);
          p = tank.obstacles->collide(p, random_point(generator, 0.5));
          EXPECT_GT(tank.distance(p), -1e-9);
        }
      }
    }
  }
}

// Inside a smooth cylinder a path goes along the wall for any number of turns: bounces on shorter and shorter chords
// would never come round. What the wall gives has no torque about the axis but for the way to the first contact.
TEST(Paths, TurnOnAlongACurvedWall) {
  ObstacleSettings vessel = cylinder(0.5, 4);
  vessel.inside = true;
  for (const Real dt : {1.0 / 60, 1.0 / 240}) {
    Tank tank({vessel});
    Vec3 p(0.5 - 1e-6, 0, 0), v(0.3, 1.5, 0);  // presses on the wall, too
    const Real start = 0.5 * 1.5;
    for (int step = 0; step < 400; ++step) {
      const Vec3 end = tank.obstacles->predict(p, v, dt);
      v = (end - p) / dt;
      EXPECT_NEAR(p.x() * v.y() - p.y() * v.x(), start, 0.02 * start) << "1/" << 1 / dt << " s, step " << step;
      p = end;
      EXPECT_GT(tank.distance(p), 0);
    }
  }
}

// Where no obstacle is met the box alone acts, to the bit.
TEST(Paths, FarFromObstaclesOnlyTheBoxActs) {
  Tank tank({sphere(0.2)});
  const Walls walls(tank.settings.domain, tank.settings.walls, 1e-6 * h);
  std::mt19937 generator(7);
  for (int k = 0; k < 5000; ++k) {
    Vec3 p = Vec3(2, 2, 2) + random_point(generator, 0.9);
    const Vec3 v = random_point(generator, 40);
    EXPECT_EQ(tank.obstacles->predict(p, v, 1.0 / 60), walls.predict(p, v, 1.0 / 60));
    EXPECT_EQ(tank.obstacles->collide(p, v / 100), walls.collide(p, v / 100));
  }
}

// A ball that falls on a slope: restitution scales the normal part, friction takes from the other.
TEST(Paths, BounceHasRestitutionAndFriction) {
  for (const Real friction : {0.0, 0.25}) {
    ObstacleSettings slope = box({2, 2, 2});
    slope.rotate = {0, 30, 0};
    slope.restitution = 0.5;
    slope.friction = friction;
    Tank tank({slope});
    const Rotation turn = BodyMotion(slope).at(0).turn;
    Vec3 p = turn * Vec3(0, 0, 1.1);
    const Vec3 v = turn * Vec3(4, 0, -10);
    const Vec3 end = turn.transpose() * tank.obstacles->predict(p, v, 0.03);
    EXPECT_NEAR(end.z(), 1 + 0.5 * 10 * 0.02, 1e-5);
    EXPECT_NEAR(end.x(), 4 * 0.01 + (4 - friction * 1.5 * 10) * 0.02, 1e-5);
  }
}

// A wall that comes at 10 m/s takes along what it meets: with restitution 0 at its own speed.
TEST(Paths, MovingSolidTakesAlong) {
  ObstacleSettings piston = box({1, 2, 2});
  piston.center = {-1, 0, 0};
  piston.velocity = {10, 0, 0};
  piston.restitution = 0;
  Tank tank({piston});
  Vec3 p(0, 0.3, 0.2);
  for (int k = 0; k < 20; ++k) {
    tank.obstacles->move(0.01 * k, 0.01 * (k + 1));
    p = tank.obstacles->predict(p, Vec3::Zero(), 0.01);
    EXPECT_GT(tank.distance(p), 0);
  }
  EXPECT_NEAR(p.x(), -0.5 + 10 * 0.2, 1e-4);
  // What it has not met it leaves where it is, however often walls turn that back.
  Vec3 far(0.6, 2, 2);
  const Vec3 end = tank.obstacles->predict(far, Vec3(0, 1e9, 0), 0.01);
  EXPECT_LT((end - Vec3(0.6, 2, 2)).cwiseProduct(Vec3(1, 0, 1)).norm(), 1e-9);
}

// What a block presses against the ceiling ends in it, and goes out to its nearest side; that is not a motion.
TEST(Paths, WhatIsCrushedGetsNoVelocityByIt) {
  ObstacleSettings block = box({2, 2, 1});
  block.center = {0, 0, 2};
  block.velocity = {0, 0, 0.8};
  block.restitution = 0;
  Tank tank({block});
  constexpr Real dt = 0.02;
  Vec3 p(0.7, 0.3, 2.9), v = Vec3::Zero();
  Real furthest = 0;
  for (int k = 0; k < 60; ++k) {
    tank.obstacles->move(dt * k, dt * (k + 1));
    const Vec3 before = p, end = tank.obstacles->predict(p, v, dt);
    furthest = std::max(furthest, (p - before).norm());
    v = (end - p) / dt;
    EXPECT_LT(v.norm(), 0.8 + 1e-3) << "step " << k;
    p = end;
  }
  EXPECT_GT(furthest, 0.25) << "out through the block's side";
  EXPECT_GT(p.x(), 1);
}

// What is taken is what paths were changed by.
TEST(Paths, TollIsTheChange) {
  ObstacleSettings ball = sphere(0.8), block = box({0.5, 0.5, 0.5});
  block.center = {1.5, 0, 0};
  block.velocity = {-5, 0, 3};
  Tank tank({ball, block});
  tank.obstacles->move(0, 0.05);
  std::mt19937 generator(8);
  Vec3 changed = Vec3::Zero();
  for (int k = 0; k < 3000; ++k) {
    Vec3 p = random_point(generator, 2.9);
    const Vec3 v = random_point(generator, 60), shift = random_point(generator, 0.4);
    if (tank.distance(p) <= 0.3) continue;
    const Vec3 end = tank.obstacles->predict(p, v, 0.05);
    changed += end - (p + 0.05 * v);
    changed += tank.obstacles->collide(end, shift) - (end + shift);
  }
  Vec3 taken = Vec3::Zero();
  for (const TotalImpulse& one : tank.obstacles->total(MPI_COMM_SELF)) taken += one.shift;
  EXPECT_LT((taken - changed).norm(), 1e-7 * changed.norm());
  EXPECT_GT(changed.norm(), 1);
}

// What is over acts on the line of the rest of a force; that of a couple, as of friction on what turns, is far away.
TEST(Paths, WhatIsOverGivesACoupleNoOtherMoment) {
  Tank tank({sphere(0.8)});
  tank.obstacles->begin_step();
  const Vec3 up(0, 0, 0.4), push(0, 1e-3, 0), over(1e-6, 2e-6, -1e-6);
  tank.obstacles->record_projection(0, push, up);
  tank.obstacles->record_projection(0, Vec3(0.1 * over - push), -up);
  tank.obstacles->record_projection(tank.obstacles->rest_account(), over, Vec3::Zero());
  const TotalImpulse found = tank.obstacles->total(MPI_COMM_SELF).front();
  EXPECT_LT((found.shift - 1.1 * over).norm(), 1e-9);
  EXPECT_LT((found.moment - 2 * up.cross(push)).norm(), 1e-3 * found.moment.norm());
}

// In the open nobody has a share of an obstacle, or meets one.
TEST(Paths, NothingIsMetInTheOpen) {
  const Tank tank({cylinder(0.4, 0.8)});
  std::mt19937 generator(9);
  for (int ways = 0; ways < 2000;) {
    const std::array<Vec3, 2> p{random_point(generator, 2.9), random_point(generator, 2.9)};
    const OpenSpace open = tank.obstacles->open_space(p, Extent::density);
    if (!open.contains(p[0], p[1])) continue;
    EXPECT_FALSE(tank.obstacles->is_near(p[0]));
    EXPECT_EQ(tank.obstacles->collide(p[0], p[1] - p[0]), p[0] + (p[1] - p[0]));
    ++ways;
  }
}

}  // namespace
}  // namespace trevi::test
