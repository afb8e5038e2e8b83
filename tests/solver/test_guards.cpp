// The guards of the step under sabotage: a forcing that spoils one particle on one rank. Every rank must throw the same
// BlowUp in that very step, and none may wait for another for ever. And what the step hands to observers.
#include <functional>
#include <numeric>

#include "support/output_fixture.hpp"
#include "trevi/error.hpp"
#include "trevi/solver.hpp"

namespace trevi {
namespace {

constexpr Real h = 0.2;
constexpr std::int64_t bad_step = 4;

using Sabotage = std::function<void(Particles&)>;

/// Spoils the particles of the last rank in the fourth step.
class Saboteur : public Forcing {
 public:
  explicit Saboteur(Sabotage sabotage) : sabotage_(std::move(sabotage)) {}
  void apply(Particles& particles, const StepInfo& info) override {
    if (info.step + 1 == bad_step && rank_of(world) == size_of(world) - 1) sabotage_(particles);
  }

 private:
  Sabotage sabotage_;
};

/// A block of 10 x 4 x 4 particles that fills its box; every rank brings its share.
Particles block() {
  Particles particles;
  for (int n = rank_of(world); n < 160; n += size_of(world)) {
    const int i = n / 16, j = n / 4 % 4, k = n % 4;
    particles.id.push_back(n);
    particles.position.push_back(0.1 * Vec3(i + 0.5, j + 0.5, k + 0.5));
    particles.velocity.push_back(Vec3::Zero());
  }
  return particles;
}

Settings box_of_water() {
  Settings settings;
  settings.domain = {Vec3::Zero(), Vec3(1, 0.4, 0.6)};
  settings.slabs = SlabCuts::equal;
  settings.dt = 0.01;
  settings.density.method = Method::jacobi;
  settings.walls.density = WallDensity::none;
  return settings;
}

std::unique_ptr<Solver> solver_with(Sabotage sabotage, Particles particles = block()) {
  SolverExtras extras;
  extras.forcings.push_back(std::make_unique<Saboteur>(std::move(sabotage)));
  return make_solver(world, box_of_water(), std::move(particles), std::move(extras));
}

/// What the run ends with, and in which step.
std::string blow_up_of(Sabotage sabotage) {
  const std::unique_ptr<Solver> solver = solver_with(std::move(sabotage));
  solver->start();
  try {
    for (int k = 0; k < 10; ++k) solver->step();
  } catch (const BlowUp& error) {
    EXPECT_EQ(solver->clock().step + 1, bad_step);
    EXPECT_EQ(error.reach(), Reach::all_ranks);
    return error.what();
  }
  return "no blow-up";
}

std::string last_rank() { return "rank " + std::to_string(size_of(world) - 1) + ", step 4"; }

std::string end_of(const std::function<void()>& run) {
  try {
    run();
  } catch (const BlowUp& error) {
    EXPECT_EQ(error.reach(), Reach::all_ranks);
    return error.what();
  }
  return "no blow-up";
}

// What lies on one another is crushed, whoever brings it, as soon as it no longer flies apart.
TEST(Guards, EveryParticleFourTimesEndsTheRun) {
  Particles more = block();
  const std::size_t own = more.id.size();
  for (std::size_t k = 0; k < 3 * own; ++k) {
    more.id.push_back(more.id[k % own] + 160 * (1 + static_cast<GlobalId>(k / own)));
    more.position.push_back(more.position[k % own]);
    more.velocity.push_back(Vec3::Zero());
  }
  Settings settings = box_of_water();
  settings.domain.max.z() = 0.4;  // no space to go to
  const auto solver = make_solver(world, settings, more);
  solver->start();
  EXPECT_EQ(solver->counters().compression.first_crushed, 0);
  const std::string end = end_of([&] {
    for (int k = 0; k < 10; ++k) solver->step();
  });
  expect_mentions(end, {"compressed by", "in the mean", "lie on one another"});
}

// A fifth too dense is told, with the first step; a hundredth is not. The mass of the report with Spiky is such.
TEST(Guards, CrushedWaterIsToldWithItsFirstStep) {
  Settings settings = box_of_water();
  settings.density.method = Method::chebyshev;
  settings.walls.density = WallDensity::analytic;
  settings.gravity = Vec3(0, 0, -9.8);
  for (const bool by_volume : {false, true}) {
    settings.fluid.mass = by_volume ? Mass::volume : Mass::calibrated;
    const auto solver = make_solver(world, settings, block());
    solver->start();
    for (int k = 0; k < 5; ++k) solver->step();
    const Solver::Counters::Compression seen = solver->counters().compression;
    EXPECT_EQ(seen.first_crushed, by_volume ? 0 : -1);
    EXPECT_NEAR(seen.largest, by_volume ? 0.2 : 0, by_volume ? 0.06 : 0.01);
  }
}

TEST(Guards, AStepOfTooManySubstepsEndsTheRun) {
  Settings settings = box_of_water();
  settings.cfl = 1;
  settings.max_substeps = 20;
  for (const Real speed : {150.0, 1500.0}) {  // 8 and 75 substeps
    Particles particles = block();
    for (Vec3& v : particles.velocity) v.x() = speed;
    const auto solver = make_solver(world, settings, particles);
    const std::string end = end_of([&] { solver->step(); });
    if (speed < 1000) {
      EXPECT_EQ(end, "no blow-up");
    } else {
      expect_mentions(end, {"step 1", "75 substeps", "time.max_substeps is 20"});
    }
  }
}

TEST(Guards, NothingWrong) {
  EXPECT_EQ(blow_up_of([](Particles&) {}), "no blow-up");
}

TEST(Guards, VelocityThatIsNotANumber) {
  const auto message = blow_up_of([](Particles& p) { p.velocity[0].y() = std::nan(""); });
  expect_mentions(message, {last_rank(), "particle ", "not a number", "smaller dt"});
}

TEST(Guards, InfiniteVelocity) {
  const auto message = blow_up_of([](Particles& p) { p.velocity[0].x() = INFINITY; });
  expect_mentions(message, {last_rank(), "particle ", "not a number"});
}

TEST(Guards, LostParticleIsNamed) {
  GlobalId lost = -1;
  const auto message = blow_up_of([&](Particles& p) {
    lost = p.id.back();
    p.resize(p.id.size() - 1);
  });
  MPI_Bcast(&lost, 1, MPI_INT64_T, size_of(world) - 1, world);
  expect_mentions(message, {"step 4", "particle " + std::to_string(lost) + " is lost", "last checkpoint"});
}

TEST(Guards, DoubledParticleIsNamed) {
  GlobalId twice = -1;
  const auto message = blow_up_of([&](Particles& p) {
    twice = p.id.front();
    p.for_each_field([](auto& field) { field.push_back(field.front()); });
  });
  MPI_Bcast(&twice, 1, MPI_INT64_T, size_of(world) - 1, world);
  expect_mentions(message, {"step 4", "particle " + std::to_string(twice) + " is there twice"});
}

TEST(Guards, OneLostAndAnotherTwice) {
  expect_mentions(blow_up_of([](Particles& p) { p.id[0] = p.id[1]; }), {"step 4", "some are lost, some there twice"});
}

TEST(Guards, ManyLostAreCounted) {
  expect_mentions(blow_up_of([](Particles& p) { p.resize(p.id.size() - 3); }), {"157 particles instead of 160"});
}

TEST(Guards, CrowdOnOneRank) {
  // 5,000 particles more in one place.
  Particles particles = block();
  if (rank_of(world) == 0) {
    const std::size_t n = particles.id.size();
    particles.id.resize(n + 5000);
    std::iota(particles.id.begin() + static_cast<std::ptrdiff_t>(n), particles.id.end(), GlobalId{1000});
    particles.position.resize(n + 5000, Vec3(0.05, 0.05, 0.05));
    particles.velocity.resize(n + 5000, Vec3::Zero());
  }
  const std::unique_ptr<Solver> solver = solver_with([](Particles&) {}, std::move(particles));
  try {
    solver->start();
    FAIL() << "no blow-up";
  } catch (const BlowUp& error) {
    expect_mentions(error.what(), {"rank 0", "more than 4096 neighbours", "smaller dt"});
  }
}

TEST(Guards, RequestsOfOneRankReachAll) {
  std::int64_t polls = 0;
  SolverExtras extras;
  extras.requests = [&polls]() -> RequestCounts {
    ++polls;
    const bool mine = polls >= 3 && rank_of(world) == size_of(world) - 1;
    return {mine ? 1 : 0, 0, 0, 0, 0, 0};
  };
  const std::unique_ptr<Solver> solver = make_solver(world, box_of_water(), block(), std::move(extras));
  solver->start();  // the first poll
  solver->step();
  EXPECT_EQ(count_of(solver->requests(), Request::checkpoint), 0);
  solver->step();
  EXPECT_EQ(count_of(solver->requests(), Request::checkpoint), 1);
  EXPECT_FALSE(stop_reason(solver->requests()).has_value());
}

/// Looks at every step and counts the densities it is given.
struct Onlooker : Observer {
  bool wants = true;
  std::size_t given = 0;
  bool due(const Clock&) const override { return true; }
  bool wants_density() const override { return wants; }
  void observe(const Frame& frame) override { given = frame.density.size(); }
};

TEST(Observers, DensitiesAreThereWhenAskedForAndThenOnly) {
  auto* onlooker = new Onlooker;
  SolverExtras extras;
  extras.observers.emplace_back(onlooker);
  const std::unique_ptr<Solver> solver = make_solver(world, box_of_water(), block(), std::move(extras));
  solver->start();
  EXPECT_EQ(onlooker->given, solver->particles().id.size());
  onlooker->wants = false;
  solver->step();
  EXPECT_EQ(onlooker->given, 0);
}

}  // namespace
}  // namespace trevi
