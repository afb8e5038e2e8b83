// Which obstacles a place has to do with, against asking all of them; and what a body learns of the water that it takes
// along.
#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <array>
#include <numbers>
#include <random>
#include <utility>

#include "base/simd.hpp"
#include "boundary/obstacles/obstacles.hpp"
#include "boundary/volume_map/spline.hpp"

namespace trevi {
namespace {

constexpr Real h = 0.2;

Vec3 random_point(std::mt19937& generator, Real reach) {
  std::uniform_real_distribution<Real> number(-reach, reach);
  return {number(generator), number(generator), number(generator)};  // in this order, by the braces
}

// Whom the index leaves out has nothing to do with a place, nor a path with whom it leaves out: as many as do not fit
// into its bits, some that stand, some that move and turn.
TEST(Paths, TheIndexForgetsNobody) {
  std::mt19937 generator(11);
  std::uniform_real_distribution<Real> number(-1, 1);
  ObstacleSettings ball, brick;
  ball.radius = 0.1;
  brick.shape = ShapeKind::box;
  brick.size = {0.3, 0.1, 0.2};
  Settings settings;
  settings.domain = {Vec3(-3, -3, -3), Vec3(3, 3, 3)};
  settings.fluid.spacing = h / 2;
  std::vector<ObstacleSettings>& all = settings.obstacles;
  for (int k = 0; k < 80; ++k) {
    ObstacleSettings one = k % 2 == 0 ? ball : brick;
    one.center = random_point(generator, 2.5);
    if (k % 3 == 0) one.velocity = {number(generator), number(generator), number(generator)};
    if (k % 4 == 0) one.angular_velocity = {0, 3 * number(generator), 0};
    all.push_back(one);
  }
  settings = resolved(settings);
  const AnalyticWallDensity law(settings.domain, kernels_of(settings.fluid).density, h / 2, h, WallSlope::of_positions);
  Obstacles obstacles(settings, Walls(settings.domain, settings.walls, 1e-6 * h), law);
  int near = 0;
  for (int step = 0; step < 5; ++step) {
    obstacles.move(0.05 * step, 0.05 * (step + 1));
    for (int k = 0; k < 4000; ++k) {
      const Vec3 p = random_point(generator, 2.9), to = p + random_point(generator, k % 2 == 0 ? 0.1 : 1);
      bool by_all = false, open = true;
      for (std::size_t n = 0; n < all.size(); ++n) {
        by_all = by_all || obstacles.body(n).is_near(p);
        open = open && obstacles.body(n).is_passed_by(p, to);
      }
      EXPECT_EQ(obstacles.is_near(p), by_all);
      const bool inside = (to.array().abs() < 2.9).all();
      if (open && inside) {
        EXPECT_EQ(obstacles.collide(p, to - p), p + (to - p));
      }
      near += by_all;
    }
  }
  EXPECT_GT(near, 1000);
}

// A shift or a path in what is open to its particles meets nothing, as few particles as it is asked for and wherever
// the rest of them are, nor in what was open to those that had their numbers before. Nothing is open to paths where an
// obstacle turns by itself, so none does.
TEST(Paths, InTheOpenMeetNothing) {
  std::mt19937 generator(12);
  std::uniform_real_distribution<Real> number(-1, 1);
  Settings settings;
  settings.domain = {Vec3(-3, -3, -3), Vec3(3, 3, 3)};
  settings.fluid.spacing = h / 2;
  for (int k = 0; k < 40; ++k) {
    ObstacleSettings one;
    if (k % 2 == 0) one.shape = ShapeKind::box;
    one.radius = 0.2;
    one.size = {0.5, 0.2, 0.3};
    one.rotate = {30.0 * k, 10.0 * k, 0};
    one.center = random_point(generator, 2.5);
    if (k % 3 == 0) one.velocity = random_point(generator, 1);
    if (k % 4 != 1) {
      settings.obstacles.push_back(one);
      continue;
    }
    BodySettings& body = settings.bodies.emplace_back();
    static_cast<ObstacleSettings&>(body) = one;
    body.velocity = random_point(generator, 2);
    body.angular_velocity = random_point(generator, k < 20 ? 3 : 0.05);
  }
  settings = resolved(settings);
  const AnalyticWallDensity law(settings.domain, kernels_of(settings.fluid).density, h / 2, h, WallSlope::of_positions);
  Obstacles obstacles(settings, Walls(settings.domain, settings.walls, 1e-6 * h), law);
  constexpr Real dt = 0.05;
  obstacles.move(0, dt);
  std::array<int, 3> open_ones{};
  for (std::size_t cluster = 0; cluster < 8000; ++cluster) {
    const Box body = obstacles.body(cluster / 2 % obstacles.count()).surface_box();
    const Vec3 beside = (body.min + body.max) / 2 + (body.max - body.min).cwiseProduct(random_point(generator, 0.6));
    const Vec3 middle = cluster % 2 == 0 ? random_point(generator, 2.8) : beside;
    std::vector<Vec3> p;
    for (int k = 0; k < 20; ++k) p.push_back(middle + random_point(generator, 0.15));
    if (cluster % 3 == 0) obstacles.number_particles(p.size());
    for (const auto& [extent, first] : {std::pair{Extent::shift, -1}, {Extent::shift, 0}, {Extent::path, -1}}) {
      const OpenSpace open = obstacles.open_space(p, extent, first);
      for (Vec3 from : p) {
        const Vec3 step = random_point(generator, 0.2), to = from + step, path = from + step / dt * dt;
        if (!open.contains(from, to) || !open.contains(from, path)) continue;
        ++open_ones[static_cast<std::size_t>(extent)];
        EXPECT_EQ(extent == Extent::shift ? obstacles.collide(from, step) : obstacles.predict(from, step / dt, dt),
                  extent == Extent::shift ? to : path);
      }
    }
  }
  for (const Extent extent : {Extent::shift, Extent::path})
    EXPECT_GT(open_ones[static_cast<std::size_t>(extent)], 20000);
}

// Of any number of particles each one by itself, on every instruction set.
TEST(Paths, OutsideOfASpaceOrOfABoxIsEachByItself) {
  std::mt19937 generator(13);
  OpenSpace open(Box{Vec3::Constant(-0.8), Vec3::Constant(0.9)});
  const std::array<ClosedPart, 2> parts{{{{Vec3(-0.3, -0.9, 0), Vec3(0.2, 0.5, 0.4)}, {Vec3(0, -0.2, 0.2), 0.6}},
                                         {{Vec3(0.1, 0.1, -0.5), Vec3(0.6, 0.4, 0.1)}, {}}}};
  for (const ClosedPart& part : parts) open.close(part);
  const Box box{Vec3(-0.7, -1, -0.6), Vec3(1, 0.6, 0.8)};
  for (const std::string& name : instruction_set_names()) {
    ASSERT_TRUE(use_instruction_set(name));
    std::array<std::size_t, 3> of_kind{};  // inside, outside of the box alone, of the space
    for (std::size_t count = 1; count < 40; ++count) {
      std::vector<Vec3> p;
      for (std::size_t k = 0; k < count; ++k) p.push_back(random_point(generator, 1));
      std::vector<OutsideOf> found(count);
      found.resize(find_outside(open, box, p, found.data()));
      std::size_t next = 0;
      for (std::size_t k = 0; k < count; ++k) {
        const bool of_space = !open.contains(p[k]), any = of_space || !box.contains(p[k]);
        ++of_kind[of_space ? 2 : any ? 1 : 0];
        if (!any) continue;
        ASSERT_LT(next, found.size());
        EXPECT_EQ(found[next].which, static_cast<LocalId>(k));
        EXPECT_EQ(found[next++].space, of_space);
      }
      EXPECT_EQ(next, found.size());
    }
    for (const std::size_t some : of_kind) EXPECT_GT(some, 50U);
  }
  restrict_instruction_sets(-1);
}

// In whatever vectors: each sum in its order.
TEST(Spline, HasTheBitsOfItsFormula) {
  std::mt19937 generator(14);
  constexpr std::size_t row = 5, plane = 26;
  std::vector<Real> nodes(4 * plane + 1);
  const auto weights = [](Real t) {
    return std::array<Real, 4>{t * (-0.5 + t * (1 - 0.5 * t)), 1 + t * t * (-2.5 + 1.5 * t),
                               t * (0.5 + t * (2 - 1.5 * t)), t * t * (-0.5 + 0.5 * t)};
  };
  const auto slopes = [](Real t) {
    return std::array<Real, 4>{-0.5 + t * (2 - 1.5 * t), t * (-5 + 4.5 * t), 0.5 + t * (4 - 4.5 * t),
                               t * (-1 + 1.5 * t)};
  };
  for (int round = 0; round < 200; ++round) {
    for (Real& one : nodes) one = random_point(generator, 1).x();
    const Vec3 t = (random_point(generator, 0.5).array() + 0.5).matrix();
    const auto sum = [&](const auto& x, const auto& y, const auto& z) {
      Real all = 0;
      for (std::size_t k = 0; k < 4; ++k) {
        Real of_plane = 0;
        for (std::size_t j = 0; j < 4; ++j) {
          const Real* const d = &nodes[1 + k * plane + j * row];
          of_plane += y[j] * ((x[0] * d[0] + x[1] * d[1]) + (x[2] * d[2] + x[3] * d[3]));
        }
        all += z[k] * of_plane;
      }
      return all;
    };
    const auto x = weights(t.x()), y = weights(t.y()), z = weights(t.z());
    const Vec3 slope(sum(slopes(t.x()), y, z), sum(x, slopes(t.y()), z), sum(x, y, slopes(t.z())));
    for (const std::string& name : instruction_set_names()) {
      ASSERT_TRUE(use_instruction_set(name));
      const SplineValue found = interpolate({&nodes[1], row, plane}, t);
      EXPECT_EQ(found.value, sum(x, y, z)) << name;
      EXPECT_EQ(found.slope, slope) << name;
    }
  }
  restrict_instruction_sets(-1);
}

// Sums of integers hold what many particles far from the centre of a wide body say of it: its motion is that by sums
// of floating-point numbers.
TEST(Met, AWideBodyMovesAsManyParticlesTellIt) {
  constexpr Real dt = 0.01, spacing = h / 2, given = 1.5;
  for (const Real size : {20.0, 900.0}) {
    Settings settings;
    settings.domain = {Vec3::Constant(-1000), Vec3::Constant(1000)};
    settings.fluid.spacing = spacing;
    BodySettings raft;
    raft.shape = ShapeKind::box;
    raft.size = {size, size, 4};
    raft.density = 1;
    settings.bodies.push_back(raft);
    settings = resolved(settings);
    Obstacles obstacles(settings, Walls(settings.domain, settings.walls, 1e-6 * h), std::nullopt);
    RigidBodies& bodies = *obstacles.floating();
    obstacles.move(0, dt);
    const RigidBody& body = bodies.body(0);
    const Six before = body.twist();
    const Real mass = settings.fluid.rest_density * spacing * spacing * spacing;
    Six pushed{};
    Mass6 met{};
    std::mt19937 generator(3);
    std::uniform_real_distribution<Real> place(-size / 2, size / 2);
    for (int k = 0; k < 200000; ++k) {
      const Vec3 p(std::abs(place(generator)), place(generator), -2), v(0, 0, 3);
      bodies.meet(0, p, -Vec3::UnitZ(), v, given);
      const Six g = six_of(-Vec3::UnitZ(), p.cross(-Vec3::UnitZ()));
      pushed = plus(pushed, g, -3 * given * mass);
      add_square(met, g, given * mass);
    }
    const Six lacking = plus(pushed, times(met, before), -1);
    const Six expected = plus(before, solved(plus(body.felt_inertia(), met), lacking, body.free()));
    ASSERT_TRUE(bodies.settle(MPI_COMM_SELF));
    for (std::size_t i = 0; i < 6; ++i)
      EXPECT_NEAR(body.twist()[i], expected[i], i < 3 ? 1e-7 : 1e-7 / size) << size << ' ' << i;
  }
}

// However far the box is from the origin.
TEST(Recorded, MomentsOfTheBoxAreThoseOfItsWater) {
  Settings settings;
  const Vec3 corner(4e6, -4e6, 0);
  settings.domain = {corner, corner + Vec3(4, 2, 2)};
  settings.fluid.spacing = h / 2;
  ObstacleSettings ball;
  ball.radius = 0.3;
  ball.center = corner + Vec3(3, 1, 1);
  settings.obstacles.push_back(ball);
  settings = resolved(settings);
  Obstacles obstacles(settings, Walls(settings.domain, settings.walls, 1e-6 * h), std::nullopt);
  Vec3 shift = Vec3::Zero(), moment = Vec3::Zero();  // about the middle of the box
  for (int k = 0; k < 1000; ++k) {
    const Vec3 up(0, 0, 0.01), arm(k * 0.003 - 1.5, 0.5, -1);
    std::array<Impulse, 1> push{{{up, corner + Vec3(2, 1, 1) + arm}}};
    shift += up;
    moment += arm.cross(up);
    if (k % 2 == 0) {
      obstacles.record_box(push);
    } else {
      obstacles.record_projection(obstacles.box_account(), up, push[0].arm);
    }
  }
  const TotalImpulse box = obstacles.total(MPI_COMM_SELF)[obstacles.box_account()];
  const Vec3 about_middle = box.moment - Vec3(corner + Vec3(2, 1, 1)).cross(box.shift);
  for (Eigen::Index i = 0; i < 3; ++i) {
    EXPECT_NEAR(box.shift[i], shift[i], 1e-8);
    EXPECT_NEAR(about_middle[i], moment[i], 1e-6);
  }
}

// Of a box, whose sides are two triangles each: as thick a layer on each side, with the moments of the whole side.
TEST(AddedMass, AtFirstHasTheMomentsOfTheSides) {
  BodySettings settings;
  settings.shape = ShapeKind::box;
  settings.size = {0.6, 1.0, 0.3};
  const auto [a, b, c] = std::array<Real, 3>{0.6, 1.0, 0.3};
  const Real surface = 2 * (a * b + b * c + c * a), layer = 1000 * std::sqrt(surface / (16 * std::numbers::pi));
  const auto turned = [&](Real l, Real m, Real n) { return l * (m * m * m + n * n * n) / 6; };
  const std::array<Real, 6> expected{2 * b * c,       2 * a * c,       2 * a * b,
                                     turned(a, b, c), turned(b, c, a), turned(c, a, b)};
  const RigidBody body(settings, *make_shape(settings), Vec3::Zero(), 1000);
  for (std::size_t i = 0; i < 6; ++i) {
    for (std::size_t j = 0; j < 6; ++j)
      EXPECT_NEAR(body.state().added_mass[6 * i + j], i == j ? layer * expected[i] : 0, 1e-9 * layer) << i << ' ' << j;
  }
}

// Answers that are noise, or what another body did, do not make of the added mass what is none: of the shape's own at
// least what is forgotten in a substep is there, and it has a bound.
TEST(AddedMass, StaysPositiveAndBounded) {
  BodySettings settings;
  settings.shape = ShapeKind::box;
  settings.size = {0.6, 1.0, 0.3};
  settings.density = 700;
  settings.rotate = {10, 20, 30};
  for (const Real answered : {1e-2, 1e3}) {
    RigidBody body(settings, *make_shape(settings), Vec3::Zero(), 1000);
    const auto values = [&]() -> Eigen::Matrix<Real, 6, 1> {
      const Eigen::Map<const Eigen::Matrix<Real, 6, 6>> added(body.state().added_mass.data());
      return added.selfadjointView<Eigen::Lower>().eigenvalues();
    };
    const Real first = values().minCoeff(), wide = values().maxCoeff() + body.mass();
    EXPECT_GT(first, 0);
    std::mt19937 generator(5);
    std::normal_distribution<Real> noise(0, 1);
    const auto six = [&](Real scale) {
      Six all{};
      for (Real& one : all) one = scale * noise(generator);
      return all;
    };
    for (int k = 0; k < 3000; ++k) {
      body.begin(0.01);
      for (int answer = 0; answer < 3; ++answer) {
        body.hear(six(answered));
        body.set_twist(plus(body.twist(), six(1e-3)));
      }
      body.finish(RigidBody::Push::full);
      ASSERT_GT(values().minCoeff(), 0.019 * first) << answered << ' ' << k;
      ASSERT_LT(values().maxCoeff(), 5000 * wide) << answered << ' ' << k;
    }
  }
}

}  // namespace
}  // namespace trevi
