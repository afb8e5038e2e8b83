// Water that leaves below its surface and enters there. Drains: a tank empties through a hole as Torricelli says.
// Openings in walls: a flow through a channel stays as it is, what enters and leaves is what was asked for, levels are
// held, waves leave. All of it with the same bits on any number of ranks.
#include <cmath>
#include <numeric>

#include "support/cloud.hpp"
#include "support/kept_run.hpp"
#include "support/tank.hpp"

namespace trevi::test {
namespace {

constexpr Real fine = 0.025, width = 2, gravity = 9.8;

// A tank in the plane, 2 m wide, with 1 m of water.
std::string tank_with_hole(const std::string& drain) {
  return "[domain]\ndimensions = 2\nmin = [0, 0]\nmax = [2, 1.5]\n[fluid]\nspacing = 0.025\n[[particles]]\nmin = [0, "
         "0]\nmax = [2, 1]\n[time]\ndt = 0.0083333333333\nend = 2\n[gravity]\n[[drain]]\n" +
         drain;
}

// The coefficient of contraction with which the level has fallen from 0.4 to 1.6 s: above a hole at `height`, of that
// size, d sqrt(H)/dt = −c hole/width sqrt(g/2).
Real contraction(const std::string& drain, Real hole, Real height) {
  KeptRun tank(MPI_COMM_SELF, parse_scene("test.toml", tank_with_hole(drain), {}));
  constexpr int first = 48, steps = 144;
  const auto head = [&] { return static_cast<Real>(tank.solver->particles().size()) * fine * fine / width - height; };
  tank.steps(first);
  const Real before = std::sqrt(head());
  tank.steps(steps);
  return (before - std::sqrt(head())) / (hole / width * std::sqrt(gravity / 2) * steps / 120);
}

// A sharp orifice in two dimensions has 0.611 (Kirchhoff), a little more in a tank that is not endless.
TEST(Openings, ATankEmptiesThroughItsFloorAsTorricelliSays) {
  EXPECT_NEAR(contraction("min = [0.8, 0]\nmax = [1.2, 0.05]\n", 0.4, 0.05), 0.611, 0.05);
  EXPECT_NEAR(contraction("min = [0.9, 0]\nmax = [1.1, 0.05]\n", 0.2, 0.05), 0.611, 0.05);
  EXPECT_NEAR(contraction("min = [0.9, 0]\nmax = [1.1, 0.025]\n", 0.2, 0.05), 0.611, 0.05) << "one layer thick";
  EXPECT_NEAR(contraction("type = \"cylinder\"\ncenter = [1, 0]\nradius = 0.1\nheight = 0.05\n", 0.2, 0.05), 0.611,
              0.05);
}

TEST(Openings, ATankEmptiesThroughItsSideAsTorricelliSays) {
  EXPECT_NEAR(contraction("min = [1.95, 0.2]\nmax = [2, 0.4]\n", 0.2, 0.3), 0.611, 0.05);
  EXPECT_NEAR(contraction("min = [0, 0.2]\nmax = [0.025, 0.4]\n", 0.2, 0.3), 0.611, 0.05) << "one layer thick";
}

// A drain of one layer of cells on an obstacle that ends with them is a hole in it, wherever it is.
TEST(Openings, ADrainOnAnObstacleTakesWaterAsAHole) {
  const std::string slab = "[[obstacle]]\ntype = \"box\"\ncenter = [1, -0.45]\nsize = [4, 1.1]\n";
  for (const char* place : {"min = [0.7, 0.1]\nmax = [0.9, 0.15]\n", "min = [0.9, 0.1]\nmax = [1.1, 0.15]\n",
                            "min = [1.1, 0.1]\nmax = [1.3, 0.15]\n"})
    EXPECT_NEAR(contraction(place + slab, 0.2, 0.05), 0.611, 0.05) << place;
}

TEST(Openings, SameBitsOnAnyRanks) {
  const std::string tank = tank_with_gravity({.max = "1.6, 0.8, 1.2", .water = {{"0, 0, 0", "1.6, 0.8, 0.8"}}});
  for (const char* drain :
       {"min = [0.5, 0.2, 0]\nmax = [1.1, 0.6, 0.1]\n", "min = [1.5, 0.2, 0.2]\nmax = [1.6, 0.6, 0.5]\n",
        "min = [0.3, 0, 0.2]\nmax = [1.2, 0.2, 0.5]\n",
        "type = \"cylinder\"\ncenter = [0.8, 0.4, 0.3]\n"
        "radius = 0.25\nheight = 0.2\n",
        "min = [0.4, 0.2, 0.2]\nmax = [1.2, 0.6, 0.3]\n[[obstacle]]\ntype = \"box\"\ncenter = [0.8, 0.4, 0]\n"
        "size = [2, 2, 0.4]\n"}) {
    SCOPED_TRACE(drain);
    const Scene scene = parse_scene("test.toml", tank + "[[drain]]\n" + drain, {});
    KeptRun many(MPI_COMM_WORLD, scene), one(MPI_COMM_SELF, scene);
    many.steps(20);
    one.steps(20);
    EXPECT_GT(one.solver->flow()->outflow, 30);
    expect_same_bits(gathered(MPI_COMM_WORLD, many.solver->particles()),
                     gathered(MPI_COMM_SELF, one.solver->particles()));
  }
}

// 4 m of water that flows at 0.5 m/s, 0.5 m deep.
std::string channel(const std::string& inlet, const std::string& drain) {
  return "[domain]\ndimensions = 2\nmin = [0, 0]\nmax = [4, 1]\n[fluid]\nspacing = 0.05\n[[particles]]\nmin = [0, "
         "0]\nmax = [4, 0.5]\nvelocity = [0.5, 0]\n[time]\ndt = 0.0166666666667\nend = 2\n[gravity]\n[[inlet]]\ntype = "
         "\"rectangle\"\ncenter = [0.025, 0.25]\nsize = [0.05, 0.5]\ndirection = [1, 0]\n" +
         inlet + "\n[[drain]]\nmin = [3.5, 0]\nmax = [4, 1]\n" + drain;
}

struct Flow {
  Real level, speed, spread;  // m; m/s: mean, and the largest deviation of the mean of a tenth of the channel from it
};

Flow flow_in(const Particles& particles) {
  constexpr Real area = 0.05 * 0.05, length = 4;
  std::array<Real, 10> sum{}, count{};
  for (std::size_t i = 0; i < particles.id.size(); ++i) {
    const auto n = static_cast<std::size_t>(particles.position[i].x() / length * 10);
    sum[n] += particles.velocity[i].x();
    ++count[n];
  }
  Flow flow{static_cast<Real>(particles.size()) * area / length, 0, 0};
  for (std::size_t n = 0; n < 10; ++n) flow.speed += sum[n] / count[n] / 10;
  for (std::size_t n = 0; n < 10; ++n) flow.spread = std::max(flow.spread, std::abs(sum[n] / count[n] - flow.speed));
  return flow;
}

TEST(OpenChannel, AUniformFlowStaysUniform) {
  KeptRun run(MPI_COMM_SELF, parse_scene("test.toml", channel("profile = \"0.5\"", "level = 0.5\n"), {}));
  constexpr GlobalId per_second = 100;  // 0.5 m · 0.5 m/s / s²
  const GlobalId start = run.solver->particles().size();
  for (int second = 1; second <= 20; ++second) {
    run.steps(60);
    const FlowState& state = *run.solver->flow();
    EXPECT_NEAR(static_cast<Real>(state.inflow), second * per_second, 10) << "a layer";
    EXPECT_NEAR(static_cast<Real>(state.outflow), second * per_second, 40) << "a column";
    EXPECT_EQ(run.solver->particles().size(), start + state.inflow - state.outflow);
    const Flow flow = flow_in(run.solver->particles());
    EXPECT_NEAR(flow.level, 0.5, 0.02) << second << ": less than half a spacing";
    EXPECT_NEAR(flow.speed, 0.5, 0.03) << second;
    EXPECT_LT(flow.spread, 0.08) << second;
  }
}

// The drain takes a tenth more than the flow at the start; the inlet brings what the level asks for.
TEST(OpenChannel, AFlowAndALevelAreHeld) {
  KeptRun run(MPI_COMM_SELF, parse_scene("test.toml", channel("speed = 0.5\nlevel = 0.5", "flow = 0.01375\n"), {}));
  run.steps(20 * 60);
  const GlobalId before = run.solver->flow()->outflow, came = run.solver->flow()->inflow;
  run.steps(20 * 60);
  constexpr Real asked = 20 * 0.01375 / (0.05 * 0.05 * 0.05);
  EXPECT_NEAR(static_cast<Real>(run.solver->flow()->outflow - before), asked, 0.02 * asked);
  EXPECT_NEAR(static_cast<Real>(run.solver->flow()->inflow - came), asked, 0.02 * asked);
  EXPECT_NEAR(flow_in(run.solver->particles()).level, 0.5, 0.02);
}

// A drain with a flow takes as many particles as what goes through it is worth, and what waves make of that it gives
// back. Who came near to the wall was taken before: 2.8 % too many in 30 s.
TEST(OpenChannel, ADrainTakesItsFlowToAFewParticles) {
  KeptRun run(MPI_COMM_SELF, parse_scene("test.toml", channel("speed = 0.5\nlevel = 0.5", "flow = 0.0125\n"), {}));
  for (int second = 1; second <= 12; ++second) {
    run.steps(60);
    const FlowState& state = *run.solver->flow();
    EXPECT_NEAR(static_cast<Real>(state.outflow), second * 100, 5) << "half a column";
    EXPECT_GE(state.openings.back().due, 0) << second;
    EXPECT_LT(state.openings.back().due, 1) << second;
  }
}

// Each row has the speed of its height, and a flow that changes with time brings its integral.
TEST(OpenChannel, AProfileIsThatOfItsRows) {
  const std::string text = channel("profile = \"(0.2 + z) * min(1, t)\"", "level = 0.5\n");
  KeptRun run(MPI_COMM_SELF, parse_scene("test.toml", text, {"particles.0.velocity=[0, 0]"}));
  run.steps(6 * 60);
  EXPECT_NEAR(static_cast<Real>(run.solver->flow()->inflow), 90.0 * 5.5, 10) << "0.45 m/s in the mean from 1 s on";
  const Particles& particles = run.solver->particles();
  for (std::size_t i = 0; i < particles.id.size(); ++i) {
    const Vec3& p = particles.position[i];
    if (p.x() < 0.06 && p.z() > 0.05 && p.z() < 0.45) {
      EXPECT_NEAR(particles.velocity[i].x(), 0.2 + p.z(), 0.12) << p.transpose();
    }
  }
}

// A flow over a bed of an obstacle is that over the floor: the bed is no water, neither in levels nor in depths.
TEST(OpenChannel, AFlowOverABedIsThatOverTheFloor) {
  const std::string bed = "[[obstacle]]\ntype = \"box\"\ncenter = [2, -0.4]\nsize = [8, 1.2]\n";
  const std::vector<std::string> lifted = {"domain.max=[4, 1.2]",      "particles.0.min=[0, 0.2]",
                                           "particles.0.max=[4, 0.7]", "inlet.0.center=[0.025, 0.45]",
                                           "drain.0.min=[3.5, 0.2]",   "drain.0.max=[4, 1.2]"};
  for (const auto& [inlet, drain] :
       {std::pair("speed = 0.5\nlevel = 0.7", "flow = 0.0125\n"), std::pair("profile = \"0.5\"", "level = 0.7\n")}) {
    KeptRun run(MPI_COMM_SELF, parse_scene("test.toml", channel(inlet, drain) + bed, lifted));
    run.steps(6 * 60);
    EXPECT_NEAR(static_cast<Real>(run.solver->flow()->outflow), 600, 40) << drain << "a column";
    EXPECT_NEAR(flow_in(run.solver->particles()).level, 0.5, 0.02) << drain;
    EXPECT_NEAR(flow_in(run.solver->particles()).speed, 0.5, 0.03) << drain;
  }
}

// Mean square of how far the level in each of 15 stretches of 0.4 m is from their mean, m².
Real unevenness(const Particles& particles) {
  constexpr Real from = 0.8, wide = 0.4, edge = 0.05;
  std::array<Real, 15> level{};
  for (const Vec3& p : particles.position) {
    for (std::size_t n = 0; n < level.size(); ++n) {
      const Real low = from + static_cast<Real>(n) * wide, high = low + wide;
      level[n] += std::max(0.0, std::min(p.x() + edge / 2, high) - std::max(p.x() - edge / 2, low)) * edge / wide;
    }
  }
  const Real mean = std::accumulate(level.begin(), level.end(), 0.0) / level.size();
  Real sum = 0;
  for (const Real one : level) sum += (one - mean) * (one - mean) / level.size();
  return sum;
}

// A hump in a flow parts into two waves; both come to the end, one of them by way of the inlet, and leave.
TEST(OpenChannel, WavesLeave) {
  const auto waves_of = [](const std::string& height, const std::string& drain) {
    const std::string tank =
        "[domain]\ndimensions = 2\nmin = [0, 0]\nmax = [8, 1]\n[fluid]\nspacing = 0.05\n[[particles]]\nmin = [0, "
        "0]\nmax = [8, 0.8]\nvelocity = [0.5, 0]\nsurface = \"0.5 + " +
        height +
        " * exp(-((x - 4) / 0.8)^2)\"\n[time]\ndt = 0.0166666666667\nend = 9\n[gravity]\n[[inlet]]\ntype = "
        "\"rectangle\"\ncenter = [0.025, 0.25]\nsize = [0.05, 0.5]\ndirection = [1, 0]\nprofile = \"0.5\"\n";
    KeptRun run(MPI_COMM_SELF, parse_scene("test.toml", tank + drain, {}));
    const auto mean_of = [&](int steps) {
      Real sum = 0;
      for (int k = 0; k < steps; ++k) {
        run.steps(1);
        sum += unevenness(run.solver->particles()) / steps;
      }
      return sum;
    };
    run.steps(30);
    const Real early = mean_of(30);
    run.steps(6 * 60);
    return std::pair(early, mean_of(120));
  };
  for (const auto& [holds, bound] : {std::pair("level = 0.5\n", 0.04), std::pair("flow = 0.0125\n", 0.08)}) {
    const std::string drain = std::string("[[drain]]\nmin = [7.4, 0]\nmax = [8, 1]\n") + holds;
    const auto [early, late] = waves_of("0.15", drain);
    const auto [early_still, late_still] = waves_of("0", drain);
    const Real left = (late - late_still) / (early - early_still);
    std::printf("%senergy of waves that is left: %.3f; of the flow by itself: %.3f\n", holds, left, late_still / early);
    EXPECT_LT(left, bound);
  }
}

// A duct full of water, 0.4 m high below a lid or the ceiling of the box, from an inlet to a drain with its flow.
std::string duct(bool lid, const std::string& inlet) {
  return tank_with_gravity({.max = lid ? "2, 0.4, 0.8" : "2, 0.4, 0.4",
                            .water = {{"0, 0, 0", "2, 0.4, 0.4", "velocity = [0.5, 0, 0]"}}}) +
         "[[inlet]]\ntype = \"rectangle\"\ncenter = [0.05, 0.2, 0.2]\nsize = [0.4, 0.4]\ndirection = [1, 0, 0]\n" +
         inlet + "\n[[drain]]\nmin = [1.1, 0, 0]\nmax = [2, 0.4, 0.4]\nflow = 0.08\n" +
         (lid ? "[[obstacle]]\ntype = \"box\"\ncenter = [1, 0.2, 0.7]\nsize = [2.4, 0.8, 0.6]\n" : "");
}

// Its pressure has no surface to start from, and what leaves makes the room for what enters. Without viscosity the flow
// stays uniform. An inlet without a profile drives its water in place of gravity, which shears the flow by a fifth.
TEST(Duct, AUniformFlowStaysUniform) {
  for (const bool lid : {false, true}) {
    for (const auto& [inlet, spread] : {std::pair("profile = \"0.5\"", 0.01), std::pair("speed = 0.5", 0.2)}) {
      SCOPED_TRACE(fmt::format("{} {}", lid, inlet));
      KeptRun run(MPI_COMM_SELF, parse_scene("test.toml", duct(lid, inlet), {}));
      run.steps(4 * 60);
      const Particles& particles = run.solver->particles();
      Real square = 0, sum = 0, count = 0;
      for (std::size_t i = 0; i < particles.id.size(); ++i) {
        if (particles.position[i].x() > 1.6) continue;  // what leaves is taken one by one
        square += (particles.velocity[i] - Vec3(0.5, 0, 0)).squaredNorm();
        sum += particles.velocity[i].x();
        ++count;
      }
      EXPECT_NEAR(sum / count, 0.5, 0.01);
      EXPECT_LT(std::sqrt(square / count), spread);
      constexpr Real asked = 4 * 0.08 / 1e-3, layer = 16;
      EXPECT_NEAR(static_cast<Real>(run.solver->flow()->inflow), asked, layer);
      EXPECT_NEAR(static_cast<Real>(run.solver->flow()->outflow), asked, 2);
    }
  }
}

TEST(Duct, SameBitsOnAnyRanks) {
  for (const bool lid : {false, true}) {
    for (const char* inlet : {"profile = \"0.5\"", "speed = 0.5"}) {
      SCOPED_TRACE(fmt::format("{} {}", lid, inlet));
      const Scene scene = parse_scene("test.toml", duct(lid, inlet), {"inlet.0.size=[0.2, 0.3]"});
      KeptRun many(MPI_COMM_WORLD, scene), one(MPI_COMM_SELF, scene);
      many.steps(60);
      one.steps(60);
      expect_same_bits(gathered(MPI_COMM_WORLD, many.solver->particles()),
                       gathered(MPI_COMM_SELF, one.solver->particles()));
    }
  }
}

TEST(OpenChannel, SameBitsOnAnyRanks) {
  const std::string tank =
      tank_with_gravity({.max = "2.4, 1.6, 1.2", .water = {{"0, 0, 0", "2.4, 1.6, 0.6", "velocity = [0.4, 0.2, 0]"}}});
  const char* const openings[] = {
      "[[inlet]]\ntype = \"rectangle\"\ncenter = [0.05, 0.8, 0.3]\nsize = [1.2, 0.6]\ndirection = [1, 0, 0]\nprofile = "
      "\"0.6 * z + 0.3\"\nlevel = 0.6\njitter = 0.05\n[[drain]]\nmin = [1.5, 0, 0]\nmax = [2.4, 1.6, 1.2]\nlevel = "
      "0.55\n",
      "[[inlet]]\ntype = \"rectangle\"\ncenter = [1.2, 1.55, 0.3]\nsize = [2, 0.6]\ndirection = [0, -1, 0]\nprofile = "
      "\"0.3 + 0.1 * sin(9 * t)\"\n[[drain]]\nmin = [0.4, 0, 0]\nmax = [2.0, 0.9, 1.2]\nflow = 0.3\n"};
  for (const char* opening : openings) {
    SCOPED_TRACE(opening);
    const Scene scene = parse_scene("test.toml", tank + opening, {});
    KeptRun many(MPI_COMM_WORLD, scene), one(MPI_COMM_SELF, scene);
    many.steps(40);
    one.steps(40);
    EXPECT_GT(one.solver->flow()->inflow, 30);
    EXPECT_GT(one.solver->flow()->outflow, 30);
    expect_same_bits(gathered(MPI_COMM_WORLD, many.solver->particles()),
                     gathered(MPI_COMM_SELF, one.solver->particles()));
  }
}

}  // namespace
}  // namespace trevi::test
