// Inlets and drains: the amount, the places and the budget, on any ranks and for any step.
#include <cmath>
#include <numeric>
#include <set>

#include <fmt/format.h>

#include "cloud.hpp"
#include "output_fixture.hpp"

namespace trevi::test {
namespace {

constexpr Real spacing = 0.1;

// A shaft without water, wide enough for a jet.
const std::string shaft = R"(
[domain]
min = [0, 0, 0]
max = [1.6, 0.9, 3.0]
[fluid]
spacing = 0.1
[time]
dt = 0.0166666667
end = 2
)";

const std::string jet = R"(
[[inlet]]
center = [0.8, 0.45, 2.9]
direction = [0, 0, -1]
radius = 0.2
)";

const std::string bottom = "[[drain]]\ntype = \"plane\"\ncenter = [0, 0, 0.3]\naxis = [0, 0, -1]\n";

// A pool that an inlet stirs from below, a jet from above, and a drain at one side.
const std::string fountain = R"(
[domain]
min = [0, 0, 0]
max = [1.6, 0.8, 1.6]
[fluid]
spacing = 0.1
[[particles]]
min = [0, 0, 0]
max = [1.6, 0.8, 0.5]
[time]
dt = 0.0166666667
end = 2
[gravity]
[[inlet]]
type = "rectangle"
center = [0.4, 0.4, 0.15]
direction = [0.3, 0, 1]
size = [0.3, 0.3]
speed = 2.5
jitter = 0.5
recycle = true
[[inlet]]
center = [1.0, 0.4, 1.4]
direction = [1, 0.2, -0.5]
radius = 0.15
flow = 0.1
start = 0.1
stop = 0.45
[[drain]]
type = "cylinder"
center = [1.3, 0.4, 0.2]
radius = 0.25
height = 0.4
[output.series]
every_steps = 1
)";

std::unique_ptr<Solver> solver_of(MPI_Comm comm, const Scene& scene, std::vector<std::unique_ptr<Observer>> see = {}) {
  SolverExtras extras;
  extras.forcings = make_fountains(comm, scene);
  extras.flow = make_flow(comm, scene);
  extras.observers = std::move(see);
  return make_solver(comm, scene, initial_particles(comm, scene), std::move(extras));
}

GlobalId total(const Solver& solver) {
  GlobalId sum = solver.particles().size();
  MPI_Allreduce(MPI_IN_PLACE, &sum, 1, MPI_INT64_T, MPI_SUM, world);
  return sum;
}

void run(Solver& solver, Real seconds) {
  solver.start();
  const auto steps = std::llround(seconds / solver.clock().dt);
  for (std::int64_t k = 0; k < steps; ++k) solver.step();
}

// Without gravity the jet stays a lattice, and with it the amount is the same.
TEST(Inlet, BringsWhatIsAskedInAnyStep) {
  constexpr Real flow = 0.25, seconds = 1.2;
  for (const Real dt : {0.003, 0.0166666667, 0.05}) {
    for (const char* weight : {"", "[gravity]\n"}) {
      SCOPED_TRACE(fmt::format("dt {} s {}", dt, weight));
      const Scene scene = scene_with(shaft + weight + jet + "flow = 0.25\n" + bottom, {fmt::format("time.dt={}", dt)});
      const std::unique_ptr<Solver> solver = solver_of(world, scene);
      run(*solver, seconds);
      const auto volume = static_cast<Real>(solver->flow()->inflow) * spacing * spacing * spacing;
      const Real layer = 12 * spacing * spacing * spacing;
      EXPECT_NEAR(volume, flow * solver->clock().time(), layer * 1.01);
      EXPECT_GT(volume, flow * solver->clock().time() * 0.95);
      EXPECT_EQ(solver->flow()->inflow - solver->flow()->outflow, total(*solver));
    }
  }
}

// Over a longer time the last layer hardly counts.
TEST(Inlet, BringsWhatIsAskedToOnePercent) {
  const Scene scene = scene_with(shaft + "[gravity]\n" + jet + bottom, {"inlet.0.speed=5.3"});
  const std::unique_ptr<Solver> solver = solver_of(world, scene);
  run(*solver, 2);
  const Real asked = 12 * 5.3 * solver->clock().time() / spacing;
  EXPECT_NEAR(static_cast<Real>(solver->flow()->inflow) / asked, 1, 0.01);
  EXPECT_GT(solver->flow()->outflow, 0);
}

TEST(Inlet, LayersAreASpacingApartInAnyStep) {
  for (const Real dt : {0.003, 0.0166666667, 0.05}) {
    for (const char* speed : {"0.7", "2.0", "7.0"}) {
      SCOPED_TRACE(fmt::format("dt {} s, {} m/s", dt, speed));
      const Scene scene =
          scene_with(shaft + jet, {fmt::format("inlet.0.speed={}", speed), fmt::format("time.dt={}", dt)});
      const std::unique_ptr<Solver> solver = solver_of(world, scene);
      run(*solver, 0.38);
      const Cloud water = gathered(world, solver->particles());
      ASSERT_GT(water.id.size(), 12U);
      EXPECT_EQ(water.id.size() % 12, 0U) << "a disc of 0.2 m has 12 places";
      for (std::size_t k = 0; k < water.id.size(); ++k) {
        EXPECT_EQ(water.id[k], static_cast<GlobalId>(k));
        const std::size_t below = k + 12;  // the place in the next layer
        if (below >= water.id.size()) continue;
        EXPECT_NEAR((water.position[below] - water.position[k] - Vec3(0, 0, spacing)).norm(), 0, 1e-9);
        EXPECT_NEAR((water.velocity[k] - Vec3(0, 0, -std::stod(speed))).norm(), 0, 1e-9);
      }
    }
  }
}

// What is there at each step, beside what should be.
class Budget : public Observer {
 public:
  bool due(const Clock&) const override { return true; }
  void observe(const Frame& frame) override {
    const FlowState& flow = *frame.flow;
    const std::vector<GlobalId> ids = gathered(world, frame.particles.id);
    const std::set<GlobalId> different(ids.begin(), ids.end());
    EXPECT_EQ(different.size(), ids.size());
    const auto there = static_cast<GlobalId>(ids.size());
    if (start_ < 0) start_ = there;
    EXPECT_EQ(there, start_ + flow.inflow - flow.outflow);
    EXPECT_EQ(flow.next_id, start_ + flow.inflow) << "a block has the ids from 0";
    EXPECT_TRUE(ids.empty() || *different.rbegin() < flow.next_id);
    EXPECT_GE(flow.waiting, 0);
    EXPECT_LE(flow.waiting, flow.outflow);
  }

 private:
  GlobalId start_ = -1;
};

TEST(Flow, BudgetIsExactInEveryStep) {
  for (const char* precision : {"single", "double"}) {
    const Scene scene = scene_with(fountain, {fmt::format("density.precision='{}'", precision)});
    std::vector<std::unique_ptr<Observer>> observers;
    observers.push_back(std::make_unique<Budget>());
    const std::unique_ptr<Solver> solver = solver_of(world, scene, std::move(observers));
    run(*solver, 0.6);
    EXPECT_GT(solver->flow()->inflow, 100);
    EXPECT_GT(solver->flow()->outflow, 100);
  }
}

// Closed: what is in the scene and what waits are always what there was, and the inlet keeps within what it was given.
TEST(Flow, RecyclingLosesAndMakesNothing) {
  const Scene scene = scene_with(fountain, {"inlet.1.recycle=true", "inlet.1.stop=9", "inlet.0.speed=5"});
  const std::unique_ptr<Solver> solver = solver_of(world, scene);
  solver->start();
  const GlobalId start = total(*solver);
  for (int k = 0; k < 60; ++k) {
    solver->step();
    EXPECT_EQ(total(*solver) + solver->flow()->waiting, start);
  }
  EXPECT_GT(solver->flow()->inflow, 200);
}

TEST(Inlet, WaitsForWaterWhereItRecycles) {
  const std::string small = "[[drain]]\nmin = [1.4, 0, 0]\nmax = [1.6, 0.9, 3]\n";
  const Scene scene = scene_with(shaft + "[gravity]\n" + jet + small, {"inlet.0.recycle=true", "inlet.0.speed=2"});
  const std::unique_ptr<Solver> solver = solver_of(world, scene);
  run(*solver, 0.5);
  EXPECT_EQ(total(*solver), 0);
  EXPECT_EQ(solver->flow()->inflow, 0);
}

// A full box has little room. With room again on one side, that side alone is filled.
TEST(Inlet, LeavesOutPlacesThatAreTaken) {
  const std::string full = R"(
[domain]
min = [0, 0, 0]
max = [1.2, 0.6, 0.6]
[fluid]
spacing = 0.1
[[particles]]
min = [0, 0, 0]
max = [1.2, 0.6, 0.6]
[time]
dt = 0.01
end = 1
[[inlet]]
type = "rectangle"
center = [0.6, 0.3, 0.33]
direction = [0, 0, -1]
size = [0.4, 0.4]
speed = 1.0
)";
  // What enters pushes the water in a ring through the box, which makes some places free; nearly as many are in the
  // way.
  const std::unique_ptr<Solver> closed = solver_of(world, scene_with(full, {}));
  run(*closed, 0.5);
  EXPECT_LE(closed->flow()->inflow, 60) << "of 80 that were asked for";
  // The left half of the box is empty: only there places are free at first.
  const Scene half = scene_with(full, {"particles.0.min=[0.6, 0, 0]"});
  const std::unique_ptr<Solver> open = solver_of(world, half);
  for (int k = 0; k < 12; ++k) open->step();
  const Cloud water = gathered(world, open->particles());
  const GlobalId first_new = 6 * 6 * 6;
  EXPECT_EQ(open->flow()->inflow, 8);
  for (std::size_t k = 0; k < water.id.size(); ++k) {
    EXPECT_TRUE(water.id[k] < first_new || water.position[k].x() < 0.6);
  }
}

// No particle is made on top of another.
TEST(Inlet, KeepsHalfASpacingFromWater) {
  const Scene scene = scene_with(fountain, {"inlet.0.speed=1.0", "inlet.0.recycle=false"});
  const std::unique_ptr<Solver> solver = solver_of(world, scene);
  solver->start();
  GlobalId known = solver->flow()->next_id;
  for (int k = 0; k < 40; ++k) {
    const Cloud before = gathered(world, solver->particles());
    solver->step();
    // Those made in this step, where they were made: a step before where they are.
    const Cloud after = gathered(world, solver->particles());
    for (std::size_t i = 0; i < after.id.size(); ++i) {
      if (after.id[i] < known) continue;
      const Vec3 made = after.position[i] - solver->clock().dt * after.velocity[i];
      Real nearest = 1;
      for (const Vec3& p : before.position) nearest = std::min(nearest, (p - made).norm());
      EXPECT_GT(nearest, 0.45 * spacing);
    }
    known = solver->flow()->next_id;
  }
}
// Level jets: after x m beyond the nozzle all water has fallen for x/u s, however many layers a substep makes.
TEST(Inlet, AJetHasOnePathInAnyStep) {
  const std::string level = "[[inlet]]\ncenter = [0.1, 0.45, 2.5]\ndirection = [1, 0, 0]\nradius = 0.2\n";
  for (const Real dt : {0.003, 0.0166666667, 0.05}) {
    for (const Real speed : {2.0, 7.0, 12.0}) {
      SCOPED_TRACE(fmt::format("dt {} s, {} m/s", dt, speed));
      const Scene scene = scene_with(shaft + "[gravity]\n" + level,
                                     {fmt::format("inlet.0.speed={}", speed), fmt::format("time.dt={}", dt),
                                      "time.cfl=0"});
      const std::unique_ptr<Solver> solver = solver_of(world, scene);
      run(*solver, 1.0 / speed);
      const Cloud water = gathered(world, solver->particles());
      ASSERT_GT(water.id.size(), 60U);
      for (std::size_t k = 0; k < water.id.size(); ++k) {
        const Real flown = std::max(0.0, water.position[k].x() - 0.1 - spacing) / speed;
        EXPECT_NEAR(water.velocity[k].z(), -9.8 * flown, 0.01) << water.position[k].x();
        EXPECT_NEAR(water.velocity[k].y(), 0, 1e-3);
      }
    }
  }
}

// A plate that is before half of the opening from the start, and one that comes to stand in all of it.
TEST(Inlet, MakesNothingInASolidNorBehindOne) {
  const std::string plate = "[[obstacle]]\ntype = \"box\"\nsize = [0.8, 0.9, 0.1]\n";
  const auto flow_of = [&](const std::string& more, const std::vector<std::string>& changes) {
    const Scene scene = scene_with(shaft + "[gravity]\n" + jet + "speed = 3\n" + bottom + plate + more, changes);
    const std::unique_ptr<Solver> solver = solver_of(world, scene);
    run(*solver, 1);
    for (const Vec3& v : solver->particles().velocity) EXPECT_LT(v.norm(), 8.5) << "3 m/s and a fall of 3 m";
    return solver->flow()->streams[0];
  };
  const FlowState::Stream open = flow_of("center = [0.4, 0.45, 0.9]\n", {});
  EXPECT_EQ(open.covered, 0);
  EXPECT_NEAR(open.made, open.asked(), 1e-9);
  const FlowState::Stream half = flow_of("center = [0.4, 0.45, 2.85]\n", {"inlet.0.center=[0.8, 0.45, 2.95]"});
  EXPECT_NEAR(half.covered, half.asked() / 2, half.asked() / 12);
  const FlowState::Stream shut = flow_of("center = [0.8, 0.45, 2.3]\nvelocity = [0, 0, 0.8]\n",
                                          {"obstacle.0.size=[0.8, 0.9, 0.5]"});
  EXPECT_GT(shut.covered, shut.asked() / 3);
  EXPECT_LT(shut.made, 2 * shut.asked() / 3);
  EXPECT_NEAR(shut.asked(), open.asked(), 24);
}

// Water between an opening and a wall a spacing away falls, as nothing holds it there.
TEST(Inlet, FacingAWallLeavesNothingInTheAir) {
  const std::string facing = "[[inlet]]\ncenter = [1.5, 0.45, 2.0]\ndirection = [1, 0, 0]\nradius = 0.2\nspeed = 2\n";
  const Scene scene = scene_with(shaft + "[gravity]\n" + facing, {"inlet.0.stop=0.5"});
  const std::unique_ptr<Solver> solver = solver_of(world, scene);
  run(*solver, 0.5);
  EXPECT_GT(total(*solver), 12);
  for (int k = 0; k < 60; ++k) solver->step();
  for (const Vec3& p : solver->particles().position) EXPECT_FALSE(p.x() > 1.5 && std::abs(p.z() - 2) < 0.25) << p;
}


TEST(Drain, TakesWhatIsInsideAndNothingElse) {
  const Scene scene = scene_with(cloud_scene + R"(
[[drain]]
min = [0.0, 0.3, 0.2]
max = [0.4, 0.7, 0.6]
[[drain]]
type = "cylinder"
center = [0.6, 0.7, 0.5]
axis = [1, 1, 0]
radius = 0.2
height = 0.4
[[drain]]
type = "plane"
center = [0.9, 0, 0]
axis = [2, 0, 1]
)",
                                 {});
  const Cloud cloud = random_cloud(900, box_of(scene), 0.5);
  std::set<GlobalId> left;
  for (std::size_t k = 0; k < cloud.id.size(); ++k) {
    const Vec3 p = cloud.position[k], off = p - Vec3(0.6, 0.7, 0.5), axis = Vec3(1, 1, 0) / std::sqrt(2.0);
    const Real along = off.dot(axis);
    const bool in_box = p.x() > 0 && p.x() < 0.4 && p.y() > 0.3 && p.y() < 0.7 && p.z() > 0.2 && p.z() < 0.6;
    const bool in_cylinder = along > 0 && along < 0.4 && (off - along * axis).norm() < 0.2;
    if (!in_box && !in_cylinder && 2 * (p.x() - 0.9) + p.z() <= 0) left.insert(cloud.id[k]);
  }
  Cloud mine = slice_of(cloud, rank_of(world), size_of(world));
  Particles particles;
  particles.id = mine.id;
  particles.position = mine.position;
  particles.velocity = mine.velocity;
  SolverExtras extras;
  extras.flow = make_flow(world, scene);
  const std::unique_ptr<Solver> solver = make_solver(world, scene, std::move(particles), std::move(extras));
  solver->step();
  const Cloud after = gathered(world, solver->particles());
  EXPECT_EQ(std::set<GlobalId>(after.id.begin(), after.id.end()), left);
  EXPECT_EQ(static_cast<std::size_t>(solver->flow()->outflow), cloud.id.size() - left.size());
  EXPECT_EQ(solver->flow()->waiting, 0) << "nobody recycles";
}

/// Loses one particle of the last rank that has any.
class Thief : public Forcing {
 public:
  void apply(Particles& particles, const StepInfo& info) override {
    if (info.step == 20 && particles.size() > 0 && !done_) particles.resize(particles.id.size() - 1);
    if (info.step == 20) done_ = true;
  }

 private:
  bool done_ = false;
};

TEST(Flow, ALostParticleIsStillFound) {
  const Scene scene = scene_with(fountain, {});
  SolverExtras extras;
  extras.flow = make_flow(world, scene);
  extras.forcings.push_back(std::make_unique<Thief>());
  const std::unique_ptr<Solver> solver = make_solver(world, scene, initial_particles(world, scene), std::move(extras));
  std::string message = "none";
  try {
    for (int k = 0; k < 30; ++k) solver->step();
  } catch (const BlowUp& error) {
    message = error.what();
  }
  EXPECT_EQ(solver->clock().step, 20);
  EXPECT_NE(message.find("step 21"), std::string::npos) << message;
}

TEST(Flow, SameBitsOnAnyRanks) {
  for (const char* key : {"density.precision='double'", "density.precision='single'", "domain.max=[1.6, 1.8, 1.6]",
                          "particles.0.max=[0.3, 0.8, 0.5]"}) {  // the last leaves ranks empty
    SCOPED_TRACE(key);
    const Scene scene = scene_with(fountain, {key});
    const std::unique_ptr<Solver> many = solver_of(world, scene), one = solver_of(MPI_COMM_SELF, scene);
    for (int k = 0; k < 40; ++k) {
      many->step();
      one->step();
      EXPECT_EQ(many->flow()->next_id, one->flow()->next_id);
      EXPECT_EQ(many->flow()->waiting, one->flow()->waiting);
    }
    expect_same_bits(gathered(world, many->particles()), gathered(MPI_COMM_SELF, one->particles()));
  }
}

// Behind a weir, an obstacle from wall to wall: the tank fills to its edge, and then stays: as much runs over as comes.
TEST(Flow, TankFillsToItsWeirAndStays) {
  constexpr Real weir = 0.5, area = 0.8 * 0.6, flow = 0.06, volume = spacing * spacing * spacing;
  const Scene scene = read_scene(world, TREVI_INPUTS "/../tests/mpi/weir.toml");
  std::vector<std::unique_ptr<Observer>> observers;
  observers.push_back(std::make_unique<Budget>());
  const std::unique_ptr<Solver> solver = solver_of(world, scene, std::move(observers));
  solver->start();
  std::vector<GlobalId> there, gone;
  for (int second = 0; second <= 15; ++second) {
    there.push_back(total(*solver));
    gone.push_back(solver->flow()->outflow);
    if (rank_of(world) == 0)
      std::printf("%2d s: %lld particles, %lld have come, %lld gone\n", second, static_cast<long long>(there.back()),
                  static_cast<long long>(solver->flow()->inflow), static_cast<long long>(gone.back()));
    for (int k = 0; k < 60; ++k) solver->step();
  }
  EXPECT_LT(gone[3], 10) << "drops of the splash";
  for (std::size_t k = 6; k < there.size(); ++k) {
    const Real level = static_cast<Real>(there[k]) * volume / area;
    EXPECT_GT(level, weir) << k;
    EXPECT_LT(level, weir + 0.25) << k << ": 0.12 m runs over the edge by the formula of weirs";
  }
  constexpr std::size_t full = 7, last = 15;
  const Real mean =
      static_cast<Real>(std::accumulate(there.begin() + full, there.end(), GlobalId{0})) / (last - full + 1);
  for (std::size_t k = full; k <= last; ++k) EXPECT_NEAR(static_cast<Real>(there[k]) / mean, 1, 0.05) << k;
  const Real brought = (last - full) * flow;
  EXPECT_NEAR(static_cast<Real>(gone[last] - gone[full]) * volume, brought, 0.05 * brought);
}

}  // namespace
}  // namespace trevi::test
