// What a program may hand to make_solver() and must not: each is refused by an InputError on all ranks alike, nothing
// crashes and nobody waits. And what a caller's own objects may do wrong during a run.
#include <gmock/gmock.h>

#include <stdexcept>

#include "base/threads.hpp"
#include "small_tank.hpp"
#include "trevi/error.hpp"

namespace trevi::test {
namespace {

constexpr Real nan = std::numeric_limits<Real>::quiet_NaN();

ObstacleSettings ball() {
  ObstacleSettings one;
  one.center = Vec3(1.2, 0.4, 0.5);
  one.radius = 0.2;
  return one;
}

/// What make_solver() says; all ranks must say the same.
std::string refusal(const Settings& settings, Particles particles = block(world), SolverExtras extras = {}) {
  std::string said = "taken";
  try {
    make_solver(world, settings, std::move(particles), std::move(extras));
  } catch (const InputError& error) {
    said = error.what();
  }
  std::string first = said;
  int length = static_cast<int>(first.size());
  MPI_Bcast(&length, 1, MPI_INT, 0, world);
  first.resize(static_cast<std::size_t>(length));
  MPI_Bcast(first.data(), length, MPI_CHAR, 0, world);
  EXPECT_EQ(said, first);
  return said;
}

struct BadSettings {
  const char* words;
  std::function<void(Settings&)> spoil;
};

TEST(LibraryInput, SettingsThatCannotBeAreRefused) {
  EXPECT_EQ(refusal(tank()), "taken");
  const BadSettings all[] = {
      {"slab_axis", [](Settings& s) { s.slab_axis = 2; }},
      {"slab_axis", [](Settings& s) { s.slab_axis = 7; }},
      {"slab_axis", [](Settings& s) { s.slab_axis = -1; }},
      {"dt must", [](Settings& s) { s.dt = 0; }},
      {"dt must", [](Settings& s) { s.dt = -1; }},
      {"dt must", [](Settings& s) { s.dt = nan; }},
      {"cfl", [](Settings& s) { s.cfl = nan; }},
      {"max_substeps", [](Settings& s) { s.max_substeps = 0; }},
      {"density.crush_limit", [](Settings& s) { s.density.crush_limit = nan; }},
      {"gravity", [](Settings& s) { s.gravity = Vec3(0, nan, 0); }},
      {"domain", [](Settings& s) { s.domain.max.x() = nan; }},
      {"domain", [](Settings& s) { s.domain.max = s.domain.min; }},
      {"domain", [](Settings& s) { s.domain.max.z() = -1; }},
      {"spacing", [](Settings& s) { s.fluid.spacing = nan; }},
      {"rest_density", [](Settings& s) { s.fluid.rest_density = -1000; }},
      {"kernel_radius", [](Settings& s) { s.fluid.kernel_radius = 1e9; }},
      {"iterations", [](Settings& s) { s.density.iterations = 0; }},
      {"tolerance", [](Settings& s) { s.density.tolerance = -1; }},
      {"relaxation", [](Settings& s) { s.density.relaxation = nan; }},
      {"spectral_radius", [](Settings& s) { s.density.spectral_radius = 1; }},
      {"max_shift", [](Settings& s) { s.density.max_shift = -0.1; }},
      {"epsilon", [](Settings& s) { s.density.epsilon = nan; }},
      {"restitution", [](Settings& s) { s.walls.restitution = 5; }},
      {"floor_friction", [](Settings& s) { s.walls.floor_friction = -1; }},
      {"tensile",
       [](Settings& s) {
         s.tensile = TensileSettings{nan, 4, 0.2};
       }},
      {"tensile.dq",
       [](Settings& s) {
         s.tensile = TensileSettings{0.001, 4, 1};
       }},
      {"vorticity", [](Settings& s) { s.vorticity = nan; }},
      {"viscosity", [](Settings& s) { s.viscosity = -1; }},
      {"kinematic_viscosity", [](Settings& s) { s.kinematic_viscosity = -1e-6; }},
      {"kinematic_viscosity", [](Settings& s) { s.kinematic_viscosity = nan; }},
      {"no_slip", [](Settings& s) { s.no_slip = true; }},
      {"gauges[0].radius", [](Settings& s) { s.gauges.push_back({}); }},
      {"gauges[0].center",
       [](Settings& s) {
         s.gauges.push_back({GaugeKind::height, {nan, 0, 0}, {0, 0, 1}, 0.2});
       }},
      {"needs an obstacle",
       [](Settings& s) {
         s.gauges.push_back({GaugeKind::pressure, {0, 0.4, 0.2}, {1, 0, 0}, 0.2});
       }},
      {"gauges[0].size",
       [](Settings& s) {
         s.gauges.push_back({GaugeKind::flow, {0.4, 0.4, 0.2}, {1, 0, 0}, 0});
       }},
      {"an obstacle that stands",
       [](Settings& s) {
         s.gauges.push_back({GaugeKind::run_up, {0.4, 0.4, 0.2}, {1, 0, 0}, 0.2});
       }},
      {"needs density.coarse_grid",
       [](Settings& s) {
         s.density.coarse_grid = false;
         s.gauges.push_back({GaugeKind::pressure_in_water, {0.4, 0.4, 0.2}});
       }},
      {"dampings[0].direction",
       [](Settings& s) {
         s.dampings.push_back({s.domain.min, s.domain.max, 1, {}});
       }},
      {"dampings[0].rate",
       [](Settings& s) {
         s.dampings.push_back({s.domain.min, s.domain.max, nan, Vec3(Vec3::UnitX())});
       }},
      {"obstacles[0].wavemaker.period",
       [](Settings& s) {
         WavemakerSettings maker;
         maker.height = 0.01;
         maker.depth = 0.2;
         s.obstacles = {paddle_of(maker, s.domain)};
       }},
      {"obstacles[0].wavemaker.position",
       [](Settings& s) {
         WavemakerSettings maker;
         maker.height = 0.01;
         maker.depth = 0.2;
         maker.period = 1;
         maker.position = -1;
         s.obstacles = {paddle_of(maker, s.domain)};
       }},
  };
  for (const BadSettings& bad : all) {
    Settings settings = tank();
    bad.spoil(settings);
    EXPECT_THAT(refusal(settings), testing::HasSubstr(bad.words));
  }
}

TEST(LibraryInput, AnObstacleThatIsThereTwiceIsRefused) {
  Settings settings = tank();
  ObstacleSettings ball;
  ball.center = {0.4, 0.4, 0.2};
  ball.radius = 0.1;
  settings.obstacles = {ball, ball};
  EXPECT_THAT(refusal(settings), testing::HasSubstr("obstacles[1] is the same as obstacles[0]"));
}

struct BadObstacle {
  const char* words;
  std::function<void(ObstacleSettings&)> spoil;
};

std::shared_ptr<TriangleMesh> tetrahedron() {
  auto mesh = std::make_shared<TriangleMesh>();
  mesh->points = {{0, 0, 0}, {0.3, 0, 0}, {0, 0.3, 0}, {0, 0, 0.3}};
  mesh->triangles = {{0, 2, 1}, {0, 1, 3}, {0, 3, 2}, {1, 2, 3}};
  return mesh;
}

void make_mesh(ObstacleSettings& one, const std::function<void(TriangleMesh&)>& spoil) {
  const auto mesh = tetrahedron();
  spoil(*mesh);
  one.shape = ShapeKind::mesh;
  one.mesh = mesh;
}

TEST(LibraryInput, ObstaclesThatCannotBeAreRefused) {
  const BadObstacle all[] = {
      {"taken", [](ObstacleSettings&) {}},
      {"taken", [](ObstacleSettings& o) { make_mesh(o, [](TriangleMesh&) {}); }},
      {"obstacles[0].radius", [](ObstacleSettings& o) { o.radius = -1; }},
      {"obstacles[0].radius", [](ObstacleSettings& o) { o.radius = nan; }},
      {"size", [](ObstacleSettings& o) { o.shape = ShapeKind::box; }},
      {"height", [](ObstacleSettings& o) { o.shape = ShapeKind::cylinder; }},
      {"taken", [](ObstacleSettings& o) { o.shape = ShapeKind::basin, o.radius = 0.2, o.height = 0.2, o.wall = 0.05; }},
      {"wall", [](ObstacleSettings& o) { o.shape = ShapeKind::basin, o.radius = 0.2, o.height = 0.2; }},
      {"radius and height", [](ObstacleSettings& o) { o.shape = ShapeKind::basin, o.radius = 0, o.wall = 0.05; }},
      {"size",
       [](ObstacleSettings& o) {
         o.shape = ShapeKind::basin, o.size = {1, 0, 1}, o.wall = 0.05;
       }},
      {"oscillation.period",
       [](ObstacleSettings& o) {
         o.oscillation = Oscillation{{0.1, 0, 0}, {0, 0, 0}, 0, 0};
       }},
      {"oscillation must be finite",
       [](ObstacleSettings& o) {
         o.oscillation = Oscillation{{nan, 0, 0}, {0, 0, 0}, 1, 0};
       }},
      {"in place of",
       [](ObstacleSettings& o) {
         o.oscillation = Oscillation{{0.1, 0, 0}, {0, 0, 0}, 1, 0}, o.velocity = {1, 0, 0};
       }},
      {"tube", [](ObstacleSettings& o) { o.shape = ShapeKind::torus, o.tube = 0.3; }},
      {"axis", [](ObstacleSettings& o) { o.shape = ShapeKind::capsule, o.height = 1, o.axis.setZero(); }},
      {"center", [](ObstacleSettings& o) { o.center.z() = nan; }},
      {"center", [](ObstacleSettings& o) { o.rotate.z() = nan; }},
      {"velocities", [](ObstacleSettings& o) { o.angular_velocity.x() = INFINITY; }},
      {"restitution", [](ObstacleSettings& o) { o.restitution = 5; }},
      {"friction", [](ObstacleSettings& o) { o.friction = -1; }},
      {"order of their times",
       [](ObstacleSettings& o) {
         o.knots = {{1, {1, 0.4, 0.5}}, {0.5, {1.1, 0.4, 0.5}}};
       }},
      {"knots must be finite",
       [](ObstacleSettings& o) {
         o.knots = {{0, {1, 0.4, 0.5}}, {1, {nan, 0.4, 0.5}}};
       }},
      {"mesh must have triangles", [](ObstacleSettings& o) { o.shape = ShapeKind::mesh; }},
      {"no point", [](ObstacleSettings& o) { make_mesh(o, [](TriangleMesh& m) { m.triangles[0][1] = 99; }); }},
      {"no point", [](ObstacleSettings& o) { make_mesh(o, [](TriangleMesh& m) { m.triangles[3][2] = -1; }); }},
      {"not finite", [](ObstacleSettings& o) { make_mesh(o, [](TriangleMesh& m) { m.points[0].x() = nan; }); }},
      {"not closed", [](ObstacleSettings& o) { make_mesh(o, [](TriangleMesh& m) { m.triangles.pop_back(); }); }},
  };
  for (const BadObstacle& bad : all) {
    Settings settings = tank();
    settings.obstacles.push_back(ball());
    bad.spoil(settings.obstacles[0]);
    EXPECT_THAT(refusal(settings), testing::HasSubstr(bad.words));
  }
}

TEST(LibraryInput, SettingsThatAreWrongOnOneRankAreRefusedOnAll) {
  Settings settings = tank();
  if (rank_of(world) == size_of(world) - 1) settings.dt = 0;
  EXPECT_THAT(refusal(settings), testing::HasSubstr("dt must be positive"));
}

// The last rank alone brings what is wrong.
TEST(LibraryInput, ParticlesThatCannotBeAreRefusedOnAllRanks) {
  const auto spoiled = [](const std::function<void(Particles&)>& spoil) {
    Particles particles = block(world);
    if (rank_of(world) == size_of(world) - 1) spoil(particles);
    return refusal(tank(), particles);
  };
  using testing::HasSubstr;
  EXPECT_THAT(spoiled([](Particles& p) { p.velocity.pop_back(); }), HasSubstr("different lengths"));
  EXPECT_THAT(spoiled([](Particles& p) { p.position.pop_back(); }), HasSubstr("different lengths"));
  EXPECT_THAT(spoiled([](Particles& p) { p.predicted.resize(1); }), HasSubstr("different lengths"));
  EXPECT_THAT(spoiled([](Particles& p) { p.id[0] = -1; }), HasSubstr("must not be negative"));
  EXPECT_THAT(spoiled([](Particles& p) { p.id[0] = 17; }), HasSubstr("particle 17 is there twice"));
  EXPECT_THAT(spoiled([](Particles& p) { p.position[0].x() = nan; }), HasSubstr("outside the box"));
  EXPECT_THAT(spoiled([](Particles& p) { p.position[0].x() = 1.7; }), HasSubstr("outside the box"));
  EXPECT_THAT(spoiled([](Particles& p) { p.velocity[0].y() = INFINITY; }), HasSubstr("not finite"));
}

TEST(LibraryInput, ExtrasThatAreNullAreRefused) {
  SolverExtras forcing, observer;
  forcing.forcings.push_back(nullptr);
  observer.observers.push_back(nullptr);
  EXPECT_THAT(refusal(tank(), block(world), std::move(forcing)), testing::HasSubstr("a forcing is null"));
  EXPECT_THAT(refusal(tank(), block(world), std::move(observer)), testing::HasSubstr("an observer is null"));
}

using Act = std::function<void(Particles&, std::size_t)>;

/// Acts in the second step on the one rank that has particle 0.
struct OwnForcing : Forcing {
  explicit OwnForcing(Act acts) : act(std::move(acts)) {}
  void apply(Particles& particles, const StepInfo& info) override {
    const auto found = std::find(particles.id.begin(), particles.id.end(), 0);
    if (info.step == 1 && found != particles.id.end())
      act(particles, static_cast<std::size_t>(found - particles.id.begin()));
  }
  Act act;
};

enum class Fails { in_due, in_wants, in_observe };

/// Fails at the end of the first step on the last rank.
struct OwnObserver : Observer {
  explicit OwnObserver(Fails fails) : where(fails) {}
  bool due(const Clock& clock) const override {
    step = clock.step;
    fail(Fails::in_due);
    return true;
  }
  bool wants_density() const override {
    fail(Fails::in_wants);
    return false;
  }
  void observe(const Frame&) override { fail(Fails::in_observe); }
  void fail(Fails here) const {
    if (here == where && step == 1 && rank_of(world) == size_of(world) - 1) throw std::runtime_error("no paper");
  }
  Fails where;
  mutable std::int64_t step = 0;
};

/// Fails on the last rank when it is asked for its speed, or its state, of the second step.
struct UnknownForcing : Forcing {
  explicit UnknownForcing(bool of_speed) : speed(of_speed) {}
  void prepare(const StepInfo& info) override { step = info.step; }
  void apply(Particles&, const StepInfo&) override {}
  Real fastest(const TimeSpan&) const override { return speed ? fail() : 0; }
  std::optional<FountainState> state(Real) const override {
    if (!speed) fail();
    return std::nullopt;
  }
  Real fail() const {
    if (step == 1 && rank_of(world) == size_of(world) - 1) throw std::runtime_error("no wind");
    return 0;
  }
  bool speed;
  std::int64_t step = 0;
};

std::string end_of(SolverExtras extras) {
  const auto solver = make_solver(world, tank(), block(world), std::move(extras));
  solver->start();
  try {
    for (int k = 0; k < 3; ++k) solver->step();
  } catch (const RunError& error) {
    EXPECT_EQ(error.reach(), Reach::all_ranks);
    return error.what();
  }
  return "went well";
}

TEST(LibraryInput, AFailureOfACallersObjectOnOneRankEndsTheRunOnAll) {
  const auto with = [](Act act) {
    SolverExtras extras;
    extras.forcings.push_back(std::make_unique<OwnForcing>(std::move(act)));
    return end_of(std::move(extras));
  };
  using testing::HasSubstr;
  EXPECT_EQ(with([](Particles&, std::size_t) {}), "went well");
  EXPECT_THAT(with([](Particles&, std::size_t) { throw std::runtime_error("no wind"); }),
              HasSubstr("a forcing failed: no wind"));
  EXPECT_THAT(with([](Particles&, std::size_t) { throw 42; }), HasSubstr("a forcing failed"));
  EXPECT_THAT(with([](Particles& p, std::size_t) { p.velocity.pop_back(); }), HasSubstr("different lengths"));
  EXPECT_THAT(with([](Particles& p, std::size_t i) { p.position[i].z() = -3; }), HasSubstr("outside the box"));
  EXPECT_THAT(with([](Particles& p, std::size_t i) { p.velocity[i].z() = nan; }), HasSubstr("not a number"));
  for (const Fails where : {Fails::in_due, Fails::in_wants, Fails::in_observe}) {
    SolverExtras extras;
    extras.observers.push_back(std::make_unique<OwnObserver>(where));
    EXPECT_THAT(end_of(std::move(extras)), HasSubstr("an observer failed: no paper"));
  }
  SolverExtras speed, state;
  speed.forcings.push_back(std::make_unique<UnknownForcing>(true));
  EXPECT_THAT(end_of(std::move(speed)), HasSubstr("a forcing failed: no wind"));
  state.forcings.push_back(std::make_unique<UnknownForcing>(false));
  EXPECT_THAT(end_of(std::move(state)), HasSubstr("failed: no wind"));
}

// A solver goes on with the threads that there were when it was made: its memory for each of them goes by that.
TEST(LibraryInput, MoreThreadsWhileASolverLivesAreForTheNextOne) {
  struct Counter : Forcing {
    explicit Counter(int& seen) : largest(seen) {}
    void apply(Particles&, const StepInfo&) override { largest = std::max(largest, thread_count()); }
    int& largest;
  };
  Settings settings = tank();
  settings.obstacles.push_back(ball());
  const int before = thread_count();
  int most = 0;
  SolverExtras extras;
  extras.forcings.push_back(std::make_unique<Counter>(most));
  const auto solver = make_solver(world, settings, block(world), std::move(extras));
  Session::use_threads(before + 3);
  solver->start();
  for (int k = 0; k < 3; ++k) solver->step();
  EXPECT_EQ(most, before);
  EXPECT_EQ(thread_count(), before + 3);
  Session::use_threads(before);
}

}  // namespace
}  // namespace trevi::test
