// Drains under water: a tank empties through a hole as Torricelli says, on any number of ranks with the same bits.
#include <cmath>

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

TEST(Openings, SameBitsOnAnyRanks) {
  const std::string tank = tank_with_gravity({.max = "1.6, 0.8, 1.2", .water = {{"0, 0, 0", "1.6, 0.8, 0.8"}}});
  for (const char* drain :
       {"min = [0.5, 0.2, 0]\nmax = [1.1, 0.6, 0.1]\n", "min = [1.5, 0.2, 0.2]\nmax = [1.6, 0.6, 0.5]\n",
        "min = [0.3, 0, 0.2]\nmax = [1.2, 0.2, 0.5]\n",
        "type = \"cylinder\"\ncenter = [0.8, 0.4, 0.3]\n"
        "radius = 0.25\nheight = 0.2\n"}) {
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

}  // namespace
}  // namespace trevi::test
