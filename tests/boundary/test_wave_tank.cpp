// Waves in a small tank: they have the height of theory, nothing leaks at the paddle, bits do not know the ranks, a
// restart is exact, and a paddle absorbs what comes back to it.
#include <fmt/format.h>

#include <cmath>
#include <numbers>

#include "boundary/geometry/pose.hpp"
#include "boundary/waves/wave_theory.hpp"
#include "io/tables/gauge_readings.hpp"
#include "support/cloud.hpp"
#include "support/output_fixture.hpp"
#include "support/tank.hpp"
#include "trevi/scene.hpp"
#include "trevi/solver.hpp"

namespace trevi::test {
namespace {

// 30 spacings a wavelength on 7 layers, a wavelength to the zone.
std::string tank(const std::string& keys, const std::string& more = "") {
  return tank_with_gravity({.max = "7.2, 0.4, 1.4", .water = {{"0, 0, 0", "7.2, 0.4, 0.7"}}, .end = "30"}) + R"(
[[damping]]
min = [4.2, 0, 0]
max = [7.2, 0.4, 1.4]
rate = 6
[output.gauges]
[[wavemaker]]
)" + keys +
         "\n" + more;
}

const std::string piston = "type = 'piston'\nheight = 0.25\nperiod = 1.46\nposition = 0.4";

class WaveTank : public Output {};

// Linear theory: the first harmonic where no wave comes back, half a wavelength before the zone. What 30 spacings a
// wavelength do to a wave, and a second from the last few periods, leave it within an eighth.
TEST_F(WaveTank, APistonMakesWavesOfTheHeight) {
  const Scene scene =
      parse_scene("test.toml", tank(piston, "[[gauge]]\ntype = 'height'\ncenter = [2.4, 0.2, 0]\n"), {});
  auto solver = make_solver(world, scene, initial_particles(world, scene), {});
  GaugeReadings readings(world, scene);
  solver->start();
  const Real omega = 2 * std::numbers::pi / 1.46;
  Real sine = 0, cosine = 0;
  const int first = 613, count = 438;  // five periods
  for (int n = 0; n < first + count; ++n) {
    solver->step();
    if (n < first) continue;
    const Real h = readings.read({solver->clock(), solver->particles(), {}, nullptr, {}}).front();
    sine += 2 * h * std::sin(omega * solver->clock().time()) / count;
    cosine += 2 * h * std::cos(omega * solver->clock().time()) / count;
  }
  if (rank_of(world) == 0) std::printf("H over that of theory: %.3f\n", 2 * std::hypot(sine, cosine) / 0.25);
  EXPECT_NEAR(2 * std::hypot(sine, cosine) / 0.25, 1, 0.125);
}

// The water that a paddle moves is on the other side of it: nothing leaks, and bits do not know the ranks.
TEST_F(WaveTank, SameBitsOnAnyRanksAndNothingLeaks) {
  for (const std::string& keys :
       {piston,
        std::string("type = 'flap'\nwave = 'irregular'\nheight = 0.2\nperiod = 1.5\nposition = 0.5\nramp = 0.2"),
        std::string("type = 'piston'\nwave = 'solitary'\nheight = 0.2\ndirection = [-1, 0, 0]"),
        piston + "\nabsorb = true\nramp = 0"}) {
    const Scene scene = parse_scene("test.toml", tank(keys), {});
    const auto run = [&](MPI_Comm comm) {
      auto solver = make_solver(comm, scene, initial_particles(comm, scene), {});
      solver->start();
      for (int n = 0; n < 40; ++n) solver->step();
      return solver;
    };
    const auto alone = run(MPI_COMM_SELF), all = run(world);
    expect_same_bits(gathered(world, all->particles()), gathered(MPI_COMM_SELF, alone->particles()));
    const WavemakerSettings& maker = *scene.obstacles.front().wavemaker;
    const BodyMotion motion(scene.obstacles.front());
    const Pose pose = motion.at(all->clock().time());
    if (maker.absorb) continue;  // the face is where the water has led it
    const Vec3 half = scene.obstacles.front().size / 2;
    for (const Vec3& p : all->particles().position) {
      const Real ahead = pose.into_body(p).dot(maker.direction) - half[maker.direction.x() != 0 ? 0 : 1];
      EXPECT_GT(ahead, -1e-6);
    }
  }
}

// Where the paddles that absorb are at the end of a step.
struct Offsets : Observer {
  std::vector<Real>& offsets;
  explicit Offsets(std::vector<Real>& w) : offsets(w) {}
  bool due(const Clock&) const override { return true; }
  void observe(const Frame& frame) override {
    offsets.assign(frame.paddle_offsets.begin(), frame.paddle_offsets.end());
  }
};

// A run that goes on from step 20 has the bits of one that did not stop, and takes a paddle that absorbs from where it
// was.
TEST_F(WaveTank, ARestartIsExact) {
  for (const bool absorb : {false, true}) {
    Scene scene = parse_scene("test.toml", tank(piston), {});
    scene.obstacles.front().wavemaker->absorb = absorb;
    std::vector<Real> offsets;
    SolverExtras first, second;
    first.observers.push_back(std::make_unique<Offsets>(offsets));
    auto whole = make_solver(world, scene, initial_particles(world, scene), std::move(first));
    whole->start();
    for (int n = 0; n < 20; ++n) whole->step();
    EXPECT_EQ(offsets.size(), absorb ? 3u : 0u);
    if (absorb) {
      EXPECT_NE(offsets[0], 0);
    }
    second.step = 20;
    second.substeps = whole->clock().substeps;
    second.paddle_offsets = offsets;
    auto rest = make_solver(world, scene, whole->particles(), std::move(second));
    for (int n = 0; n < 20; ++n) {
      whole->step();
      rest->step();
    }
    expect_same_bits(gathered(world, rest->particles()), gathered(world, whole->particles()));
  }
}

// A zone takes nothing of the weight of still water, which stays where it is, to rounding. Found: 8e-16 m/s, and 0.12
// where zones came after gravity.
TEST_F(WaveTank, StillWaterInAZoneStaysStill) {
  const Scene scene =
      parse_scene("test.toml",
                  tank_with_gravity({.max = "2.4, 0.4, 1.4", .water = {{"0, 0, 0", "2.4, 0.4, 1"}}, .end = "1"}) +
                      "[[damping]]\nmin = [1.2, 0, 0]\nmax = [2.4, 0.4, 1.4]\nrate = 6\ndirection = [1, 0, 0]\n",
                  {});
  auto solver = make_solver(world, scene, initial_particles(world, scene), {});
  solver->start();
  for (int n = 0; n < 60; ++n) solver->step();
  Real fastest = 0;
  for (const Vec3& v : solver->particles().velocity) fastest = std::max(fastest, v.norm());
  MPI_Allreduce(MPI_IN_PLACE, &fastest, 1, MPI_DOUBLE, MPI_MAX, world);
  if (rank_of(world) == 0) std::printf("fastest: %.1e m/s\n", fastest);
  EXPECT_LT(fastest, 1e-9);
}

// The first mode of a tank of half a wavelength: what the paddle takes in does not come back, so that a tenth is left
// after four periods; a wall keeps more than half. In the mean of three places of the paddle within the cells.
TEST_F(WaveTank, APaddleAbsorbsWhatComesBack) {
  const auto tank = [](Real position) {
    return fmt::format(R"scene(
[domain]
min = [0, 0, 0]
max = [{0}, 0.4, 1.4]
[fluid]
spacing = 0.1
[[particles]]
min = [0, 0, 0]
max = [{0}, 0.4, 1.0]
surface = "0.7 + 0.1*cos(pi*(x - {1})/1.5)"
[time]
dt = 0.0166666666666666667
end = 30
[gravity]
[output.gauges]
[[gauge]]
type = "height"
center = [{2}, 0.2, 0]
[[wavemaker]]
type = "piston"
height = 1e-6
period = 1.46
depth = 0.7
position = {1}
)scene",
                       position + 1.5, position, position + 1.4);
  };
  const auto swing = [&](Real position, bool absorb) {
    Scene scene = parse_scene("test.toml", tank(position), {});
    scene.obstacles.front().wavemaker->absorb = absorb;
    auto solver = make_solver(world, scene, initial_particles(world, scene), {});
    GaugeReadings readings(world, scene);
    solver->start();
    Real low = 9, high = 0;
    for (int n = 0; n < 5 * 88; ++n) {
      solver->step();
      if (n < 4 * 88) continue;
      const Real h = readings.read({solver->clock(), solver->particles(), {}, nullptr, {}}).front();
      low = std::min(low, h), high = std::max(high, h);
    }
    return (high - low) / 2;
  };
  Real left = 0, kept = 0;
  for (const Real position : {0.5, 0.56, 0.6}) left += swing(position, true) / 3, kept += swing(position, false) / 3;
  if (rank_of(world) == 0) std::printf("left of 0.1 m: %.4f with absorption, %.4f without\n", left, kept);
  EXPECT_LT(left, 0.25 * kept);
}

// A paddle that absorbs where nothing comes back goes as one that does not: it takes neither particles that are nearer
// to it than half a spacing nor a flap that leans back for missing water, and comes back from where a level that is off
// has sent it: at 1.23 m a third of a spacing of water is missing before the paddle.
TEST_F(WaveTank, NothingToAbsorbLeavesAPaddleInItsPlace) {
  for (const auto& [kind, position] : {std::pair{"piston", 1.2}, {"flap", 1.2}, {"flap", 1.23}}) {
    const Scene scene = parse_scene("test.toml",
                                    fmt::format(R"scene(
[domain]
min = [0, 0]
max = [9.6, 2]
dimensions = 2
[fluid]
spacing = 0.1
[[particles]]
min = [0, 0]
max = [9.6, 1]
[time]
dt = 0.0333333333333333333
end = 12
[gravity]
[[damping]]
min = [4.8, 0]
max = [9.6, 2]
rate = 4
[[wavemaker]]
type = "{}"
height = 0.2
period = 1.9
position = {}
absorb = true
)scene",
                                                kind, position),
                                    {});
    std::vector<Real> offsets;
    SolverExtras extras;
    extras.observers.push_back(std::make_unique<Offsets>(offsets));
    auto solver = make_solver(world, scene, initial_particles(world, scene), std::move(extras));
    solver->start();
    Real farthest = 0, late = 0;
    for (int n = 0; n < 6 * 57; ++n) {
      solver->step();
      farthest = std::max(farthest, std::abs(offsets[0]));
      if (n >= 5 * 57) late += offsets[0] / 57;
    }
    if (rank_of(world) == 0)
      std::printf("%s at %.2f m: %.2f spacings off at most, %.2f in the last period\n", kind, position, farthest / 0.1,
                  late / 0.1);
    if (position == 1.2) {
      EXPECT_LT(farthest, 0.18);
    }
    EXPECT_LT(std::abs(late), 0.07);
  }
}

struct Energy : Observer {
  Real supplied = 0;  // J
  bool due(const Clock&) const override { return true; }
  bool wants_diagnostics() const override { return true; }
  bool wants_forces() const override { return true; }
  void observe(const Frame& frame) override { supplied = frame.supplied_energy; }
};

// Linear theory: the energy that a wave carries away, rho g H²/8 times the group velocity and the width of the layer.
// Of 30 spacings a wavelength a fifth is lost at once, and supplied, too.
TEST_F(WaveTank, TheWorkOfAPaddleIsThatOfItsWaves) {
  for (const char* kind : {"piston", "flap"}) {
    const Scene scene = parse_scene("test.toml",
                                    fmt::format(R"scene(
[domain]
min = [0, 0]
max = [7.2, 1.4]
dimensions = 2
[fluid]
spacing = 0.1
[[particles]]
min = [0, 0]
max = [7.2, 0.7]
[time]
dt = 0.0166666666666666667
end = 6
[gravity]
[output.series]
[[wavemaker]]
type = "{}"
height = 0.15
period = 1.46
position = 0.6
)scene",
                                                kind),
                                    {});
    SolverExtras extras;
    auto watch = std::make_unique<Energy>();
    const Energy& seen = *watch;
    extras.observers.push_back(std::move(watch));
    auto solver = make_solver(world, scene, initial_particles(world, scene), std::move(extras));
    solver->start();
    const WavemakerSettings& maker = *scene.obstacles.front().wavemaker;
    for (int n = 0; n < 2 * 88; ++n) solver->step();
    const Real before = seen.supplied;
    for (int n = 0; n < 2 * 88; ++n) solver->step();
    const Real omega = 2 * std::numbers::pi / maker.period, k = wave_number(omega, maker.depth, maker.gravity);
    const Real group = omega / k / 2 * (1 + 2 * k * maker.depth / std::sinh(2 * k * maker.depth));
    const Real carried = 1000 * maker.gravity * maker.height * maker.height / 8 * group * 0.1;  // W
    const Real part = (seen.supplied - before) / (2 * maker.period * carried);
    if (rank_of(world) == 0) std::printf("%s: %.3f of the work that theory has\n", kind, part);
    EXPECT_GT(part, 0.95);
    EXPECT_LT(part, 1.25);
  }
}

}  // namespace
}  // namespace trevi::test
