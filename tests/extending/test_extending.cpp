// What README.md shows is compiled and does what it says.
#include <gtest/gtest.h>

#include <random>

#include "bed_friction.hpp"
#include "cone.hpp"
#include "quartic-inl.hpp"
#include "speed_field.hpp"
#include "support/cloud.hpp"
#include "trevi/solver.hpp"
#include "wind.hpp"

namespace trevi::test {
namespace {

namespace hn = hwy::HWY_NAMESPACE;
namespace kernel_loops = trevi::HWY_NAMESPACE;

TEST(Extending, AKernelIsNormalisedAndTheLoopsHaveItsShape) {
  constexpr Real h = 0.3;
  constexpr int parts = 20000;
  Real integral = 0;
  for (int k = 0; k < parts; ++k) {
    const Real r = h * (k + 0.5) / parts;
    integral += Quartic::value(Vec3(r, 0, 0), h) * 4 * std::numbers::pi * r * r * h / parts;
  }
  EXPECT_NEAR(integral, 1, 1e-6);
  using D = hn::ScalableTag<double>;
  const D d;
  for (const Real u : {0.0, 0.2, 0.7, 1.0, 1.3}) {
    const kernel_loops::Distance<D> distance{hn::Set(d, u), hn::Set(d, u * u)};
    const auto value = kernel_loops::Shape<Quartic>::value(d, distance);
    const auto slope = kernel_loops::Shape<Quartic>::slope(d, distance);
    const Vec3 r(u * h, 0, 0);
    EXPECT_NEAR(hn::GetLane(hn::Mul(value.first, value.second)) * Quartic::factor(h), Quartic::value(r, h), 1e-12);
    EXPECT_NEAR(-hn::GetLane(slope.size) * Quartic::slope_factor(h), Quartic::gradient(r, h).x(), 1e-10);
    const Real step = 1e-6, before = Quartic::value(r - Vec3(step, 0, 0), h);
    EXPECT_NEAR(Quartic::gradient(r, h).x(), (Quartic::value(r + Vec3(step, 0, 0), h) - before) / (2 * step), 1e-3);
  }
}

TEST(Extending, AConeHasExactDistances) {
  const Cone cone(0.3, 0.8);
  std::mt19937_64 random(5);
  std::uniform_real_distribution<Real> place(-0.8, 0.8);
  const TriangleMesh fine = cone.surface(1e-5);
  for (int k = 0; k < 200; ++k) {
    const Vec3 p(place(random), place(random), place(random));
    const Real d = cone.distance(p);
    // A distance has the slope 1, and leads to the surface.
    EXPECT_NEAR(cone.distance(p - d * cone.normal(p)), 0, 1e-5) << p.transpose();
    Real nearest = INFINITY;
    for (const Vec3& corner : fine.points) nearest = std::min(nearest, (corner - p).norm());
    EXPECT_LE(std::abs(d), nearest + 1e-4);
  }
  EXPECT_LT(cone.distance(Vec3(0, 0, -0.1)), 0);
}

/// A bed that slopes by 20 degrees, water in the box above it.
struct Slope {
  Slope() {
    settings.domain = {Vec3::Zero(), Vec3(2, 1, 2)};
    ObstacleSettings bed;
    bed.shape = ShapeKind::box;
    bed.center = Vec3(1, 0.5, 0);
    bed.size = Vec3(4, 4, 0.5);
    bed.rotate = {0, 20, 0};
    settings.obstacles.push_back(bed);
    settings = resolved(settings);
    const Real h = settings.fluid.kernel_radius, spacing = settings.fluid.spacing;
    const Walls walls(settings.domain, settings.walls, 1e-6 * h);
    const AnalyticWallDensity law(settings.domain, kernels_of(settings.fluid).density, spacing, h,
                                  WallSlope::of_positions);
    obstacles = std::make_shared<Obstacles>(settings, walls, law);
  }
  Settings settings;
  std::shared_ptr<Obstacles> obstacles;
};

TEST(Extending, FrictionBrakesWhatIsNearTheBedAndIsRecorded) {
  Slope slope;
  const Body& bed = slope.obstacles->body(0);
  const Real h = slope.settings.fluid.kernel_radius, dt = 0.01;
  const Vec3 normal = bed.now().turn * Vec3::UnitZ(), on_bed = bed.now().into_world(Vec3(0, 0, 0.25));
  Particles particles;
  for (const Real distance : {0.2 * h, 2 * h}) {
    particles.id.push_back(std::ssize(particles.id));
    particles.position.push_back(on_bed + distance * normal);
    particles.velocity.push_back(bed.now().turn * Vec3(2, 0, 0));
  }
  particles.predicted = particles.position;
  const CellGrid grid(slope.settings.domain.min, slope.settings.domain.max, h, 0);
  Neighbourhood<double> near(MPI_COMM_SELF, grid, Vec3::Zero(), h);
  BedFriction<double> friction(0.01, h, slope.obstacles);
  friction.apply(near, particles, dt);
  const Real rate = 0.01 / h * 0.8 * 2;
  EXPECT_NEAR(particles.velocity[0].norm(), 2 / (1 + rate * dt), 1e-6);
  EXPECT_EQ(particles.velocity[1], bed.now().turn * Vec3(2, 0, 0));
  const Real recorded = slope.obstacles->total(MPI_COMM_SELF)[0].shift.norm();
  EXPECT_NEAR(recorded, (2 - particles.velocity[0].norm()) * dt, 1e-9);
}

TEST(Extending, AForcingIsHandedToASolver) {
  Settings settings;
  settings.domain = {Vec3::Zero(), Vec3(2, 1, 1)};
  settings.dt = 0.01;
  Particles drop;
  if (rank_of(world) == 0) {
    drop.id = {0};
    drop.position = {Vec3(0.5, 0.5, 0.5)};
    drop.velocity = {Vec3::Zero()};
  }
  SolverExtras extras;
  extras.forcings.push_back(std::make_unique<Wind>(Vec3(1, 0, 0), 0.2, 0.1));
  const auto solver = make_solver(world, settings, std::move(drop), std::move(extras));
  solver->start();
  for (int k = 0; k < 10; ++k) solver->step();
  for (const Vec3& v : solver->particles().velocity) EXPECT_NEAR(v.x(), 1 - std::exp(-1), 1e-6);
}

TEST(Extending, AFieldHasARowForEachParticle) {
  Particles particles;
  particles.id = {3, 4};
  particles.velocity = {Vec3(3, 4, 0), Vec3(0, 0, -2)};
  const Clock clock{};
  const Frame frame{.clock = clock, .particles = particles, .density = {}, .diagnostics = nullptr, .fountains = {}};
  const ColourScale colour{};
  const Rows rows = speed_field.rows({frame, colour, 0});
  EXPECT_EQ(static_cast<const float*>(rows.get())[0], 5.0F);
  EXPECT_EQ(static_cast<const float*>(rows.get())[1], 2.0F);
}

}  // namespace
}  // namespace trevi::test
