// Gauges of height and pressure: still water shows its depth and rho g d, all bits are the same on any ranks, and a
// gauge changes nothing of the run.
#include <cmath>
#include <cstdio>
#include <numbers>
#include <sstream>

#include "boundary/gauges.hpp"
#include "io/tables/gauge_series.hpp"
#include "support/cloud.hpp"
#include "support/output_fixture.hpp"
#include "support/tank.hpp"
#include "trevi/scene.hpp"
#include "trevi/solver.hpp"

namespace trevi::test {
namespace {

// Water 1.2 m deep, with a box on the floor whose front is at x = 1.
const std::string pool =
    tank_with_gravity({.max = "2, 1.2, 1.8", .water = {{"0, 0, 0", "2, 1.2, 1.2"}}}) + R"([output.series]
[[obstacle]]
type = "box"
center = [1.25, 0.6, 0.3]
size = [0.5, 0.6, 0.6]
)";

struct GaugePlace {
  GaugeKind kind;
  Vec3 center, normal;
};

std::string tables_of(const std::vector<GaugePlace>& places) {
  std::ostringstream text;
  for (const auto& [kind, center, normal] : places) {
    text << "[[gauge]]\ntype = '" << (kind == GaugeKind::height ? "height" : "pressure") << "'\ncenter = ["
         << center.x() << ", " << center.y() << ", " << center.z() << "]\n";
    if (kind == GaugeKind::pressure)
      text << "normal = [" << normal.x() << ", " << normal.y() << ", " << normal.z() << "]\n";
  }
  return text.str();
}

const std::vector<GaugePlace> places = {
    {GaugeKind::height, {0.5, 0.6, 0}, Vec3::Zero()},     // in the open
    {GaugeKind::height, {0, 0, 0}, Vec3::Zero()},         // in the corner
    {GaugeKind::height, {1.25, 0.6, 0.6}, Vec3::Zero()},  // above the box
    {GaugeKind::pressure, {1, 0.6, 0.3}, {-1, 0, 0}},     // on its front
    {GaugeKind::pressure, {1.25, 0.6, 0.6}, {0, 0, 1}},   // on its top
    {GaugeKind::pressure, {1.5, 0.62, 0.05}, {2, 0, 0}},  // at the foot of its back
    {GaugeKind::pressure, {0, 0.6, 0.7}, {1, 0, 0}},      // on a wall
    {GaugeKind::pressure, {0.5, 0.6, 0}, {0, 0, 1}},      // on the floor
};

using Rows = std::vector<std::vector<Real>>;

/// Of gauges.csv, without its header.
Rows rows_of(const std::string& folder) {
  std::istringstream file(text_of(folder + "/gauges.csv"));
  std::string line;
  std::getline(file, line);
  Rows rows;
  while (std::getline(file, line)) {
    std::istringstream cells(line);
    rows.emplace_back();
    for (std::string cell; std::getline(cells, cell, ',');) rows.back().push_back(std::stod(cell));
  }
  return rows;
}

struct GaugeRun {
  Scene scene;
  std::unique_ptr<Solver> solver;
};

GaugeRun run(MPI_Comm comm, const std::string& text, const std::string& folder, int steps) {
  GaugeRun made{parse_scene("test.toml", text, {}), nullptr};
  SolverExtras extras;
  if (!made.scene.gauges.empty())
    extras.observers.push_back(
        std::make_unique<GaugeSeries>(comm, TableOptions{folder, *made.scene.output.series, {}}, made.scene));
  made.solver = make_solver(comm, made.scene, initial_particles(comm, made.scene), std::move(extras));
  made.solver->start();
  for (int k = 0; k < steps; ++k) made.solver->step();
  return made;
}

class Gauges : public Output {};

TEST_F(Gauges, WeightHasTheIntegralOne) {
  constexpr int n = 400;
  constexpr Real radius = 0.3;
  Real sum = 0;
  for (int k = 0; k < n * n; ++k) {
    const Real x = (2 * (k % n + 0.5) / n - 1) * radius, y = (2 * (k / n + 0.5) / n - 1) * radius;
    sum += gauge_weight(x * x + y * y, radius) * (2 * radius / n) * (2 * radius / n);
  }
  EXPECT_NEAR(sum, 1, 1e-4);
  EXPECT_EQ(gauge_weight(radius * radius, radius), 0);
}

// A disc whose lower half is behind the floor, one with a wall behind all of it, and one in the midst of the water.
TEST_F(Gauges, FractionIsWhatIsOpenBeforeASolid) {
  const Box box{Vec3::Zero(), Vec3::Ones()};
  const auto nowhere = [](const Vec3&) { return false; };
  GaugeSettings gauge{GaugeKind::pressure, {0, 0.5, 0}, {1, 0, 0}, 0.1};
  EXPECT_NEAR(open_fraction_of_gauge(gauge, 0.1, box, nowhere), 0.5, 0.01);
  gauge.center.z() = 0.5;
  EXPECT_EQ(open_fraction_of_gauge(gauge, 0.1, box, nowhere), 1);
  gauge.center.x() = 0.5;
  EXPECT_EQ(open_fraction_of_gauge(gauge, 0.1, box, nowhere), 0);
  EXPECT_EQ(open_fraction_of_gauge(gauge, 0.1, box, [](const Vec3& p) { return p.x() < 0.5; }), 1);
}

// Of a height what of the disc is in an obstacle does not count, at each level by itself: beside the box of the pool
// half of it up to the top of the box, and all above.
TEST_F(Gauges, AHeightBesideAnObstacleIsThatOfTheWater) {
  const std::vector<GaugePlace> beside = {
      {GaugeKind::height, {1, 0.6, 0}, Vec3::Zero()},        // at its front
      {GaugeKind::height, {0.9, 0.6, 0}, Vec3::Zero()},      // a quarter of the disc's width off
      {GaugeKind::height, {1, 0.3, 0.2}, Vec3::Zero()},      // at its edge
      {GaugeKind::height, {1.25, 0.6, 0.6}, Vec3::Zero()}};  // on it
  const GaugeRun still = run(world, pool + tables_of(beside), folder(), 1);
  if (rank_of(world) != 0) return;
  const Rows rows = rows_of(folder());
  for (std::size_t k = 0; k < beside.size(); ++k)
    EXPECT_NEAR(rows.front()[k + 2], 1.2 - beside[k].center.z(), 0.01) << k;
}

// Of a level disc that is wider than the box what is in that: in a channel as narrow as this the strip along its
// middle.
TEST_F(Gauges, FractionOfALevelDiscIsExactInANarrowBox) {
  const Box box{Vec3(-9, -0.01, 0), Vec3(9, 0.01, 1)};
  const GaugeSettings gauge{GaugeKind::height, {0, 0, 0}, {0, 0, 1}, 9};
  EXPECT_NEAR(open_fraction_of_gauge(gauge, 0.1, box, {}) / (0.02 * 8 / (3 * std::numbers::pi * 9)), 1, 1e-5);
}

// Depths are those of the water; pressures in the mean over steps at rest.
TEST_F(Gauges, StillWaterShowsItsDepthAndItsPressure) {
  const GaugeRun still = run(world, pool + tables_of(places), folder(), 60);
  if (rank_of(world) != 0) return;
  const Rows rows = rows_of(folder());
  ASSERT_EQ(rows.size(), 61u);
  for (std::size_t k = 0; k < places.size(); ++k) {
    const auto& [kind, center, normal] = places[k];
    const Real depth = 1.2 - center.z();
    if (kind == GaugeKind::height) {
      EXPECT_NEAR(rows.back()[k + 2], depth, 0.002 * depth) << k;
      continue;
    }
    EXPECT_EQ(rows.front()[k + 2], 0);
    Real mean = 0;
    for (std::size_t n = 21; n < rows.size(); ++n) mean += rows[n][k + 2] / 40;
    std::printf("pressure over rho g d: %.4f\n", mean / (1000 * 9.8 * depth));
    EXPECT_NEAR(mean / (1000 * 9.8 * depth), 1, 0.05) << k;
  }
}

// A lattice shows its depth wherever the gauge stands, in corners and with any radius, to rounding.
TEST_F(Gauges, AHeightIsExactForALattice) {
  std::string text = pool;
  std::vector<Real> depths;
  for (const Vec3& foot : {Vec3(0.5, 0.6, 0), Vec3(0.5317, 0.6411, 0), Vec3(0, 0, 0), Vec3(0.013, 0.487, 0.333)}) {
    for (const char* radius : {"0.1", "0.2", "0.317"}) {
      text += fmt::format("[[gauge]]\ntype = 'height'\ncenter = [{}, {}, {}]\nradius = {}\n", foot.x(), foot.y(),
                          foot.z(), radius);
      depths.push_back(1.2 - foot.z());
    }
  }
  run(world, text, folder(), 0);
  if (rank_of(world) != 0) return;
  const std::vector<Real> row = rows_of(folder()).front();
  for (std::size_t k = 0; k < depths.size(); ++k) EXPECT_NEAR(row[k + 2], depths[k], 1e-8) << k;
}

// Water whose outermost layers are pressed to the floor and to the walls is as much water.
TEST_F(Gauges, AHeightCountsWholeParticlesAtTheFloorAndAtWalls) {
  std::string text = pool;
  for (const Vec3& foot : {Vec3(0.5, 0.6, 0), Vec3(0.5317, 0.6411, 0), Vec3(0, 0, 0)})
    text += fmt::format("[[gauge]]\ntype = 'height'\ncenter = [{}, {}, {}]\n", foot.x(), foot.y(), foot.z());
  const Scene scene = parse_scene("test.toml", text, {});
  Particles particles = initial_particles(world, scene);
  for (Vec3& p : particles.position) {
    for (Eigen::Index a = 0; a < 3; ++a) {
      if (p[a] - scene.domain.min[a] < scene.fluid.spacing) p[a] -= 0.4 * scene.fluid.spacing;
    }
  }
  GaugeSeries gauges(world, {folder(), *scene.output.series, {}}, scene);
  const Clock clock{0, scene.dt};
  gauges.observe({clock, particles, {}, nullptr, {}});
  if (rank_of(world) != 0) return;
  const std::vector<Real> row = rows_of(folder()).front();
  for (std::size_t k = 0; k < 3; ++k) EXPECT_NEAR(row[k + 2], 1.2, 1e-8) << k;
}

// Cut at its foot, a gauge on the floor of a vessel read 0.2 spacings too little in water that moves.
TEST_F(Gauges, AHeightOnTheFloorOfAVesselCountsWholeParticles) {
  const Scene scene = parse_scene(
      "test.toml",
      "[domain]\nmin = [-0.2, -0.2, -0.3]\nmax = [2.2, 1.4, 2]\n[fluid]\nspacing = 0.1\n[time]\ndt = 0.01\nend = 0.01\n"
      "[[particles]]\nmin = [0, 0, 0]\nmax = [2, 1.2, 1.2]\n[[obstacle]]\ntype = 'box'\ninside = true\n"
      "center = [1, 0.6, 1]\nsize = [2, 1.2, 2]\nmotion = { type = 'sine', amplitude = [0.05, 0, 0], period = 2 }\n"
      "[output.series]\nevery_steps = 1\n[[gauge]]\ntype = 'height'\ncenter = [0.5, 0.6, 0]\n"
      "[[gauge]]\ntype = 'height'\ncenter = [1.137, 0.622, 0]\n[[gauge]]\ntype = 'height'\ncenter = [0.5, 0.6, 0.1]\n",
      {});
  Particles particles = initial_particles(world, scene);
  for (Vec3& p : particles.position)
    if (p.z() < scene.fluid.spacing) p.z() -= 0.4 * scene.fluid.spacing;
  GaugeSeries gauges(world, {folder(), *scene.output.series, {}}, scene);
  gauges.observe({Clock{0, scene.dt}, particles, {}, nullptr, {}});
  if (rank_of(world) != 0) return;
  const std::vector<Real> row = rows_of(folder()).front();
  for (std::size_t k = 0; k < 2; ++k) EXPECT_NEAR(row[k + 2], 1.2, 1e-8) << k;
  EXPECT_NEAR(row[4], 1.1, 1e-8);  // with its foot in the water
}

// Water in which particles are as often at any place beside a wall as far from it shows its depth there, too: moved
// into the box as they are, cubes are too many from half a spacing to one off the wall and too few next to it.
TEST_F(Gauges, AHeightBesideWallsIsThatOfWaterWithoutLayers) {
  std::string text = pool;
  const std::vector<Vec3> feet{{0, 0.6, 0}, {0.1, 0.6, 0}, {0.2, 0.6, 0}, {0, 0, 0}, {0.2, 0.2, 0}, {1.8, 1, 0}};
  for (const Vec3& foot : feet)
    text += fmt::format("[[gauge]]\ntype = 'height'\ncenter = [{}, {}, {}]\n", foot.x(), foot.y(), foot.z());
  const Scene scene = parse_scene("test.toml", text, {});
  Particles particles = initial_particles(world, scene);
  for (Vec3& p : particles.position) {  // each of twelve layers has places of its own in its cells
    const auto layer = static_cast<int>(p.z() / scene.fluid.spacing);
    p.x() += scene.fluid.spacing * ((layer + 0.5) / 12 - 0.5);
    p.y() += scene.fluid.spacing * ((5 * layer % 12 + 0.5) / 12 - 0.5);
  }
  GaugeSeries gauges(world, {folder(), *scene.output.series, {}}, scene);
  const Clock clock{0, scene.dt};
  gauges.observe({clock, particles, {}, nullptr, {}});
  if (rank_of(world) != 0) return;
  const std::vector<Real> row = rows_of(folder()).front();
  for (std::size_t k = 0; k < feet.size(); ++k) EXPECT_NEAR(row[k + 2] / 1.2, 1, 0.01) << k;
}

// Of a block that turns and shears the velocity is exact, in the water and not only at particles; nothing is nan.
TEST_F(Gauges, AVelocityIsExactInALinearField) {
  const Scene scene = parse_scene("test.toml",
                                  pool +
                                      "[[gauge]]\ntype = 'velocity'\ncenter = [0.4321, 0.6123, 0.517]\n"
                                      "[[gauge]]\ntype = 'velocity'\ncenter = [0.45, 0.65, 0.55]\nradius = 0.37\n"
                                      "[[gauge]]\ntype = 'velocity'\ncenter = [0.5, 0.5, 1.7]\n",
                                  {});
  Eigen::Matrix3d slope;
  slope << 0.1, -2, 0.3, 1.5, 0.2, 0, -0.4, 0.7, -0.3;
  const auto field = [&](const Vec3& p) { return Vec3(Vec3(1, -2, 0.5) + slope * p); };
  Particles particles = initial_particles(world, scene);
  for (std::size_t i = 0; i < particles.id.size(); ++i) particles.velocity[i] = field(particles.position[i]);
  GaugeSeries gauges(world, {folder(), *scene.output.series, {}}, scene);
  const Clock clock{0, scene.dt};
  gauges.observe({clock, particles, {}, nullptr, {}});
  if (rank_of(world) != 0) return;
  const std::vector<Real> row = rows_of(folder()).front();
  for (std::size_t k = 0; k < 2; ++k)
    for (Eigen::Index a = 0; a < 3; ++a)
      EXPECT_NEAR(row[2 + 3 * k + static_cast<std::size_t>(a)], field(scene.gauges[k].center)[a], 1e-7) << k << a;
  EXPECT_TRUE(std::isnan(row[8]));
}

// At the end of a periodic axis, and in the midst of it: heights and flows of a lattice, also through a rectangle that
// is longer than the box, the velocity of a linear field, and what a floor gives are the same.
TEST_F(Gauges, GaugesSeeAcrossTheEndsOfPeriodicAxes) {
  std::string text = tank_with_gravity({.max = "2, 1.2, 1.8",
                                        .water = {{"0, 0, 0", "2, 1.2, 1.2", "velocity = [1.03, 0.4, 0]"}},
                                        .domain = "periodic = [\"x\", \"y\"]"}) +
                     "[output.series]\n";
  const std::vector<Vec3> feet = {{1, 0.6, 0}, {0, 0.6, 0}, {0.013, 0, 0}, {2, 1.2, 0}, {1.93, 0.02, 0}};
  for (const Vec3& foot : feet) {
    const auto table = [&](const char* type, Real z, const char* more) {
      text += fmt::format("[[gauge]]\ntype = '{}'\ncenter = [{}, {}, {}]\n{}", type, foot.x(), foot.y(), z, more);
    };
    table("height", 0, "");
    table("height", 0, "radius = 1.7\n");
    table("velocity", 0.6, "radius = 0.3\n");
    table("flow", 0.6, "normal = [1, 0, 0]\nsize = [0.5, 0.4]\n");
    table("flow", 0.6, "normal = [0, 1, 0]\nsize = [9, 0.4]\n");
  }
  const Scene scene = parse_scene("test.toml", text, {});
  Particles particles = initial_particles(world, scene);
  const Vec3 length = scene.domain.max - scene.domain.min;
  GaugeSeries gauges(world, {folder(), *scene.output.series, {}}, scene);
  gauges.observe({Clock{0, scene.dt}, particles, {}, nullptr, {}});
  Eigen::Matrix3d slope;
  slope << 0.1, -2, 0.3, 1.5, 0.2, 0, -0.4, 0.7, -0.3;
  const auto way = [&](const Vec3& p) {
    Vec3 from = p - feet[3];
    for (Eigen::Index a = 0; a < 2; ++a) from[a] -= length[a] * std::round(from[a] / length[a]);
    return from;
  };
  for (std::size_t i = 0; i < particles.id.size(); ++i)
    particles.velocity[i] = Vec3(1, -2, 0.5) + slope * (way(particles.position[i]) - Vec3(0, 0, 0.6));
  gauges.observe({Clock{1, scene.dt}, particles, {}, nullptr, {}});
  if (rank_of(world) != 0) return;
  const Rows rows = rows_of(folder());
  const std::vector<Real> expected = {1.2, 1.2, 1.03, 0.4, 0, 1.03 * 0.5 * 0.4, 0.4 * 2 * 0.4};
  for (std::size_t k = 0; k < feet.size(); ++k)
    for (std::size_t n = 0; n < expected.size(); ++n)
      EXPECT_NEAR(rows[0][2 + 7 * k + n], expected[n], 2e-8) << k << ' ' << n;
  for (std::size_t a = 0; a < 3; ++a) EXPECT_NEAR(rows[1][2 + 7 * 3 + 2 + a], Vec3(1, -2, 0.5)[Eigen::Index(a)], 1e-7);
}

TEST_F(Gauges, APressureIsTheSameAtTheEndOfAPeriodicAxis) {
  Settings settings = parse_scene("test.toml", pool, {});
  settings.periodic = {true, false, false};
  for (const Real x : {1.0, 0.0, 1.97}) settings.gauges.push_back({GaugeKind::pressure, {x, 0.6, 0}, {0, 0, 1}, 0.2});
  PressureGauges gauges(settings, [](const Vec3&) { return false; });
  for (int i = 0; i < 200; ++i)
    for (int j = 0; j < 120; ++j) gauges.add(Vec3(0, 0, 1e-6), Vec3(0.01 * i + 0.005, 0.01 * j + 0.005, 0.05));
  const std::vector<Real> pressed = gauges.total(MPI_COMM_SELF);
  EXPECT_GT(pressed[0], 0);
  for (const Real one : pressed) EXPECT_NEAR(one / pressed[0], 1, 1e-3);
}

TEST_F(Gauges, SameBitsOnAnyRanksAndThreads) {
  const std::string falling = pool + "[[particles]]\nmin = [0.2, 0.2, 1.3]\nmax = [0.8, 1, 1.7]\n" + tables_of(places);
  const std::string alone = path("alone_" + std::to_string(rank_of(world)));
  fs::create_directories(alone);
  run(MPI_COMM_SELF, falling, alone, 8);
  const std::string expected = text_of(alone + "/gauges.csv");
  for (const std::string& text : on_threads(folder() + "/gauges.csv", [&] { run(world, falling, folder(), 8); }))
    EXPECT_EQ(text, expected);
}

TEST_F(Gauges, AGaugeChangesNothing) {
  const GaugeRun with = run(world, pool + tables_of(places), folder(), 10), without = run(world, pool, folder(), 10);
  expect_same_bits(gathered(world, with.solver->particles()), gathered(world, without.solver->particles()));
}

TEST_F(Gauges, PressureNeedsAnObstacle) {
  Scene scene = parse_scene("test.toml", pool + tables_of(places), {});
  scene.obstacles.clear();
  const auto made = [&] { make_solver(world, scene, initial_particles(world, scene), {}); };
  EXPECT_NE(input_error_of(made).find("a gauge of pressure needs an obstacle"), std::string::npos);
}

}  // namespace
}  // namespace trevi::test
