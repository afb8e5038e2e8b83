// Rigid bodies that move freely: their masses, their flight, and how they and the water move each other.
#include <fmt/format.h>

#include <cmath>
#include <numbers>

#include "body_run.hpp"
#include "boundary/geometry/mass_properties.hpp"
#include "fluid/constraint/density.hpp"
#include "support/cloud.hpp"
#include "support/output_fixture.hpp"

namespace trevi::test {
namespace {
// ---- masses
// By the midpoints of a lattice.
MassProperties counted(const ObstacleSettings& solid, int across) {
  const auto shape = make_shape(solid);
  const Box box = shape->bounds();
  const Vec3 size = (box.max - box.min) / across;
  MassProperties sum;
  Eigen::Matrix3d second = Eigen::Matrix3d::Zero();
  for (int k = 0; k < across * across * across; ++k) {
    const Vec3 p =
        box.min + size.cwiseProduct(Vec3(k % across + 0.5, k / across % across + 0.5, k / across / across + 0.5));
    if (shape->distance(p) > 0) continue;
    sum.volume += size.prod();
    sum.center += size.prod() * p;
    second += size.prod() * p * p.transpose();
  }
  sum.center /= sum.volume;
  const Eigen::Matrix3d about = second - sum.volume * sum.center * sum.center.transpose();
  sum.inertia = about.trace() * Eigen::Matrix3d::Identity() - about;
  return sum;
}

std::vector<ObstacleSettings> all_shapes() {
  std::vector<ObstacleSettings> all(7);
  using enum ShapeKind;
  const ShapeKind kinds[] = {sphere, box, cylinder, capsule, torus, basin, basin};
  for (std::size_t k = 0; k < all.size(); ++k) {
    all[k].shape = kinds[k];
    all[k].radius = 0.4;
    all[k].tube = 0.15;
    all[k].height = 1.1;
    all[k].wall = 0.2;
    if (k == 1 || k == 6) all[k].size = {0.6, 1.0, 0.3};
  }
  return all;
}

TEST(Masses, AreThoseOfALattice) {
  for (const ObstacleSettings& solid : all_shapes()) {
    const MassProperties exact = mass_properties(solid), found = counted(solid, 100);
    const Real size = std::cbrt(exact.volume);
    EXPECT_NEAR(found.volume / exact.volume, 1, 0.01);
    EXPECT_LT((found.center - exact.center).norm(), 0.01 * size);
    EXPECT_LT((found.inertia - exact.inertia).norm(), 0.02 * exact.inertia.norm());
  }
}

// A mesh of triangles is exact wherever its origin is.
TEST(Masses, OfABoxOfTrianglesAreItsOwn) {
  ObstacleSettings solid;
  solid.shape = ShapeKind::box;
  solid.size = {0.6, 1.0, 0.3};
  const MassProperties exact = mass_properties(solid);
  auto mesh = std::make_shared<TriangleMesh>(make_shape(solid)->surface(0.01));
  const Vec3 shift(3, -2, 5);
  for (Vec3& p : mesh->points) p += shift;
  solid.shape = ShapeKind::mesh;
  solid.mesh = mesh;
  const MassProperties found = mass_properties(solid);
  EXPECT_NEAR(found.volume, exact.volume, 1e-13);
  EXPECT_LT((found.center - shift).norm(), 1e-13);
  EXPECT_LT((found.inertia - exact.inertia).norm(), 1e-12);
}

BodySettings brick() {
  BodySettings body;
  body.shape = ShapeKind::box;
  body.size = {0.6, 1.0, 0.3};
  body.density = 700;
  body.center = {1, 2, 3};
  body.rotate = {10, 20, 30};
  return body;
}

TEST(Flight, IsAParabolaWithTheAngularMomentumOfTheStart) {
  BodySettings settings = brick();
  settings.velocity = {1, -2, 3};
  settings.rotate.setZero();
  settings.angular_velocity = {5, 0.5, 0.5};  // about its middle axis, where it tumbles
  const Vec3 g(0, 0, -9.8);
  RigidBody body(settings, *make_shape(settings), g, 1000);
  const BodyState start = body.state();
  const Real energy = body.energy(), dt = 0.005;
  Real lowest = 5;
  for (int k = 0; k < 600; ++k) {
    body.begin(dt * (1 + k % 2));
    body.finish(RigidBody::Push::none);
    lowest = std::min(lowest, (rotation_of(body.state().orientation).transpose() * body.state().angular_velocity).x());
  }
  const Real t = 900 * dt;
  EXPECT_LT((body.state().position - (start.position + t * start.velocity + t * t / 2 * g)).norm(), 1e-10);
  EXPECT_LT((body.state().angular_momentum - start.angular_momentum).norm(), 1e-12 * start.angular_momentum.norm());
  EXPECT_NEAR(body.energy() / energy, 1, 1e-4);
  EXPECT_LT(lowest, -2) << "it turns over";
}

// A ball turns by its angular velocity, to second order.
TEST(Flight, TurnsAsFastAsItSays) {
  BodySettings settings;
  settings.radius = 0.5;
  settings.density = 100;
  settings.angular_velocity = {0, 0, 2};
  std::array<Real, 2> off{};
  for (std::size_t k = 0; k < 2; ++k) {
    RigidBody body(settings, *make_shape(settings), Vec3::Zero(), 1000);
    const int steps = k == 0 ? 100 : 200;
    for (int n = 0; n < steps; ++n) {
      body.begin(1.0 / steps);
      body.finish(RigidBody::Push::none);
    }
    off[k] = std::abs(2 * std::atan2(body.state().orientation[3], body.state().orientation[0]) - 2);
  }
  EXPECT_LT(off[0], 1e-3);
  EXPECT_NEAR(off[0] / off[1], 4, 0.1);
}

TEST(Flight, ALockedAxisDoesNotMove) {
  BodySettings settings = brick();
  settings.free = {false, false, true, false, true, false};
  settings.angular_velocity = {0, 2, 0};
  RigidBody body(settings, *make_shape(settings), {1, 0, -9.8}, 1000);
  const BodyState start = body.state();
  for (int k = 0; k < 100; ++k) {
    body.begin(0.01);
    body.finish(RigidBody::Push::none);
  }
  EXPECT_EQ(body.state().position.head<2>(), start.position.head<2>());
  EXPECT_NEAR(body.state().position.z(), start.position.z() - 4.9, 1e-10);
  EXPECT_EQ(body.state().angular_velocity.x(), 0);
  EXPECT_NEAR(body.state().angular_velocity.y(), 2, 1e-12);
}

// ---- in the water
const std::string light_ball = R"(
[[body]]
type = "sphere"
center = [0.75, 0.6, 0.5]
radius = 0.3
density = 50
)";

const std::string two_bodies = light_ball + R"(
[[body]]
type = "box"
center = [1.2, 0.6, 1.4]
size = [0.4, 0.5, 0.3]
rotate = [10, 20, 0]
density = 400
velocity = [-0.5, 0, -1]
friction = 0.3
)";

TEST(Bodies, SameBitsOnAnyRanksAndThreads) {
  BodyRun alone(MPI_COMM_SELF, pool + two_bodies);
  alone.steps(30);
  const int before = thread_count();
  for (const int threads : {1, 2}) {
    use_threads(threads);
    BodyRun together(world, pool + two_bodies);
    together.steps(30);
    expect_same_bits(gathered(world, together.solver->particles()), gathered(MPI_COMM_SELF, alone.solver->particles()));
    EXPECT_EQ(together.bodies(), alone.bodies());
  }
  use_threads(before);
}

// Cells beside a body look at those of the next row, which another rank has.
TEST(Bodies, SameBitsWhereRanksShareASlab) {
  BodyRun alone(MPI_COMM_SELF, pool + two_bodies),
      together(world, pool + two_bodies, {fmt::format("domain.ranks=[1, {}]", size_of(world))});
  alone.steps(30);
  together.steps(30);
  expect_same_bits(gathered(world, together.solver->particles()), gathered(MPI_COMM_SELF, alone.solver->particles()));
  EXPECT_EQ(together.bodies(), alone.bodies());
}

TEST(Bodies, ARestartGoesOnWithTheSameBits) {
  BodyRun through(MPI_COMM_SELF, pool + two_bodies);
  through.steps(15);
  const Cloud half = gathered(MPI_COMM_SELF, through.solver->particles());
  SolverExtras extras;
  extras.step = through.solver->clock().step;
  extras.substeps = through.solver->clock().substeps;
  extras.bodies = through.bodies();
  const auto on = solver_of(world, through.scene, half, std::move(extras));
  through.steps(15);
  for (int k = 0; k < 15; ++k) on->step();
  expect_same_bits(gathered(world, on->particles()), gathered(MPI_COMM_SELF, through.solver->particles()));
  EXPECT_EQ(on->bodies(), through.bodies());
}

// What water and bodies together gain is their weight less what the box took.
TEST(Bodies, MomentumBalances) {
  BodyRun run(world, pool + two_bodies);
  Real mass = static_cast<Real>(run.rows.front().particles) * water_mass(run.scene.fluid), through = 0;
  const auto momentum = [&] {
    Vec3 sum = run.rows.back().momentum;
    for (const BodyState& body : run.bodies()) sum += body.momentum;
    return sum;
  };
  for (const BodySettings& body : run.scene.bodies) mass += *body.density * mass_properties(body).volume;
  Vec3 expected = momentum();
  for (int k = 0; k < 20; ++k) {  // until the box meets a wall, having met the ball
    run.steps(1);
    const std::vector<BodyForce>& forces = run.forces.back();
    expected += run.scene.dt * (mass * *run.scene.gravity - forces.back().force);
    for (const BodyForce& one : forces) through += run.scene.dt * one.force.norm();
    EXPECT_LT((momentum() - expected).norm(), 1e-6 * through) << k;
  }
}

// Without gravity.
TEST(Bodies, ABlobAndABallKeepTheirMomentum) {
  BodyRun run(world, R"(
[domain]
min = [0, 0, 0]
max = [3, 2, 2]
[fluid]
spacing = 0.1
[[particles]]
min = [0.6, 0.6, 0.6]
max = [1.2, 1.4, 1.4]
velocity = [1, 0, 0]
[time]
dt = 0.01
end = 1
[[body]]
type = "sphere"
center = [1.6, 1.05, 1]
radius = 0.3
density = 300
)");
  const auto momentum = [&] { return Vec3(run.rows.back().momentum + run.bodies()[0].momentum); };
  const Vec3 start = momentum();
  run.steps(60);
  EXPECT_GT(run.bodies()[0].velocity.x(), 0.3) << "it was hit";
  EXPECT_LT((momentum() - start).norm(), 1e-6 * start.norm());
}

// A block of water meets a box in the air, off its middle. As long as what the transfer leaves over had its moment
// about the origin of coordinates the box turned at 30 rad/s or, 64 m from there, the water flew apart.
TEST(Bodies, ABlobTurnsABoxAlikeWhereverTheOriginIs) {
  const auto met = [](Real x) {  // m, so that nothing is rounded
    const auto at = [x](Real a, Real b, Real c) { return fmt::format("[{}, {}, {}]", x + a, x + b, x + c); };
    BodyRun run(world,
                fmt::format(R"(
[domain]
min = {}
max = {}
[fluid]
spacing = 0.125
[[particles]]
min = {}
max = {}
velocity = [3, 0, 0]
[time]
dt = 0.0078125
end = 1
[[body]]
type = "box"
center = {}
size = [0.375, 0.5, 0.625]
density = 500
)",
                            at(0, 0, 0), at(3, 2, 2), at(0.5, 0.625, 0.625), at(1.25, 1.25, 1.375), at(1.5625, 1, 1)));
    run.steps(16);
    return run.bodies().front();
  };
  const BodyState here = met(0), there = met(64);
  EXPECT_GT(here.momentum.x(), 50);
  EXPECT_LT((there.angular_momentum - here.angular_momentum).norm(), 1e-6 * here.angular_momentum.norm());
}

TEST(Bodies, ALightBallRisesAndJumps) {
  BodyRun run(world, pool + light_ball);
  const Real start = run.energy();
  Real highest = 0, fastest = 0;
  for (int k = 0; k < 90; ++k) {
    run.steps(1);
    highest = std::max(highest, run.bodies()[0].position.z());
    fastest = std::max({fastest, run.bodies()[0].velocity.norm(), run.rows.back().speed_max});
    EXPECT_LT(run.energy(), start) << k;
  }
  EXPECT_GT(highest, 1.35) << "it comes out of the water, 1.1 m with it";
  EXPECT_LT(fastest, 4.5);
}

// It was found in the run, when the body was no number.
TEST(BodyInput, IsRefusedWhereItsMooringWouldThrowItOutOfAllNumbers) {
  const std::string text = pool + light_ball + "mooring = { anchor = [1e200, 0, 0], stiffness = 1, length = 1 }\n";
  expect_mentions(input_error_of([&] { BodyRun(world, text).steps(1); }), {"mooring", "anchor is inf m away"});
}

TEST(BodyInput, IsRefusedWithItsPlace) {
  const auto refusal = [](const std::string& keys) {
    return input_error_of([&] { parse_scene("test.toml", pool + "[[body]]\n" + keys, {}); });
  };
  const std::string sphere = "type = \"sphere\"\ncenter = [0.7, 0.6, 0.5]\nradius = 0.2\n";
  expect_mentions(refusal(sphere), {"test.toml:", "[[body]]", "density", "missing"});
  expect_mentions(refusal(sphere + "density = 1\nmass = 2\n"), {"density", "mass is given, too"});
  expect_mentions(refusal(sphere + "density = 1\nfree = [\"up\"]\n"), {"free", "\"up\"", "choose"});
  expect_mentions(refusal(sphere + "density = 1\nfree = []\n"), {"free", "is empty"});
  expect_mentions(refusal(sphere + "density = 1\nfree = [\"z\"]\nvelocity = [1, 0, 0]\n"), {"velocity", "add \"x\""});
  expect_mentions(refusal(sphere + "density = 1\ninside = true\n"), {"inside", "basin"});
  const auto of_solver = [](const auto& keys) {
    return input_error_of([&] { BodyRun(world, pool + "[[body]]\n" + keys); });
  };
  expect_mentions(of_solver("type = \"sphere\"\ncenter = [0.1, 0.6, 0.5]\nradius = 0.2\ndensity = 1\n"),
                  {"bodies[0]", "out of the box"});
  expect_mentions(of_solver(sphere + "density = 1\n[body.mooring]\nanchor = [0, 0, 0]\nstiffness = 1e9\n"),
                  {"bodies[0]", "too stiff"});
  // 33.5 kg, of which 9.57 move with a point of the surface: as light as that, the end would be thrown further each
  // step.
  const std::string hooked = sphere + "density = 1000\n[body.mooring]\nanchor = [0, 0, 0]\nstiffness = 6e4\n";
  EXPECT_NO_THROW(BodyRun(world, pool + "[[body]]\n" + hooked));
  expect_mentions(of_solver(hooked + "point = [0.9, 0.6, 0.5]\n"),
                  {"bodies[0]", "the 9.57 kg that its end moves with"});
  expect_mentions(of_solver(sphere + "density = 1\n[[body]]\n" + sphere + "density = 2\n"), {"reaches into body"});
  expect_mentions(of_solver(sphere + "density = 1\n"), {"bodies[0]", "less than a particle of water"});
  // Without a corner in the other: contacts would part them at once, and threw bodies at 30 to 160 m/s.
  const std::string plank = "type = \"box\"\nsize = [0.6, 0.2, 0.2]\ndensity = 300\ncenter = [0.5, ";
  const std::string post = "[[obstacle]]\ntype = \"box\"\ncenter = [0.6, 0.6, 0.7]\nsize = [0.1, 0.1, 0.8]\n";
  const std::string nut = "[[obstacle]]\ntype = \"sphere\"\ncenter = [0.65, 0.6, 0.9]\nradius = 0.05\n";
  for (const std::string& crossed : {"0.6, 0.9]\n" + post, "0.48, 0.9]\n" + post, "0.6, 0.9]\n" + nut})
    expect_mentions(of_solver(plank + crossed), {"bodies[0]", "reaches into obstacle 0"});
  EXPECT_NO_THROW(BodyRun(world, pool + "[[body]]\n" + plank + "0.45, 0.9]\n" + post)) << "they touch";
}

}  // namespace
}  // namespace trevi::test
