// Trevi as a library: solvers one after the other and side by side in one process, on communicators of the caller's,
// with forcings of the caller's and particles that the caller changes between steps.
#include "small_tank.hpp"
#include "trevi/error.hpp"

namespace trevi::test {
namespace {

/// A communicator for the life of the object.
struct Half {
  Half() { MPI_Comm_split(world, rank_of(world) % 2, 0, &comm); }
  ~Half() { MPI_Comm_free(&comm); }
  MPI_Comm comm = MPI_COMM_NULL;
  int number = rank_of(world) % 2;
};

/// Blows along x, the stronger the higher up.
struct Wind : Forcing {
  void apply(Particles& particles, const StepInfo& info) override {
    for (std::size_t i = 0; i < particles.id.size(); ++i)
      particles.velocity[i].x() += 2 * particles.position[i].z() * info.dt;
  }
};

std::unique_ptr<Solver> tank_solver(MPI_Comm comm, const Settings& settings = tank()) {
  SolverExtras extras;
  extras.forcings.push_back(std::make_unique<Wind>());
  return make_solver(comm, settings, block(comm), std::move(extras));
}

Cloud after(Solver& solver, MPI_Comm comm, int steps) {
  for (int k = 0; k < steps; ++k) solver.step();
  return gathered(comm, solver.particles());
}

void expect_same(const Cloud& a, const Cloud& b) {
  EXPECT_EQ(a.id, b.id);
  EXPECT_EQ(a.position, b.position);
  EXPECT_EQ(a.velocity, b.velocity);
}

TEST(Library, SolversOneAfterTheOther) {
  Cloud first;
  for (int turn = 0; turn < 3; ++turn) {
    const std::unique_ptr<Solver> solver = tank_solver(world);
    const Cloud now = after(*solver, world, 20);
    if (turn == 0) first = now;
    expect_same(first, now);
    Real wind = 0;
    for (const Vec3& v : now.velocity) wind += v.x();
    EXPECT_GT(wind, 10) << "the caller's forcing was not called";
  }
}

TEST(Library, SolversSideBySideOnSplitCommunicators) {
  const Half half;
  Settings settings = tank(half.number == 0 ? Precision::double_ : Precision::single);
  if (half.number == 1) settings.vorticity = 0.002;  // so that the halves log different events
  const std::unique_ptr<Solver> shared = tank_solver(half.comm, settings);
  const std::unique_ptr<Solver> alone = tank_solver(MPI_COMM_SELF, settings);
  expect_same(after(*shared, half.comm, 20), after(*alone, MPI_COMM_SELF, 20));
}

TEST(Library, TwoSolversInTurns) {
  const std::unique_ptr<Solver> one = tank_solver(world), other = tank_solver(world, tank(Precision::single));
  for (int k = 0; k < 10; ++k) {
    one->step();
    other->step();
  }
  const std::unique_ptr<Solver> alone = tank_solver(world);
  expect_same(gathered(world, one->particles()), after(*alone, world, 10));
}

TEST(Library, MessagesMeetNoneOfTheCallers) {
  int mine = rank_of(world), theirs = -1;
  MPI_Request request = MPI_REQUEST_NULL;
  // Open during the steps, from any rank with any tag: it would swallow a message of the solver on this communicator.
  MPI_Irecv(&theirs, 1, MPI_INT, MPI_ANY_SOURCE, MPI_ANY_TAG, world, &request);
  const std::unique_ptr<Solver> solver = tank_solver(world);
  solver->step();
  MPI_Send(&mine, 1, MPI_INT, (mine + 1) % size_of(world), 7, world);
  MPI_Wait(&request, MPI_STATUS_IGNORE);
  EXPECT_EQ(theirs, (mine + size_of(world) - 1) % size_of(world));
}

/// Changed between steps is as made anew from what the change left.
TEST(Library, ParticlesThatTheCallerChanges) {
  const std::unique_ptr<Solver> solver = tank_solver(world);
  after(*solver, world, 5);
  solver->change_particles([](Particles& p) {
    for (std::size_t i = 0; i < p.id.size(); ++i) {
      p.position[i].x() = 1.6 - p.position[i].x();  // the mirror image, on other ranks
      p.velocity[i] = Vec3(-1, 0.5, 0);
    }
    if (rank_of(world) == 0) {  // and one more
      p.id.push_back(1000);
      p.position.emplace_back(0.3, 0.4, 1.0);
      p.velocity.emplace_back(0, 0, -1);
    }
  });
  const Cloud changed = gathered(world, solver->particles());
  ASSERT_EQ(changed.id.size(), 385U);
  SolverExtras extras;
  extras.forcings.push_back(std::make_unique<Wind>());
  const Cloud mine = slice_of(changed, rank_of(world), size_of(world));
  Particles start;
  start.id = mine.id;
  start.position = mine.position;
  start.velocity = mine.velocity;
  const std::unique_ptr<Solver> anew = make_solver(world, tank(), std::move(start), std::move(extras));
  expect_same(after(*solver, world, 10), after(*anew, world, 10));
}

TEST(Library, RefusesWhatCannotBeDoneOnAllRanksAlike) {
  Particles outside = block(world);
  if (rank_of(world) == size_of(world) - 1) outside.position.back() = Vec3(0, 0, 7);
  EXPECT_THROW(make_solver(world, tank(), outside), InputError);
  const std::unique_ptr<Solver> solver = tank_solver(world);
  const auto leave = [](Particles& p) {
    if (rank_of(world) == 0) p.position[0] = Vec3(-1, 0, 0);
  };
  EXPECT_THROW(solver->change_particles(leave), BlowUp);
  const std::unique_ptr<Solver> other = tank_solver(world);
  const auto cut = [](Particles& p) {
    if (rank_of(world) == 0) p.velocity.pop_back();
  };
  EXPECT_THROW(other->change_particles(cut), RunError);
}

TEST(Library, RefusesSettingsThatCannotBe) {
  const auto refused = [](const std::function<void(Settings&)>& spoil) {
    Settings settings = tank();
    spoil(settings);
    EXPECT_THROW(make_solver(world, settings, block(world)), InputError);
  };
  refused([](Settings& s) { s.fluid.spacing = 0; });
  refused([](Settings& s) { s.fluid.spacing = NAN; });
  refused([](Settings& s) { s.fluid.kernel_radius = 0.5; });
  refused([](Settings& s) { s.fluid.density_kernel = "gauss"; });
  refused([](Settings& s) { s.domain.max.y() = 0.1; });
  refused([](Settings& s) { s.dt = -1; });
  refused([](Settings& s) { s.density.constraint = Constraint::equality; });
  refused([](Settings& s) {
    s.kinematic_viscosity = 100;
    s.cfl = 0;
  });
  refused([](Settings& s) { s.viscosity = s.kinematic_viscosity = 0.001; });
}

}  // namespace
}  // namespace trevi::test
