// Nobody passes what is closed: sheets that end at the walls of the box, obstacles that meet each other and the walls,
// vessels that walls cut, at any speed and from any place, those on the surfaces themselves first.
#include <gtest/gtest.h>

#include <functional>
#include <random>

#include "boundary/geometry/tessellation.hpp"
#include "boundary/obstacles/obstacles.hpp"

namespace trevi {
namespace {

constexpr Real spacing = 0.1, h = 0.2;
const Box tank{Vec3(0, 0, 0), Vec3(1.6, 0.8, 1.2)};

ObstacleSettings box(const Vec3& center, const Vec3& size, const Vec3& rotate = Vec3::Zero()) {
  ObstacleSettings settings;
  settings.shape = ShapeKind::box;
  settings.center = center;
  settings.size = size;
  settings.rotate = rotate;
  return settings;
}

ObstacleSettings round(ShapeKind shape, const Vec3& center, Real radius) {
  ObstacleSettings settings;
  settings.shape = shape;
  settings.center = center;
  settings.radius = radius;
  settings.tube = radius / 3;
  settings.inside = true;
  return settings;
}

/// The same as a mesh.
ObstacleSettings mesh_of(ObstacleSettings settings) {
  TriangleMesh all = make_shape(settings)->surface(0.01), joined;
  std::vector<std::int32_t> number;
  for (const Vec3& p : all.points) {
    const auto same =
        std::find_if(joined.points.begin(), joined.points.end(), [&](const Vec3& q) { return (p - q).norm() < 1e-9; });
    number.push_back(static_cast<std::int32_t>(same - joined.points.begin()));
    if (same == joined.points.end()) joined.points.push_back(p);
  }
  for (auto t : all.triangles) {
    for (auto& corner : t) corner = number[static_cast<std::size_t>(corner)];
    if (t[0] != t[1] && t[1] != t[2] && t[2] != t[0]) joined.triangles.push_back(t);
  }
  settings.shape = ShapeKind::mesh;
  settings.mesh = std::make_shared<const TriangleMesh>(std::move(joined));
  return settings;
}

struct Case {
  const char* name;
  std::vector<ObstacleSettings> obstacles;
  std::function<Real(const Vec3&)> room;  // positive where particles are that are to stay there, by how much, m
};

std::vector<Case> cases() {
  const auto left_of = [](Real x) { return [x](const Vec3& p) { return x - p.x(); }; };
  const auto below = [](Real z) { return [z](const Vec3& p) { return z - p.z(); }; };
  const auto corner = [](const Vec3& p) { return std::min(0.75 - p.x(), 0.55 - p.z()); };
  const Vec3 middle(0.8, 0.4, 0.6);
  const Rotation turn = BodyMotion(box(middle, {1, 1, 1}, {0, 30, 0})).at(0).turn;
  const auto beside = [=](const Vec3& p) { return -(p - middle).dot(turn.col(0)) - spacing / 2; };
  const ObstacleSettings sheet = box(middle, {spacing, 0.8, 1.2});
  const ObstacleSettings ball = round(ShapeKind::sphere, {0.8, 0.1, 0.5}, 0.5);
  const auto in_ball = [](const Vec3& p) { return 0.5 - (p - Vec3(0.8, 0.1, 0.5)).norm(); };
  const auto in_ring = [](const Vec3& p) {
    return 0.1 - Vec3((p - Vec3(0.8, 0.4, 0.1)).head<2>().norm() - 0.3, p.z() - 0.1, 0).norm();
  };
  return {
      {"sheet", {sheet}, left_of(0.75)},
      {"sheet, a mesh", {mesh_of(sheet)}, left_of(0.75)},
      {"sheet, a rounding error too short", {box(middle, {spacing, 0.8 - 1e-12, 1.2 - 1e-12})}, left_of(0.75)},
      {"thin sheet", {box(middle, {spacing / 10, 0.8, 1.2})}, left_of(0.795)},
      {"floor", {box(middle, {1.6, 0.8, spacing})}, below(0.55)},
      {"two halves",
       {box({0.8, 0.2, 0.6}, {spacing, 0.4, 1.2}), box({0.8, 0.6, 0.6}, {spacing, 0.4, 1.2})},
       left_of(0.75)},
      {"two halves, meshes",
       {mesh_of(box({0.8, 0.2, 0.6}, {spacing, 0.4, 1.2})), mesh_of(box({0.8, 0.6, 0.6}, {spacing, 0.4, 1.2}))},
       left_of(0.75)},
      {"corner of two",
       {box({0.8, 0.4, 0.3}, {spacing, 0.8, 0.6}), box({0.375, 0.4, 0.6}, {0.75, 0.8, spacing})},
       corner},
      {"two that share an edge",
       {box({0.85, 0.4, 0.3}, {0.2, 0.8, 0.6}), box({0.375, 0.4, 0.65}, {0.75, 0.8, 0.1})},
       [](const Vec3& p) { return std::min(0.75 - p.x(), 0.6 - p.z()); }},
      {"turned sheet", {box(middle, {spacing, 0.8, 3}, {0, 30, 0})}, beside},
      {"turned sheet, a mesh", {mesh_of(box(middle, {spacing, 0.8, 3}, {0, 30, 0}))}, beside},
      {"ball that a wall cuts", {ball}, in_ball},
      {"ring on the floor", {round(ShapeKind::torus, {0.8, 0.4, 0.1}, 0.3)}, in_ring},
  };
}

std::unique_ptr<Obstacles> obstacles_of(const Case& one) {
  Settings settings;
  settings.domain = tank;
  settings.fluid.spacing = spacing;
  settings.obstacles = one.obstacles;
  settings = resolved(settings);
  return std::make_unique<Obstacles>(settings, Walls(tank, settings.walls, 1e-6 * h), std::nullopt);
}

class Thrower {
 public:
  explicit Thrower(unsigned seed) : generator_(seed) {}
  Real number(Real low, Real high) { return std::uniform_real_distribution<Real>(low, high)(generator_); }
  /// In the tank, often on one of its walls.
  Vec3 place() {
    Vec3 p;
    for (int a = 0; a < 3; ++a) {
      p[a] = number(-0.3, 1.3);
      p[a] = tank.min[a] + std::clamp(p[a], 0.0, 1.0) * (tank.max[a] - tank.min[a]);
    }
    return p;
  }
  /// Up to that, of all sizes, often along an axis or a plane of the box.
  Vec3 way(Real most) {
    Vec3 v;
    const Real size = most * std::pow(10, -number(0, 6));
    for (int a = 0; a < 3; ++a) v[a] = number(0, 1) < 0.3 ? 0.0 : number(-size, size);
    return v;
  }

 private:
  std::mt19937 generator_;
};

// To and fro ten times a second, at up to 7 m/s: a piston that fits the box sweeps it, a ball takes along what it
// holds.
TEST(Leaks, NobodyPassesWhatMoves) {
  constexpr int particles = 60, steps = 60;
  constexpr Real dt = 1.0 / 60;
  ObstacleSettings piston = box({0.4, 0.4, 0.6}, {spacing, 0.8, 1.2}),
                   ball = round(ShapeKind::sphere, {0.5, 0.4, 0.6}, 0.35);
  for (int k = 0; k <= 80; ++k) {
    const Real t = k / 80.0;
    const Real phase = t * 10 - std::floor(t * 10), swing = 0.25 * (1 - 16 * phase * phase * (1 - phase) * (1 - phase));
    piston.knots.push_back({t, Vec3(0.8 + swing, 0.4, 0.6)});
    ball.knots.push_back({t, Vec3(0.8 + swing, 0.4, 0.6)});
  }
  for (const ObstacleSettings& one : {piston, mesh_of(piston), ball}) {
    const auto obstacles = obstacles_of({"", {one}, {}});
    const BodyMotion motion(one);
    const auto room = [&](const Vec3& p, Real t) {
      const Vec3 in_body = p - motion.at(t).center;
      return one.inside ? 0.35 - in_body.norm() : -spacing / 2 - in_body.x();
    };
    Thrower thrower(8);
    for (int k = 0; k < particles; ++k) {
      Vec3 p = thrower.place();
      if (room(p, 0) < 1e-9) continue;
      for (int step = 0; step < steps; ++step) {
        obstacles->move(dt * step, dt * (step + 1));
        p = obstacles->predict(p, thrower.way(100), dt);
        for (int sweep = 0; sweep < 2; ++sweep) p = obstacles->collide(p, thrower.way(0.3));
        ASSERT_GT(room(p, dt * (step + 1)), -1e-5) << (one.inside ? "ball" : "piston") << ", step " << step;
      }
    }
  }
}

TEST(Leaks, NobodyPasses) {
  constexpr int particles = 400, steps = 60;
  for (const Case& one : cases()) {
    const auto obstacles = obstacles_of(one);
    Thrower thrower(7);
    int out = 0;
    for (int k = 0; k < particles; ++k) {
      Vec3 p = thrower.place();
      if (one.room(p) < 1e-9) continue;
      const Vec3 always = thrower.way(100);
      for (int step = 0; step < steps; ++step) {
        p = obstacles->predict(p, step % 2 == 0 ? always : thrower.way(100), 1.0 / 60);
        for (int sweep = 0; sweep < 3; ++sweep) p = obstacles->collide(p, thrower.way(0.3));
        if (one.room(p) < -1e-5) {
          ++out;
          break;
        }
      }
      ASSERT_TRUE(tank.contains(p));
    }
    EXPECT_EQ(out, 0) << one.name;
  }
}

}  // namespace
}  // namespace trevi
