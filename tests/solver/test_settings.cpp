// What settings of a scene mean for the steps of a run: defaults that are written out, a tolerance, pumps and the
// choice of substeps, and what the series tells of it.
#include <cstring>

#include "scene/scene_defaults.hpp"
#include "support/cloud.hpp"
#include "support/output_fixture.hpp"
#include "support/tank.hpp"

namespace trevi::test {
namespace {

// A cube thrown into a wall at 12 m/s, so that some steps are split, and others not.
const std::string thrown_cube = tank_with_gravity({.min = "0.0, 0.0, 0.0",
                                                   .max = "1.6, 0.8, 1.2",
                                                   .water = {{"0.6, 0.1, 0.3", "1.2, 0.7, 0.9"}},
                                                   .dt = "0.0333333333",
                                                   .end = "1.0"}) +
                                R"(acceleration = [12, 0, -9.8]
)";

TEST(Settings, DefaultsWrittenOutAreTheSameRun) {
  const Scene scene = scene_with(thrown_cube, {});
  const std::unique_ptr<Solver> absent = started(scene);
  std::vector<std::string> defaults = defaults_of_all_scenes(scene);
  std::erase(defaults, "time.cfl=2");  // it would hide that another key changes cfl
  const std::unique_ptr<Solver> written = started(scene_with(thrown_cube, defaults));
  for (int k = 0; k < 15; ++k) {
    absent->step();
    written->step();
  }
  const Cloud a = gathered(world, absent->particles()), b = gathered(world, written->particles());
  expect_same_bits(a, b);
  EXPECT_EQ(absent->counters().substeps, written->counters().substeps);
  EXPECT_GT(absent->counters().substeps, 15) << "a run whose steps are never split proves less";
}

// ---- tolerance ----------------------------------------------------------------------------------------------------

struct Solved {
  std::int64_t iterations, unconverged;
  Cloud particles;
};

/// A step of a cloud that is too dense in places, to a mean compression of 3 %.
Solved solved(std::int64_t iterations, const std::vector<std::string>& method) {
  std::vector<std::string> overrides = {"density.constraint='inequality'", "density.tolerance=0.03",
                                        "density.iterations=" + std::to_string(iterations)};
  overrides.insert(overrides.end(), method.begin(), method.end());
  const Scene scene = scene_with(cloud_scene, overrides);
  const std::unique_ptr<Solver> solver = solver_of(world, scene, random_cloud(1800, box_of(scene), 0.1, 0.02));
  solver->step();
  return {solver->counters().iterations, solver->counters().unconverged, gathered(world, solver->particles())};
}

// As many sweeps as it takes are enough, and one fewer is not.
TEST(Tolerance, MetByTheLastSweepIsMet) {
  for (const char* method : {"density.method='jacobi'", "density.method='chebyshev'", "density.method='anderson'"}) {
    for (const char* coarse : {"density.coarse_grid=false", "density.coarse_grid=true"}) {
      SCOPED_TRACE(std::string(method) + " " + coarse);
      const Solved enough = solved(500, {method, coarse});
      ASSERT_EQ(enough.unconverged, 0);
      ASSERT_GT(enough.iterations, 3) << "a tolerance that is met at once proves nothing";
      const Solved exact = solved(enough.iterations, {method, coarse});
      EXPECT_EQ(exact.iterations, enough.iterations);
      EXPECT_EQ(exact.unconverged, 0);
      EXPECT_TRUE(same_bits(exact.particles.position, enough.particles.position));
      EXPECT_EQ(solved(enough.iterations - 1, {method, coarse}).unconverged, 1);
    }
  }
}

// ---- substeps -------------------------------------------------------------------------------------------------------

class Series : public Output {
 protected:
  /// Columns of the series of so many steps, one vector a row.
  std::vector<std::vector<Real>> rows_of(const Scene& scene, int steps, const std::vector<std::string>& columns) const {
    BuildOptions options;
    options.progress = ProgressMode::none;
    options.directory = path("run");
    const std::unique_ptr<Solver> solver = build_solver(world, scene, std::move(options));
    solver->start();
    for (int k = 0; k < steps; ++k) solver->step();
    barrier();
    std::istringstream lines(text_of(path("run/series.csv")));
    const std::vector<std::string> header = cells_of(lines);
    std::vector<std::vector<Real>> rows;
    for (std::vector<std::string> cells = cells_of(lines); !cells.empty(); cells = cells_of(lines)) {
      rows.emplace_back();
      for (const std::string& column : columns) {
        const auto at = std::find(header.begin(), header.end(), column) - header.begin();
        rows.back().push_back(std::stod(cells.at(static_cast<std::size_t>(at))));
      }
    }
    return rows;
  }

 private:
  static std::vector<std::string> cells_of(std::istringstream& lines) {
    std::string line, cell;
    std::getline(lines, line);
    std::istringstream stream(line);
    std::vector<std::string> cells;
    while (std::getline(stream, cell, ',')) cells.push_back(cell);
    return cells;
  }
};

TEST_F(Series, IterationsAreThoseOfAllSubsteps) {
  const Scene scene = scene_with(thrown_cube, {"output.series.every_steps=1"});
  bool split = false;
  for (const std::vector<Real>& row : rows_of(scene, 12, {"step", "substeps", "iterations"})) {
    EXPECT_EQ(row[2], row[0] == 0 ? 0 : 3 * row[1]) << "step " << row[0];
    split = split || row[1] > 1;
  }
  EXPECT_TRUE(split);
}

// The pump starts at 0.05 s, in the middle of the second step, and gives 20 m/s at once.
TEST_F(Series, AStepInWhichAPumpStartsIsSplitForIt) {
  const Scene scene = scene_with(
      thrown_cube, {"output.series.every_steps=1", "particles.0.min=[0,0,0]", "particles.0.max=[1.6, 0.8, 0.4]",
                    "gravity.acceleration=[0,0,-9.8]", "fountain.0.center=[0.8,0.4]", "fountain.0.diameter=0.4",
                    "fountain.0.start=0.05", "fountain.0.speed=20"});
  const auto rows = rows_of(scene, 2, {"substeps", "speed_max"});
  EXPECT_EQ(rows[1][0], 1);
  EXPECT_EQ(rows[2][0], 2) << "20 m/s · 1/30 s is 1.67 of the 2 · 0.2 m that a substep may go";
}

// Water bears the acceleration of its vessel as it bears its weight. Of motion that goes to and fro by 0.3 m in 0.345 s
// that is up to 10 g, a hundredth less in the mean over a part of it; of one in 1.1 s it is less than g.
TEST_F(Series, StepsInWhichAVesselIsShakenAreSplitForIt) {
  const auto substeps = [&](const std::string& period) {
    const Scene scene = scene_with(
        thrown_cube,
        {"output.series.every_steps=1", "time.dt=0.0166666667", "gravity.acceleration=[0,0,-9.8]",
         "obstacle.0.type='box'", "obstacle.0.center=[0.8,0.4,0.4]", "obstacle.0.size=[0.6,0.6,0.6]",
         "obstacle.0.inside=true", "obstacle.0.motion={type='sine', amplitude=[0.3,0,0], period=" + period + "}"});
    Real most = 0;
    for (const std::vector<Real>& row : rows_of(scene, 12, {"substeps"})) most = std::max(most, row[0]);
    return most;
  };
  EXPECT_EQ(substeps("0.345"), 2) << "0.25 √(h/a) is 0.011 s";
  EXPECT_EQ(substeps("1.1"), 1) << "0.25 √(h/g) is 0.036 s";
}

}  // namespace
}  // namespace trevi::test
