// The guards of the step under sabotage: a forcing that spoils one particle on one rank. Every rank must throw the same
// BlowUp in that very step, and none may wait for another for ever. And what the step hands to observers.
#include <functional>

#include "fluid/kernels.hpp"
#include "output_fixture.hpp"
#include "parallel/vote.hpp"
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

/// A block of 10 x 4 x 4 particles that fills its box.
Particles block(const CellGrid& grid, const Slabs& slabs) {
  Particles particles;
  for (int n = 0; n < 160; ++n) {
    const int i = n / 16, j = n / 4 % 4, k = n % 4;
    const Vec3 place = 0.1 * Vec3(i + 0.5, j + 0.5, k + 0.5);
    if (slabs.owner(grid.plane_of(place)) != rank_of(world)) continue;
    particles.id.push_back(n);
    particles.position.push_back(place);
    particles.velocity.push_back(Vec3::Zero());
  }
  particles.predicted = particles.position;
  return particles;
}

SolverParts<double> parts_with(Sabotage sabotage) {
  SolverParts<double> parts;
  parts.comm = world;
  parts.box = {Vec3::Zero(), Vec3(1, 0.4, 0.6)};
  parts.grid = std::make_unique<CellGrid>(parts.box.min, parts.box.max, h, 0);
  parts.slabs =
      std::make_unique<Slabs>(std::vector<Real>(static_cast<std::size_t>(parts.grid->planes()), 1.0), size_of(world));
  parts.balance = std::make_unique<Balance>(world, 0.01);
  parts.walls = std::make_unique<Walls>(parts.box, WallSettings{}, 1e-6 * h);
  const DensityModel model{1.0, 1000, h, 1, Constraint::equality};
  parts.constraint = std::make_unique<DensityConstraint<double>>(model, std::nullopt, std::nullopt);
  DensitySettings settings;
  settings.method = Method::jacobi;
  settings.coarse_grid = false;
  parts.method = make_density_method<double>(settings, {world, *parts.grid, parts.box, model, h / 2, Vec3::Zero()});
  parts.forcings.push_back(std::make_unique<Saboteur>(std::move(sabotage)));
  parts.clock.dt = 0.01;
  parts.particles = block(*parts.grid, *parts.slabs);
  return parts;
}

/// What the run ends with, and in which step.
std::string blow_up_of(Sabotage sabotage) {
  PbfSolver<double> solver(parts_with(std::move(sabotage)));
  solver.start();
  try {
    for (int k = 0; k < 10; ++k) solver.step();
  } catch (const BlowUp& error) {
    EXPECT_EQ(solver.clock().step + 1, bad_step);
    EXPECT_EQ(error.reach(), Reach::all_ranks);
    return error.what();
  }
  return "no blow-up";
}

std::string last_rank() { return "rank " + std::to_string(size_of(world) - 1) + ", step 4"; }

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
  // The count is kept, so that the crowd alone is wrong: all of the particles of a rank come to one place, many times.
  PbfSolver<double> solver([] {
    SolverParts<double> parts = parts_with([](Particles&) {});
    if (rank_of(world) == 0) {
      const std::size_t n = parts.particles.id.size();
      parts.particles.resize(n + 5000);
      for (std::size_t k = n; k < n + 5000; ++k) {
        parts.particles.id[k] = static_cast<GlobalId>(1000 + k);
        parts.particles.position[k] = Vec3(0.05, 0.05, 0.05);
        parts.particles.velocity[k] = Vec3::Zero();
      }
    }
    return parts;
  }());
  try {
    solver.start();
    FAIL() << "no blow-up";
  } catch (const BlowUp& error) {
    expect_mentions(error.what(), {"rank 0", "more than 4096 neighbours", "smaller dt"});
  }
}

TEST(Guards, RequestsOfOneRankReachAll) {
  SolverParts<double> parts = parts_with([](Particles&) {});
  std::int64_t polls = 0;
  parts.requests = [&polls]() -> RequestCounts {
    ++polls;
    const bool mine = polls >= 3 && rank_of(world) == size_of(world) - 1;
    return {mine ? 1 : 0, 0, 0, 0, 0, 0};
  };
  PbfSolver<double> solver(std::move(parts));
  solver.start();  // the first poll
  solver.step();
  EXPECT_EQ(count_of(solver.requests(), Request::checkpoint), 0);
  solver.step();
  EXPECT_EQ(count_of(solver.requests(), Request::checkpoint), 1);
  EXPECT_FALSE(stop_reason(solver.requests()).has_value());
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
  SolverParts<double> parts = parts_with([](Particles&) {});
  auto* onlooker = new Onlooker;
  parts.observers.emplace_back(onlooker);
  PbfSolver<double> solver(std::move(parts));
  solver.start();
  EXPECT_EQ(onlooker->given, solver.particles().id.size());
  onlooker->wants = false;
  solver.step();
  EXPECT_EQ(onlooker->given, 0U);
}

}  // namespace
}  // namespace trevi
