// Gauges that need no surface: the pressure in still water is rho g d, the flow of a lattice that moves as a whole is
// speed times area, water at rest on a slope stands at its level, and none of it depends on ranks or threads.
#include <fmt/format.h>

#include <cmath>
#include <filesystem>
#include <sstream>

#include "io/tables/body_series.hpp"
#include "io/tables/gauge_series.hpp"
#include "io/tables/obstacle_series.hpp"
#include "parallel/collective.hpp"
#include "support/cloud.hpp"
#include "support/output_fixture.hpp"
#include "support/tank.hpp"
#include "trevi/scene.hpp"
#include "trevi/solver.hpp"

namespace trevi::test {
namespace {

const std::string tank =
    tank_with_gravity({.max = "2, 1.2, 1.8", .water = {{"0, 0, 0", "2, 1.2, 1.2"}}}) + "[output.gauges]\n";

using Rows = std::vector<std::vector<Real>>;

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

std::string pressure_at(const Vec3& p) {
  return fmt::format("[[gauge]]\ntype = 'pressure'\ncenter = [{}, {}, {}]\n", p.x(), p.y(), p.z());
}

std::unique_ptr<Solver> run(MPI_Comm comm, const std::string& text, const std::string& folder, int steps) {
  const Scene scene = parse_scene("test.toml", text, {});
  SolverExtras extras;
  extras.observers.push_back(
      std::make_unique<GaugeSeries>(comm, TableOptions{folder, *scene.output.gauges, {}}, scene));
  auto solver = make_solver(comm, scene, initial_particles(comm, scene), std::move(extras));
  solver->start();
  for (int k = 0; k < steps; ++k) solver->step();
  return solver;
}

class Probes : public Output {};

// Pressures and forces are means over the steps since the row before, whatever other observers have rows in between.
TEST_F(Probes, OtherObserversTakeNothingOfAMean) {
  const std::string text = tank +
                           "[[obstacle]]\ntype = 'sphere'\ncenter = [1, 0.6, 0.4]\nradius = 0.3\n"
                           "[[gauge]]\ntype = 'pressure'\ncenter = [0, 0.6, 0.5]\nnormal = [1, 0, 0]\n";
  const Scene scene = parse_scene("test.toml", text, {});
  struct Other : Observer {
    bool due(const Clock& clock) const override { return clock.step % 7 == 0; }
    bool wants_forces() const override { return true; }
    void observe(const Frame&) override {}
  };
  const auto last_row = [&](int every, int other, bool with_others) {
    const std::string into = fmt::format("{}/{}_{}", folder(), other, with_others);
    on_root(world, [&] { std::filesystem::create_directory(into); });
    SolverExtras extras;
    extras.observers.push_back(std::make_unique<GaugeSeries>(world, TableOptions{into, Schedule{0, every}, {}}, scene));
    const TableOptions options{into, Schedule{0, other}, {}};
    extras.observers.push_back(std::make_unique<ObstacleSeries>(world, options, 1));
    extras.observers.push_back(std::make_unique<BodySeries>(world, options, 0, 1));
    if (with_others) extras.observers.push_back(std::make_unique<Other>());
    auto solver = make_solver(world, scene, initial_particles(world, scene), std::move(extras));
    solver->start();
    for (int k = 0; k < 12; ++k) solver->step();
    return into;
  };
  const std::string whole = last_row(12, 12, false), often = last_row(12, 5, true), forces = last_row(5, 12, true);
  if (rank_of(world) != 0) return;
  EXPECT_GT(rows_of(whole).back()[2], 100);
  EXPECT_EQ(rows_of(often).back()[2], rows_of(whole).back()[2]);
  EXPECT_EQ(text_of(forces + "/obstacles.csv"), text_of(whole + "/obstacles.csv"));
}

// In the open, at walls, in corners, between cells and in the air; without an obstacle.
TEST_F(Probes, StillWaterHasThePressureOfItsDepth) {
  const std::vector<Vec3> places = {{0.73, 0.61, 0.3}, {1, 0.6, 0.1}, {0, 0.6, 0.55},  {2, 1.2, 0},
                                    {1.1, 0.1, 0.8},   {1, 0.6, 1.7}, {0.4, 1.2, 1.05}};
  std::string text = tank;
  for (const Vec3& place : places) text += pressure_at(place);
  run(world, text, folder(), 60);
  if (rank_of(world) != 0) return;
  const Rows rows = rows_of(folder());
  ASSERT_EQ(rows.size(), 61u);
  for (std::size_t k = 0; k < places.size(); ++k) {
    Real mean = 0;
    for (std::size_t n = 21; n < rows.size(); ++n) mean += rows[n][k + 2] / 40;
    const Real expected = 1000 * 9.8 * std::max(0.0, 1.2 - places[k].z());
    EXPECT_NEAR(mean, expected, 0.02 * 1000 * 9.8 * 1.2) << k;
    EXPECT_EQ(rows.front()[k + 2], 0);
  }
}

// All of it, a part of it, across it, against it, and from below, wherever the rectangle is in the lattice.
TEST_F(Probes, AFlowIsSpeedTimesArea) {
  struct Case {
    const char* keys;
    Real expected;
  };
  const Vec3 speed(0.7, -0.2, 0.3);
  const std::vector<Case> cases = {
      {"center = [1.0, 0.6, 0.6]\nsize = [1.2, 1.2]\nnormal = [1, 0, 0]", 0.7 * 1.2 * 1.2},
      {"center = [1.0317, 0.6, 0.9]\nsize = [2, 1.8]\nnormal = [1, 0, 0]", 0.7 * 1.2 * 1.2},
      {"center = [0.77, 0.5123, 0.4141]\nsize = [0.333, 0.217]\nnormal = [-2, 0, 0]", -0.7 * 0.333 * 0.217},
      {"center = [0.9, 0.613, 0.5]\nsize = [0.4, 0.45]\nnormal = [0, 1, 0]", -0.2 * 0.4 * 0.45},
      {"center = [0.9, 0.6, 0.519]\nsize = [0.31, 0.5]\nnormal = [0, 0, 1]", 0.3 * 0.31 * 0.5},
      {"center = [1, 0.6, 1.6]\nsize = [0.3, 0.1]\nnormal = [1, 0, 0]", 0}};
  std::string text = tank;
  for (const Case& one : cases) text += fmt::format("[[gauge]]\ntype = 'flow'\n{}\n", one.keys);
  const Scene scene = parse_scene("test.toml", text, {});
  Particles particles = initial_particles(world, scene);
  std::fill(particles.velocity.begin(), particles.velocity.end(), speed);
  GaugeSeries gauges(world, {folder(), *scene.output.gauges, {}}, scene);
  const Clock clock{0, scene.dt};
  gauges.observe({clock, particles, {}, nullptr, {}});
  if (rank_of(world) != 0) return;
  const std::vector<Real> row = rows_of(folder()).front();
  for (std::size_t k = 0; k < cases.size(); ++k) EXPECT_NEAR(row[k + 2], cases[k].expected, 1e-7) << k;
}

// Particles come nearer to walls than half a spacing, and their cubes still are in the box: through a rectangle from
// wall to wall and from the floor on goes all of the water.
TEST_F(Probes, AFlowFromWallToWallMissesNothing) {
  const Scene scene = parse_scene(
      "test.toml", tank + "[[gauge]]\ntype = 'flow'\ncenter = [1, 0.6, 0.9]\nsize = [1.2, 1.8]\nnormal = [1, 0, 0]\n",
      {});
  Particles particles = initial_particles(world, scene);
  std::fill(particles.velocity.begin(), particles.velocity.end(), Vec3(0.7, 0, 0));
  for (Vec3& p : particles.position) {
    if (p.y() < 0.1) p.y() = 0.01;
    if (p.y() > 1.1) p.y() = 1.18;
    if (p.z() < 0.1) p.z() = 0.02;
  }
  GaugeSeries gauges(world, {folder(), *scene.output.gauges, {}}, scene);
  const Clock clock{0, scene.dt};
  gauges.observe({clock, particles, {}, nullptr, {}});
  if (rank_of(world) != 0) return;
  EXPECT_NEAR(rows_of(folder()).front()[2], 0.7 * 1.2 * 1.2, 1e-7);
}

// Water cut by a beach of 1 in 1 that begins at x = 0.5: its edge is at its level to a spacing, in the strip and not
// beyond it.
TEST_F(Probes, WaterAtRestOnABeachStandsAtItsLevel) {
  const std::string text = tank +
                           "[[obstacle]]\ntype = 'box'\nrotate = [0, -45, 0]\nsize = [6, 3, 2]\n"
                           "center = [1.2071067812, 0.6, -0.7071067812]\n"
                           "[[gauge]]\ntype = 'run_up'\ncenter = [0, 0.6, 0.2]\nnormal = [1, 0, 0]\nradius = 0.3\n"
                           "[[gauge]]\ntype = 'run_up'\ncenter = [1.99, 0.6, 0.2]\nnormal = [3, 0, 0]\nradius = 0.3\n";
  const Scene scene = parse_scene("test.toml", text, {});
  const Particles particles = initial_particles(world, scene);
  GaugeSeries gauges(world, {folder(), *scene.output.gauges, {}}, scene);
  const Clock clock{0, scene.dt};
  gauges.observe({clock, particles, {}, nullptr, {}});
  if (rank_of(world) != 0) return;
  const std::vector<Real> row = rows_of(folder()).front();
  EXPECT_NEAR(row[2], 1.2 - 0.2, 0.1);
  EXPECT_LE(row[2], 1.2 - 0.2 + 1e-12);
  EXPECT_TRUE(std::isnan(row[3]));
}

TEST_F(Probes, ALineIsAsManyGauges) {
  const Scene line = parse_scene(
      "test.toml", tank + "[[gauge]]\ntype = 'height'\ncenter = [0.2, 0.6, 0]\nto = [1.8, 0.6, 0]\ncount = 5\n", {});
  ASSERT_EQ(line.gauges.size(), 5u);
  for (std::size_t k = 0; k < 5; ++k) EXPECT_NEAR(line.gauges[k].center.x(), 0.2 + 0.4 * static_cast<Real>(k), 1e-12);
}

TEST_F(Probes, SameBitsOnAnyRanksAndThreads) {
  const std::string falling = tank + "[[particles]]\nmin = [0.2, 0.2, 1.3]\nmax = [0.8, 1, 1.7]\n" +
                              pressure_at({0.5, 0.6, 0.3}) + pressure_at({1.03, 0.4, 0.7}) +
                              "[[gauge]]\ntype = 'flow'\ncenter = [1, 0.6, 0.6]\nsize = [1, 1]\nnormal = [1, 0.2, 0]\n";
  const std::string alone = path("alone_" + std::to_string(rank_of(world)));
  fs::create_directories(alone);
  run(MPI_COMM_SELF, falling, alone, 8);
  const std::string expected = text_of(alone + "/gauges.csv");
  for (const std::string& text : on_threads(folder() + "/gauges.csv", [&] { run(world, falling, folder(), 8); }))
    EXPECT_EQ(text, expected);
}

TEST_F(Probes, AProbeChangesNothing) {
  const auto with = run(world, tank + pressure_at({0.5, 0.6, 0.3}), folder(), 10);
  const Scene scene = parse_scene("test.toml", tank, {});
  const auto without = make_solver(world, scene, initial_particles(world, scene), {});
  without->start();
  for (int k = 0; k < 10; ++k) without->step();
  expect_same_bits(gathered(world, with->particles()), gathered(world, without->particles()));
}

}  // namespace
}  // namespace trevi::test
