// Periodic axes: neighbours across the ends of the box, the same flow wherever it is cut and on any ranks.
#include <cmath>
#include <cstring>
#include <set>

#include <fmt/format.h>

#include "boundary/geometry/periods.hpp"
#include "boundary/periodic_domain.hpp"
#include "domain/migrate.hpp"
#include "domain/neighbourhood.hpp"
#include "support/distributed.hpp"
#include "support/tank.hpp"
#include "trevi/error.hpp"

namespace trevi::test {
namespace {

constexpr Real h = 0.25;
const Box box{Vec3(0.5, -1, 0.25), Vec3(2.25, 0.25, 1.25)};  // 7, 5 and 4 cells
using Axes = std::array<bool, 3>;

std::vector<Axes> all_axes() {
  std::vector<Axes> axes;
  for (unsigned n = 0; n < 8; ++n) axes.push_back({(n & 1U) != 0, (n & 2U) != 0, (n & 4U) != 0});
  return axes;
}

Vec3 nearest_way(const Vec3& a, const Vec3& b, const Axes& periodic) {
  Vec3 way = a - b;
  for (int k = 0; k < 3; ++k) {
    const Real length = box.max[k] - box.min[k];
    if (periodic[static_cast<std::size_t>(k)]) way[k] -= length * std::round(way[k] / length);
  }
  return way;
}

Axes axes_of(const CellGrid& grid) {
  Axes periodic;
  for (std::size_t a = 0; a < 3; ++a) periodic[static_cast<std::size_t>(grid.axis(a))] = grid.is_periodic(a);
  return periodic;
}

template <class T>
void expect_neighbours(const Cloud& cloud, const CellGrid& grid, int parts) {
  const Axes periodic = axes_of(grid);
  const Slabs slabs = even_slabs(grid, parts);
  const Cloud mine = slice_of(cloud, rank_of(world), size_of(world));
  Particles particles;
  particles.id = mine.id;
  particles.position = particles.predicted = particles.velocity = mine.position;
  migrate(world, particles, &Particles::predicted, grid, slabs);
  Neighbourhood<T> near(world, grid, box.min, h);
  near.rebuild(particles, slabs);
  std::vector<GlobalId> id(static_cast<std::size_t>(near.order().size()));
  std::copy(particles.id.begin(), particles.id.end(), id.begin() + near.order().low_ghosts());
  near.exchange(id);
  for (LocalId i = 0; i < near.order().owned(); ++i) {
    const auto k = static_cast<std::size_t>(i);
    std::set<GlobalId> found, expected;
    for (const LocalId j : near.list()[i]) {
      EXPECT_TRUE(found.insert(id[static_cast<std::size_t>(j)]).second) << "a neighbour is there twice";
    }
    for (std::size_t j = 0; j < cloud.id.size(); ++j) {
      const Real distance = nearest_way(particles.predicted[k], cloud.position[j], periodic).norm();
      if (cloud.id[j] != particles.id[k] && distance < h) expected.insert(cloud.id[j]);
    }
    EXPECT_EQ(found, expected) << "of particle " << particles.id[k];
  }
}

TEST(Periodic, NeighboursAreThoseOfTheNearestImages) {
  const Cloud cloud = random_cloud(900, box, 1);
  for (const Axes& periodic : all_axes()) {
    for (const int slab_axis : {0, 1}) {
      SCOPED_TRACE(fmt::format("periodic {} {} {}, slabs along {}", periodic[0], periodic[1], periodic[2], slab_axis));
      const CellGrid grid(box.min, box.max, h, slab_axis, periodic);
      for (const int parts : parts_of_slabs(grid)) {
        SCOPED_TRACE(parts);
        expect_neighbours<double>(cloud, grid, parts);
        expect_neighbours<float>(cloud, grid, parts);
      }
    }
  }
}

const std::string endless = tank_text({.min = "0.5, -1, 0.25",
                                       .max = "2.25, 0.25, 1.25",
                                       .water = {{"0.5, -1, 0.25", "2.25, 0.25, 1.25"}},
                                       .dt = "0.0166666667",
                                       .end = "1.0",
                                       .spacing = "0.125",
                                       .domain = "periodic = [\"x\", \"y\", \"z\"]"}) +
                            R"([tensile]
[vorticity]
epsilon = 0.01
[viscosity]
nu = 0.01
)";

Vec3 momentum_of(const Cloud& cloud) {
  Vec3 sum = Vec3::Zero();
  for (const Vec3& v : cloud.velocity) sum += v;
  return sum;
}

TEST(Periodic, SameBitsOnAnyRanks) {
  for (const char* axes : {"['x']", "['y']", "['z']", "['x', 'y']", "['x', 'y', 'z']"}) {
    for (const char* more : {"density.precision='double'", "density.precision='single'", "domain.slab_axis='y'"}) {
      SCOPED_TRACE(fmt::format("{} {}", axes, more));
      const Scene scene = scene_with(endless, {fmt::format("domain.periodic={}", axes), more, "time.cfl=0"});
      const Cloud cloud = random_cloud(900, box, 2);
      const std::unique_ptr<Solver> one = solver_of(MPI_COMM_SELF, scene, cloud);
      one->start();
      for (int k = 0; k < 8; ++k) one->step();
      for (const int parts : {1, size_of(world) % 2 == 0 ? 2 : size_of(world)}) {
        SCOPED_TRACE(parts);
        Scene shared = scene;
        shared.ranks = {size_of(world) / parts, parts};
        const std::unique_ptr<Solver> many = solver_of(world, shared, cloud);
        many->start();
        for (int k = 0; k < 8; ++k) many->step();
        expect_same_bits(gathered(world, many->particles()), gathered(MPI_COMM_SELF, one->particles()));
      }
    }
  }
}

// Nothing but pairs acts where there are no walls.
TEST(Periodic, MomentumIsKept) {
  const Scene scene = scene_with(endless, {"vorticity.epsilon=0"});
  const Cloud cloud = random_cloud(1000, box, 1, 0.05);
  const std::unique_ptr<Solver> solver = solver_of(world, scene, cloud);
  for (int k = 0; k < 10; ++k) solver->step();
  const Cloud end = gathered(world, solver->particles());
  ASSERT_EQ(end.id.size(), cloud.id.size());
  EXPECT_LT((momentum_of(end) - momentum_of(cloud)).norm(), 1e-9 * 1000);
  for (const Vec3& p : end.position) EXPECT_TRUE(box.contains(p));
}

// A lattice that fills the box flows through it as if it had no ends.
TEST(Periodic, ALatticeInFlightStaysOne) {
  for (const char* precision : {"double"}) {  // in single precision noise grows to 1 cm/s in a second
    const Scene scene = scene_with(
        endless, {fmt::format("density.precision='{}'", precision), "particles.0.velocity=[1.7, -2.3, 0.9]"});
    const std::unique_ptr<Solver> solver = make_solver(world, scene, initial_particles(world, scene));
    const Cloud start = gathered(world, solver->particles());
    for (int k = 0; k < 60; ++k) solver->step();
    const Cloud end = gathered(world, solver->particles());
    const Vec3 way = solver->clock().time() * Vec3(1.7, -2.3, 0.9);
    Real faster = 0, farther = 0;
    for (std::size_t i = 0; i < end.id.size(); ++i) {
      faster = std::max(faster, (end.velocity[i] - Vec3(1.7, -2.3, 0.9)).norm());
      farther = std::max(farther, nearest_way(end.position[i], start.position[i] + way, {true, true, true}).norm());
    }
    EXPECT_LT(faster, 1e-5) << precision;
    EXPECT_LT(farther, 1e-5) << precision;
  }
}

/// What becomes of a cloud, and of the same one so many cells further on.
void expect_same_flow_elsewhere(const Scene& scene, const Vec3& cells, int steps) {
  const Box fitted = PeriodicDomain::fitted(scene.domain, scene.periodic, scene.fluid.kernel_radius);
  const Vec3 length = fitted.max - fitted.min, count = (length / scene.fluid.kernel_radius).array().round();
  const Vec3 shift = cells.cwiseProduct(length.cwiseQuotient(count));
  const auto wrapped = [&](Vec3 p) {
    for (int a = 0; a < 3; ++a)
      if (cells[a] > 0 && p[a] >= fitted.max[a]) p[a] -= length[a];
    return p;
  };
  const Cloud cloud = random_cloud(900, scene.domain, 1, 0.04);
  Cloud start, moved;
  for (std::size_t i = 0; i < cloud.id.size(); ++i) {
    const Vec3 p = ((cloud.position[i] * 1048576).array().floor() / 1048576).matrix().cwiseMax(fitted.min);
    start.add(cloud.id[i], p, cloud.velocity[i]);
    moved.add(cloud.id[i], wrapped(p + shift), cloud.velocity[i]);
  }
  const std::unique_ptr<Solver> here = solver_of(world, scene, start), there = solver_of(world, scene, moved);
  for (int k = 0; k < steps; ++k) {
    here->step();
    there->step();
  }
  Cloud a = gathered(world, here->particles());
  for (Vec3& p : a.position) p = wrapped(p + shift);
  expect_same_bits(a, gathered(world, there->particles()));
}

// To the bit, with the slabs along x or y, in cells with a width that is a power of two and in others, under gravity
// with the coarse grid and without.
TEST(Periodic, ItDoesNotMatterWhichPlaneIsTheFirst) {
  const auto same = [](std::vector<std::string> settings, const std::string& precision, const Vec3& cells) {
    settings.insert(settings.begin(), "density.precision='" + precision + "'");
    SCOPED_TRACE(testing::PrintToString(settings));
    expect_same_flow_elsewhere(scene_with(endless, settings), cells, precision == "double" ? 20 : 5);
  };
  const std::string finer = "fluid.spacing=0.1", min = "domain.min=[0.3, -1, 0.1]", max = "domain.max=[1.7, 0.2, 1.1]",
                    below = "particles.0.min=[0.3, -1, 0.1]", above = "particles.0.max=[1.7, 0.2, 1.1]";
  const std::string gravity = "gravity.acceleration=[0.3, -0.2, -9.8]", flat = "domain.periodic=['x', 'y']";
  for (const char* precision : {"double", "single"}) {
    same({flat, "domain.slab_axis='y'"}, precision, Vec3(3, 4, 0));
    same({finer, min, max, below, above}, precision, Vec3(3, 2, 1));
    same({finer, min, max, below, above, gravity, flat, "density.coarse_grid=false", "domain.slab_axis='y'"}, precision,
         Vec3(2, 5, 0));
    same({finer, min, "domain.max=[3.5, 0.2, 1.1]", below, above, gravity, flat}, precision, Vec3(7, 0, 0));
    same({finer, "domain.min=[-0.6, -1, 0.1]", "domain.max=[0.6, 2.2, 0.9]", "particles.0.min=[0, 0, 0.1]",
          "particles.0.max=[0.6, 0.2, 0.9]", gravity, flat},
         precision, Vec3(3, 5, 0));
    same({finer, min, max, below, above, gravity, flat, "vorticity.epsilon=0.01", "vorticity.form='projected'",
          "density.tolerance=0.001"},
         precision, Vec3(1, 3, 0));
  }
}

// Obstacles, an inlet, a drain and a fountain, and nothing comes into the obstacles.
TEST(Periodic, WithObstaclesAndInletsTheBitsAreTheSame) {
  const std::string more = rod_and_ball("1.375, -0.6, 0.5", 3, "1.4, -0.1, 0.7", 0.2) + R"(
[[inlet]]
center = [1.2, 0.1, 0.5]
direction = [1, -1, 0]
radius = 0.1
speed = 1
recycle = true
[[drain]]
min = [0.5, -1, 0.25]
max = [0.7, -0.7, 0.5]
[[fountain]]
center = [2.2, -0.5]
diameter = 0.3
height = 0.3
speed = 2
)";
  const Scene scene = scene_with(endless + more, {"domain.periodic=['x']", "particles.0.velocity=[3, 0, 0]"});
  const auto solver_on = [&](MPI_Comm comm) { return make_solver(comm, scene, initial_particles(comm, scene)); };
  const std::unique_ptr<Solver> many = solver_on(world), one = solver_on(MPI_COMM_SELF);
  for (const auto& solver : {many.get(), one.get()}) {
    solver->start();
    for (int k = 0; k < 30; ++k) solver->step();
  }
  const Cloud water = gathered(MPI_COMM_SELF, one->particles());
  expect_same_bits(gathered(world, many->particles()), water);
  EXPECT_GT(one->flow()->outflow, 0);
  EXPECT_GT(one->flow()->inflow, 0);
  for (const Vec3& p : water.position) {
    EXPECT_GT((p - Vec3(1.4, -0.1, 0.7)).norm(), 0.2 * (1 - 1e-9));
    EXPECT_GT(Vec3(0, p.y() + 0.6, p.z() - 0.5).norm(), 0.15 * (1 - 1e-9));
  }
}

TEST(Periodic, SettingsThatCannotBeAreRefused) {
  Settings settings = scene_with(endless, {});
  const auto told = [&](auto&& change) {
    Settings bad = settings;
    change(bad);
    try {
      make_solver(world, bad, {});
    } catch (const InputError& error) {
      return std::string(error.what());
    }
    return std::string("nothing");
  };
  EXPECT_EQ(told([](Settings&) {}), "nothing");
  EXPECT_NE(told([](Settings& s) { s.domain.max.x() += 0.1; }).find("whole number"), std::string::npos);
  EXPECT_NE(told([](Settings& s) { s.domain.max.z() = 0.75; }).find("three at least"), std::string::npos);
  EXPECT_NE(told([](Settings& s) { s.gravity = Vec3(0, 0, -1); }).find("z cannot be periodic"), std::string::npos);
  EXPECT_NE(told([](Settings& s) { s.walls.floor_friction = 0.1; }).find("floor_friction"), std::string::npos);
  ObstacleSettings ball;
  ball.center = Vec3(1.375, -0.375, 0.75);
  ball.radius = 0.1;
  const auto with = [&](const ObstacleSettings& obstacle) {
    return told([&](Settings& s) {
      s.periodic = {true, false, false};
      s.obstacles = {obstacle};
    });
  };
  EXPECT_EQ(with(ball), "nothing");
  // What rotates keeps its place if it is round; the corners of a box sweep a wider one.
  ObstacleSettings turning = ball;
  turning.center.x() = settings.domain.min.x() + 2 * settings.fluid.kernel_radius + 0.101;
  turning.angular_velocity = Vec3(0, 0, 3);
  EXPECT_EQ(with(turning), "nothing");
  turning.shape = ShapeKind::box;
  turning.size = Vec3::Constant(0.2);
  EXPECT_NE(with(turning).find("no image"), std::string::npos);
  turning.angular_velocity = Vec3(3, 0, 0);
  EXPECT_EQ(with(turning), "nothing");
  ball.velocity = Vec3(0, 0.1, 0);
  EXPECT_NE(with(ball).find("goes places"), std::string::npos);
  ball.velocity = Vec3::Zero();
  ball.center.x() = 1.0;
  EXPECT_NE(with(ball).find("no image"), std::string::npos);
  ball.shape = ShapeKind::cylinder;
  ball.axis = Vec3(1, 0, 0);
  ball.center.x() = 1.375;
  ball.height = 2.7;
  EXPECT_NE(with(ball).find("no image"), std::string::npos);
  ball.height = 2.8;
  EXPECT_EQ(with(ball), "nothing");
  ball.rotate.z() = 5;
  EXPECT_NE(with(ball).find("no image"), std::string::npos);
  WavemakerSettings waves;
  waves.height = 0.1;
  waves.period = waves.depth = 1;
  settings.periodic = {true, false, false};
  EXPECT_NE(why_not_periodic(paddle_of(waves, settings.domain), settings).find("makes waves along x"),
            std::string::npos);
}

TEST(Periodic, CellsAreCountedFromTheCornerWhereThereAreObstacles) {
  const Settings settings = scene_with(endless, {});
  const auto first_cell = [&](const Settings& s, const std::array<LocalId, 3>& asked) {
    SolverExtras extras;
    extras.first_cell = asked;
    return make_solver(world, s, {}, std::move(extras))->first_cell();
  };
  EXPECT_EQ(first_cell(settings, {2, 1, 0}), (std::array<LocalId, 3>{2, 1, 0}));
  for (const LocalId bad : {-1, 1000}) EXPECT_THROW(first_cell(settings, {bad, 0, 0}), std::exception);
  Settings round_a_ball = settings;
  round_a_ball.periodic = {true, false, false};
  round_a_ball.obstacles.resize(1);
  round_a_ball.obstacles[0].center = Vec3(1.375, -0.375, 0.75);
  round_a_ball.obstacles[0].radius = 0.1;
  EXPECT_EQ(first_cell(round_a_ball, {2, 1, 0}), (std::array<LocalId, 3>{0, 0, 0}));
}

}  // namespace
}  // namespace trevi::test
