// Poses and motions of obstacles against their definitions.
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <cmath>
#include <numbers>

#include "boundary/geometry/pose.hpp"

namespace trevi {
namespace {

ObstacleSettings box(const Vec3& size) {
  ObstacleSettings settings;
  settings.shape = ShapeKind::box;
  settings.size = size;
  return settings;
}

TEST(Pose, TurnsAreThoseOfTheLibraryToRounding) {
  for (Real turns = -3; turns < 3; turns += 0.0137) {
    const auto [s, c] = sine_cosine_of_turns(turns);
    EXPECT_NEAR(s, std::sin(2 * std::numbers::pi * turns), 4e-15);
    EXPECT_NEAR(c, std::cos(2 * std::numbers::pi * turns), 4e-15);
  }
  EXPECT_EQ(sine_cosine_of_turns(0.25).sine, 1);
  EXPECT_EQ(sine_cosine_of_turns(0.25).cosine, 0);
  EXPECT_EQ(sine_cosine_of_turns(-1.5).cosine, -1);
}

TEST(Pose, MidwayIsHalfOfTheWayAndOfTheTurn) {
  ObstacleSettings settings = box({1, 1, 1});
  settings.velocity = {1, -2, 3};
  settings.angular_velocity = {0.4, 1.3, -0.7};
  const BodyMotion motion(settings);
  for (const Real time : {0.0, 0.01, 0.3, 1.1, 1.9}) {  // s; at the last it has turned by 2.91
    const Pose found = midway_between(motion.at(0), motion.at(time)), exact = motion.at(time / 2);
    EXPECT_LT((found.center - exact.center).norm(), 1e-15);
    EXPECT_LT((found.turn - exact.turn).norm(), 1e-14) << time;
  }
  settings.rotate = {12, 34, 56};
  const Pose start = BodyMotion(settings).at(0);
  EXPECT_EQ(midway_between(start, start).turn, start.turn);
}

TEST(Pose, RotateTurnsAboutXThenYThenZ) {
  ObstacleSettings settings = box({1, 1, 1});
  settings.center = {1, 2, 3};
  settings.rotate = {90, 0, 90};
  const Pose pose = BodyMotion(settings).at(0);
  EXPECT_LT((pose.into_world({0, 1, 0}) - Vec3(1, 2, 4)).norm(), 1e-15);  // y to z, and z stays
  EXPECT_LT((pose.into_world({1, 0, 0}) - Vec3(1, 3, 3)).norm(), 1e-15);  // x stays, and x to y
  EXPECT_LT((pose.into_body(pose.into_world({0.3, 0.2, 0.1})) - Vec3(0.3, 0.2, 0.1)).norm(), 1e-15);
}

TEST(Pose, AxisIsWhereZGoes) {
  for (const Vec3& axis : {Vec3(1, 0, 0), Vec3(0, 0, -2), Vec3(1, -2, 3)}) {
    ObstacleSettings settings = box({1, 1, 1});
    settings.axis = axis;
    const Rotation turn = BodyMotion(settings).at(0).turn;
    EXPECT_LT((turn.col(2) - axis.normalized()).norm(), 1e-15);
    EXPECT_NEAR(turn.determinant(), 1, 1e-14);
    EXPECT_LT((turn * turn.transpose() - Rotation::Identity()).norm(), 1e-14);
  }
}

TEST(Pose, SineIsThatOfTheFormula) {
  ObstacleSettings settings = box({1, 1, 1});
  settings.center = {1, 2, 3};
  settings.oscillation = Oscillation{{0.3, 0, -0.1}, {0, 90, 0}, 0.8, 2};
  const BodyMotion motion(settings);
  EXPECT_TRUE(settings.moves());
  for (Real t = 0; t < 5; t += 0.0137) {
    const Real u = std::min(t / 2, 1.0), f = u * u * (3 - 2 * u) * std::sin(2 * std::numbers::pi * t / 0.8);
    const Real angle = f * std::numbers::pi / 2;
    const Pose pose = motion.at(t);
    EXPECT_LT((pose.center - Vec3(1, 2, 3) - f * Vec3(0.3, 0, -0.1)).norm(), 1e-14);
    EXPECT_LT((pose.turn.col(0) - Vec3(std::cos(angle), 0, -std::sin(angle))).norm(), 1e-14);
    const Vec3 corner(0.5, 0.5, 0.5);
    const Real speed = (motion.at(t + 1e-6).into_world(corner) - pose.into_world(corner)).norm() / 1e-6;
    EXPECT_LE(speed, motion.fastest(t, t + 1e-6, corner.norm()) * (1 + 1e-6));
  }
  EXPECT_EQ(motion.at(0).center, settings.center);
}

// Of translation and rotation with constant rates, and where a sine turns. The motion by h is short.
TEST(Pose, AccelerationIsThatOfTheFormula) {
  const Real h = 0.02, dt = 0.001, t = 1;
  ObstacleSettings moving = box({1, 1, 1});
  moving.velocity = {3, 0, 1};
  EXPECT_NEAR(BodyMotion(moving).acceleration(t, t + dt, 0.9, h), 0, 1e-6);
  ObstacleSettings turning = box({1, 1, 1});
  turning.angular_velocity = {0, 4, 0};
  EXPECT_NEAR(BodyMotion(turning).acceleration(t, t + dt, 0.9, h), 16 * 0.9, 0.05);
  ObstacleSettings swinging = box({1, 1, 1});
  swinging.oscillation = Oscillation{{0.3, 0, 0}, {0, 0, 0}, 0.8, 0};
  const Real rate = 2 * std::numbers::pi / 0.8;
  EXPECT_NEAR(BodyMotion(swinging).acceleration(t, t + dt, 0.9, h), 0.3 * rate * rate, 0.05);
}

TEST(Pose, TableIsMetAtItsTimesWithoutAKink) {
  ObstacleSettings settings = box({1, 1, 1});
  settings.knots = {{0, {0, 0, 0}}, {1, {1, 0, 0}}, {1.5, {1, 2, 0}}, {4, {0, 0, 1}}};
  const BodyMotion motion(settings);
  for (const ObstacleKnot& knot : settings.knots) EXPECT_LT((motion.at(knot.time).center - knot.center).norm(), 1e-15);
  for (Real t = -0.5; t < 5; t += 0.01) {
    const auto velocity = [&](Real at) {
      return Vec3((motion.at(at + 1e-6).center - motion.at(at - 1e-6).center) / 2e-6);
    };
    EXPECT_LT((velocity(t) - velocity(t + 1e-5)).norm(), 2e-3);
    EXPECT_LE(velocity(t).norm(), motion.fastest(t - 0.01, t + 0.01, 0) + 0.1);
  }
  EXPECT_EQ(motion.at(9).center, settings.knots.back().center);
}

}  // namespace
}  // namespace trevi
