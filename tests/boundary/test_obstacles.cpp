// Shapes against definitions; what a solid is to the density against brute quadrature; paths that nothing
// passes. See test_obstacle_meshes.cpp for meshes.
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <cmath>
#include <numbers>
#include <random>

#include "boundary/obstacles/obstacles.hpp"

namespace trevi {
namespace {

constexpr Real spacing = 0.1, h = 0.2;

ObstacleSettings of(ShapeKind shape, Real radius, Real height = 0) {
  ObstacleSettings settings;
  settings.shape = shape;
  settings.radius = radius;
  settings.height = height;
  return settings;
}
ObstacleSettings sphere(Real radius) { return of(ShapeKind::sphere, radius); }
ObstacleSettings cylinder(Real radius, Real height) { return of(ShapeKind::cylinder, radius, height); }
ObstacleSettings capsule(Real radius, Real height) { return of(ShapeKind::capsule, radius, height); }
ObstacleSettings box(const Vec3& size) {
  ObstacleSettings settings;
  settings.shape = ShapeKind::box;
  settings.size = size;
  return settings;
}
ObstacleSettings torus(Real radius, Real tube) {
  ObstacleSettings settings = of(ShapeKind::torus, radius);
  settings.tube = tube;
  return settings;
}
ObstacleSettings basin(ObstacleSettings space, Real wall) {
  space.shape = ShapeKind::basin;
  space.wall = wall;
  return space;
}
std::vector<ObstacleSettings> shapes() {
  return {sphere(0.5),
          box({0.7, 0.4, 0.9}),
          cylinder(0.4, 0.8),
          capsule(0.3, 1.1),
          torus(0.5, 0.2),
          basin(cylinder(0.5, 0.8), 0.15),
          basin(box({0.7, 0.5, 0.6}), 0.2)};
}

Vec3 random_point(std::mt19937& generator, Real reach) {
  std::uniform_real_distribution<Real> number(-reach, reach);
  return {number(generator), number(generator), number(generator)};  // in this order, by the braces
}

// A distance to a set has slope 1 nearly everywhere and nowhere more; and one step along it ends on the surface.
TEST(Shape, DistanceIsThatToTheSurface) {
  std::mt19937 generator(1);
  for (const ObstacleSettings& settings : shapes()) {
    const auto shape = make_shape(settings);
    for (int k = 0; k < 2000; ++k) {
      const Vec3 p = random_point(generator, 1.2), q = random_point(generator, 1.2);
      EXPECT_LE(std::abs(shape->distance(p) - shape->distance(q)), (p - q).norm() * (1 + 1e-12));
      const Real d = shape->distance(p);
      if (d < 0.01) continue;
      EXPECT_NEAR(shape->distance(p - d * shape->normal(p)), 0, 1e-5);
    }
  }
}

TEST(Shape, VolumeIsThatOfTheFormula) {
  const Real pi = std::numbers::pi;
  const std::vector<Real> volumes = {pi * 0.125 * 4 / 3,
                                     0.7 * 0.4 * 0.9,
                                     pi * 0.16 * 0.8,
                                     pi * 0.09 * 0.5 + pi * 0.027 * 4 / 3,
                                     2 * pi * pi * 0.5 * 0.04,
                                     pi * (0.65 * 0.65 * 0.95 - 0.25 * 0.8),
                                     1.1 * 0.9 * 0.8 - 0.7 * 0.5 * 0.6};
  for (std::size_t s = 0; s < volumes.size(); ++s) {
    const auto shape = make_shape(shapes()[s]);
    const Box bounds = shape->bounds();
    constexpr int n = 80;
    const Vec3 step = (bounds.max - bounds.min) / n;
    int inside = 0;
    for (int k = 0; k < n * n * n; ++k) {
      const Vec3 p = bounds.min + step.cwiseProduct(Vec3(k % n + 0.5, k / n % n + 0.5, k / n / n + 0.5));
      inside += shape->distance(p) < 0 ? 1 : 0;
    }
    EXPECT_NEAR(inside * step.prod() / volumes[s], 1, 0.01) << s;
  }
}

// The surface that is drawn: on the surface, and its triangles enclose the volume (divergence theorem), so that they
// face outwards.
TEST(Shape, DrawnSurfaceIsTheSurface) {
  for (const ObstacleSettings& settings : shapes()) {
    const auto shape = make_shape(settings);
    const TriangleMesh mesh = shape->surface(0.001);
    Real volume = 0;
    for (const auto& t : mesh.triangles) {
      const auto corner = [&](std::size_t k) { return mesh.points[static_cast<std::size_t>(t[k])]; };
      volume += corner(0).dot(corner(1).cross(corner(2))) / 6;
    }
    for (const Vec3& p : mesh.points) EXPECT_NEAR(shape->distance(p), 0, 1e-9);
    EXPECT_GT(volume, 0.1);
  }
}

const Kernel& kernel() { return kernel_named("spiky"); }

/// The share of the kernel's ball around p that is solid, by 160³ points.
template <class Solid>
Real quadrature(const Vec3& p, const Solid& is_solid) {
  constexpr int n = 80;
  Real inside = 0, all = 0;
  for (int x = -n; x < n; ++x)
    for (int y = -n; y < n; ++y)
      for (int z = -n; z < n; ++z) {
        const Vec3 r = h / n * Vec3(x + 0.5, y + 0.5, z + 0.5);
        const Real w = kernel().value(r, h);
        all += w;
        if (w > 0 && is_solid(p + r)) inside += w;
      }
  return inside / all;
}

struct Solid {
  std::string name;
  ObstacleSettings settings;
  Vec3 from, to;  // a way of test points, in the frame of the body
};

std::vector<Solid> solids() {
  ObstacleSettings ball = sphere(2 * h), vessel = sphere(2 * h);
  vessel.inside = true;
  return {{"plane", box({2, 2, 2}), {0.1, 0.2, 1 + h}, {0.13, 0.22, 1}},
          {"edge", box({2, 2, 2}), {1 + 0.7 * h, 0.1, 1 + 0.7 * h}, {1, 0.1, 1}},
          {"ball", ball, {0.1, 0.2, 3 * h}, {0.1, 0.05, 1.97 * h}},
          {"vessel", vessel, {0.1, 0.2, 0.5 * h}, {0.1, 0.05, 1.9 * h}},
          {"plate", box({2, 2, 0.25 * spacing}), {0.1, 0.2, h}, {0.1, 0.1, 0.126 * spacing}},
          {"thick plate", box({2, 2, spacing}), {0.1, 0.2, h}, {0.1, 0.1, 0.51 * spacing}},
          {"rim", box({2, 2, 0.5 * spacing}), {1 + h, 0.2, 0.5 * h}, {1, 0.1, 0}}};
}

// The share that the map stands for: within 2 % of the whole ball, for all of them.
TEST(VolumeMap, IsTheVolumeShareOfBruteQuadrature) {
  const PlaneVolume plane(kernel(), h);
  for (const Solid& solid : solids()) {
    const auto shape = make_shape(solid.settings);
    const VolumeMap map(*shape, kernel(), h, {});
    Real worst = 0;
    constexpr int points = 7;
    for (int k = 0; k <= points; ++k) {
      const Vec3 p = solid.from + (solid.to - solid.from) * k / points;
      const Real exact = quadrature(p, [&](const Vec3& q) { return shape->distance(q) < 0; });
      worst = std::max(worst, std::abs(plane.fraction(map.at(p).distance) - exact));
    }
    RecordProperty(solid.name, std::to_string(worst));
    std::printf("%-12s %.4f\n", solid.name.c_str(), worst);
    EXPECT_LT(worst, 0.02) << solid.name;
  }
}

// At any angle, to a thousandth of h.
TEST(VolumeMap, PlaneIsItsDistance) {
  std::mt19937 generator(3);
  const auto shape = make_shape(box({4, 4, 4}));
  for (int turn = 0; turn < 20; ++turn) {
    ObstacleSettings settings = box({4, 4, 4});
    settings.rotate = 180 * random_point(generator, 1);
    const Pose pose = BodyMotion(settings).at(0);
    const VolumeMap map(*shape, kernel(), h, {});
    for (int k = 0; k < 20; ++k) {
      const Vec3 p = random_point(generator, 1);
      const Real d = 0.5 * h * (1 + p.z());
      const EquivalentPlane at = map.at(Vec3(p.x(), p.y(), 2 + d));
      EXPECT_NEAR(at.distance, d, 2e-3 * h);
      EXPECT_NEAR(at.gradient.z(), 1, 0.02);
    }
    EXPECT_NEAR(pose.turn.determinant(), 1, 1e-14);
  }
}

TEST(VolumeMap, GradientIsTheDerivative) {
  std::mt19937 generator(4);
  for (const Solid& solid : solids()) {
    const auto shape = make_shape(solid.settings);
    const VolumeMap map(*shape, kernel(), h, {});
    for (int k = 0; k < 300; ++k) {
      const Vec3 p = solid.to + random_point(generator, h);
      for (int a = 0; a < 3; ++a) {
        const Vec3 step = 1e-6 * h * Vec3::Unit(a);
        const Real slope = (map.at(p + step).distance - map.at(p - step).distance) / (2e-6 * h);
        EXPECT_NEAR(map.at(p).gradient[a], slope, 1e-4) << solid.name;
      }
    }
  }
}

// A solid on the floor, or cut by a wall, is felt as if it went on behind the wall.
TEST(VolumeMap, StandingSolidGoesOnBehindTheWalls) {
  ObstacleSettings settings = box({2, 2, 1});
  settings.center = {0, 0, 0.5};
  const Pose pose = BodyMotion(settings).at(0);
  const auto shape = make_shape(settings);
  const VolumeMap map(*shape, kernel(), h, Fixed{pose, {{-3, -3, 0}, {3, 3, 3}}});
  const EquivalentPlane low = map.at(pose.into_body({1 + h / 4, 0.1, 0.01})),
                        high = map.at(pose.into_body({1 + h / 4, 0.1, 0.5}));
  EXPECT_NEAR(low.distance, high.distance, 1e-6);
}

// ---- paths
// -----------------------------------------------------------------------------------------------------------

struct Tank {
  Settings settings;
  std::unique_ptr<Obstacles> obstacles;

  explicit Tank(std::vector<ObstacleSettings> solids) {
    settings.domain = {Vec3(-3, -3, -3), Vec3(3, 3, 3)};
    settings.fluid.spacing = spacing;
    settings.obstacles = std::move(solids);
    settings = resolved(settings);
    const Walls walls(settings.domain, settings.walls, 1e-6 * h);
    const AnalyticWallDensity law(settings.domain, kernel(), spacing, h, WallSlope::of_positions);
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
    const Vec3 p = Vec3(2, 2, 2) + random_point(generator, 0.9), v = random_point(generator, 40);
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
    const Vec3 p = turn * Vec3(0, 0, 1.1), v = turn * Vec3(4, 0, -10);
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
  const Vec3 far(0.6, 2, 2), end = tank.obstacles->predict(far, Vec3(0, 1e9, 0), 0.01);
  EXPECT_LT((end - far).cwiseProduct(Vec3(1, 0, 1)).norm(), 1e-9);
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
    const Vec3 p = random_point(generator, 2.9), v = random_point(generator, 60), shift = random_point(generator, 0.4);
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
}  // namespace trevi
