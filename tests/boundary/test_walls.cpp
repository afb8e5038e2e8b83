// Algorithm 3: bounces that can be worked out by hand, and random ones that must stay in the box.
#include <gtest/gtest.h>

#include <random>

#include "boundary/walls.hpp"

namespace trevi {
namespace {

const Box tank{Vec3(0, 0, 0), Vec3(1, 2, 4)};
constexpr Real hair = 1e-6;

Walls walls(Real restitution, Reflection reflection) {
  return Walls(tank, {restitution, WallDensity::none, reflection}, hair);
}

void expect_near(const Vec3& found, const Vec3& expected) {
  EXPECT_LT((found - expected).norm(), 1e-14 * (1 + expected.norm()))
      << found.transpose() << " is not " << expected.transpose();
}

TEST(Walls, FreeFlightIsUntouched) {
  const Vec3 p(0.25, 0.5, 1), v(1, -2, 4);
  for (const Reflection reflection : {Reflection::normal, Reflection::report})
    EXPECT_EQ(walls(0.5, reflection).predict(p, v, 0.125), p + v * 0.125);
}

// From z = 0.5 at −4 m/s the floor is met after 1/8 s; 1/8 s remain at 2 m/s upwards.
TEST(Walls, LoneParticleBouncesExactly) {
  const Vec3 p(0.5, 1, 0.5), v(0.5, 1, -4);
  expect_near(walls(0.5, Reflection::normal).predict(p, v, 0.25), Vec3(0.625, 1.25, 0.25));
  expect_near(walls(0.5, Reflection::report).predict(p, v, 0.25), Vec3(0.59375, 1.1875, 0.25));
  expect_near(walls(1, Reflection::normal).predict(p, v, 0.25), Vec3(0.625, 1.25, 0.5));
  expect_near(walls(1, Reflection::report).predict(p, v, 0.25), Vec3(0.625, 1.25, 0.5));
}

// Without restitution the normal component is lost; the report's reading is a sticky wall.
TEST(Walls, RestitutionZero) {
  const Vec3 p(0.5, 1, 0.5), v(0.5, 1, -4);
  expect_near(walls(0, Reflection::normal).predict(p, v, 0.25), Vec3(0.625, 1.25, 0));
  expect_near(walls(0, Reflection::report).predict(p, v, 0.25), Vec3(0.5625, 1.125, 0));
}

TEST(Walls, EveryWallIsMet) {
  for (int a = 0; a < 3; ++a) {
    for (const int side : {-1, 1}) {
      Vec3 p = (tank.min + tank.max) / 2, expected = p;
      const Real plane = side > 0 ? tank.max[a] : tank.min[a];
      p[a] = plane - side * 0.25;
      expected[a] = plane - side * 0.125;
      expect_near(walls(0.5, Reflection::normal).predict(p, side * 2 * Vec3::Unit(a), 0.25), expected);
    }
  }
}

// Both walls of an edge are met at once after 1/8 s: both components turn round, the report's are damped twice.
TEST(Walls, Corner) {
  const Vec3 p(0.25, 0.25, 1), v(-2, -2, 0);
  expect_near(walls(0.5, Reflection::normal).predict(p, v, 0.25), Vec3(0.125, 0.125, 1));
  expect_near(walls(0.5, Reflection::report).predict(p, v, 0.25), Vec3(0.0625, 0.0625, 1));
}

// 0.25 m to the first wall, then 1 m between walls: at full restitution 3.5 m end 0.75 m after the third bounce.
TEST(Walls, SeveralBounces) {
  expect_near(walls(1, Reflection::normal).predict(Vec3(0.75, 1, 1), Vec3(14, 0, 0), 0.25), Vec3(0.25, 1, 1));
  // With one half: 0.25 m in 1/32 s at 8 m/s, 1 m in 1/4 s at 4 m/s, then 2 m/s.
  expect_near(walls(0.5, Reflection::normal).predict(Vec3(0.75, 1, 1), Vec3(8, 0, 0), 0.3125), Vec3(0.0625, 1, 1));
}

TEST(Walls, ParticleOnTheWallLeavesIt) {
  expect_near(walls(0.5, Reflection::normal).predict(Vec3(0, 1, 1), Vec3(2, 0, 0), 0.25), Vec3(0.5, 1, 1));
  expect_near(walls(0.5, Reflection::normal).predict(Vec3(0, 1, 1), Vec3(-2, 0, 0), 0.25), Vec3(0.25, 1, 1));
}

TEST(Walls, ShiftIsClampedPerAxis) {
  const Walls w = walls(0.5, Reflection::normal);
  expect_near(w.collide(Vec3(0.5, 1, 1), Vec3(0.25, -0.5, 0.5)), Vec3(0.75, 0.5, 1.5));
  expect_near(w.collide(Vec3(0.5, 1, 1), Vec3(1, 0.5, -2)), Vec3(1, 1.5, 0));
}

// The first plane along the ray is the floor, half way; a hair inside of it.
TEST(Walls, ShiftOfTheReportStopsOnTheRay) {
  const Walls w = walls(0.5, Reflection::report);
  expect_near(w.collide(Vec3(0.5, 1, 1), Vec3(0.25, -0.5, 0.5)), Vec3(0.75, 0.5, 1.5));
  expect_near(w.collide(Vec3(0.5, 1, 1), Vec3(0.4, 0.5, -2)), Vec3(0.7, 1.25, hair));
  expect_near(w.collide(Vec3(0.5, 1, 1), Vec3(1, 0.5, -0.5)), Vec3(1 - hair, 1.25, 0.75));
}

// Any place in the closed box, its planes and corners included, and any speed up to 1e9 m/s.
TEST(Walls, NothingLeavesTheBox) {
  std::mt19937_64 random(4);
  std::uniform_real_distribution<Real> number(-1, 1);
  for (int k = 0; k < 4000; ++k) {
    Vec3 p, v;
    for (int a = 0; a < 3; ++a) {
      p[a] = std::clamp(0.75 * (number(random) + 1) - 0.25, 0.0, 1.0) * tank.max[a];  // a third on the walls
      v[a] = number(random) * std::pow(10, 9 * number(random));
    }
    for (const Reflection reflection : {Reflection::normal, Reflection::report}) {
      for (const Real restitution : {0.0, 0.5, 1.0}) {
        const Walls w = walls(restitution, reflection);
        const Vec3 flown = w.predict(p, v, 1.0 / 60), pushed = w.collide(p, v);
        ASSERT_TRUE(w.inside(flown)) << p.transpose() << " at " << v.transpose() << " to " << flown.transpose();
        ASSERT_TRUE(w.inside(pushed)) << p.transpose() << " by " << v.transpose() << " to " << pushed.transpose();
      }
    }
  }
}

}  // namespace
}  // namespace trevi
