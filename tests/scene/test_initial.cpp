// The start of the water: blocks whose velocity and surface are expressions.
#include <cmath>
#include <numbers>

#include <fmt/format.h>
#include <gmock/gmock.h>

#include "scene/formula.hpp"
#include "scene/lattice.hpp"
#include "support/cloud.hpp"
#include "support/tank.hpp"
#include "trevi/error.hpp"

namespace trevi::test {
namespace {

const std::string tank = tank_text({.max = "2, 1, 1.5", .dt = "0.01"}) + R"([[particles]]
min = [0, 0, 0]
max = [2, 1, 1]
)";

Cloud start_of(const std::string& more) {
  return gathered(world, initial_particles(world, scene_with(tank + more, {})));
}

TEST(Formula, SineAndCosineAreThoseOfTheLibraryToRounding) {
  const Formula wave("2*sin(3*x) + cos(y)^2 - min(z, 0.5) + exp(-x) + pi", "xyz");
  for (Real x = -4; x < 4; x += 0.37) {
    const Vec3 p(x, 1 - x, x / 3);
    const Real expected =
        2 * std::sin(3 * x) + std::pow(std::cos(1 - x), 2) - std::min(x / 3, 0.5) + std::exp(-x) + std::numbers::pi;
    EXPECT_NEAR(wave(p), expected, 1e-13);
  }
}

TEST(Formula, RefusesWhatIsNoExpression) {
  for (const char* text : {"", "x+", "a", "x y", "1, 2", "x = 3", "f(x)", "sin()", "\"x\"", "x + z"})
    EXPECT_THROW(Formula(text, "xy"), InputError) << text;
  EXPECT_THROW(Formula("sqrt(x)", "xy")(Vec3(-1, 0, 0)), InputError);
  EXPECT_THROW(Formula("1/x", "xy")(Vec3(0, 0, 0)), InputError);
}

TEST(InitialParticles, HaveTheVelocityOfTheExpressions) {
  const Cloud water = start_of("velocity = [\"0.3*sin(pi*x)\", \"x*y - z\", \"-1\"]\n");
  ASSERT_EQ(water.id.size(), 2000U);
  for (std::size_t k = 0; k < water.id.size(); ++k) {
    const Vec3& p = water.position[k];
    const Vec3 expected(0.3 * std::sin(std::numbers::pi * p.x()), p.x() * p.y() - p.z(), -1);
    EXPECT_LT((water.velocity[k] - expected).norm(), 1e-14);
  }
}

// Each place of the lattice with its centre below the surface, with the id that it has in the whole block; an obstacle
// takes its own.
TEST(InitialParticles, FillABlockUpToItsSurface) {
  const auto surface = [](const Vec3& p) { return 0.6 + 0.31 * p.x() * p.y(); };
  for (const std::string obstacle : {"", "[[obstacle]]\ntype = \"sphere\"\ncenter = [1, 0.5, 0.3]\nradius = 0.2\n"}) {
    const Cloud water = start_of("surface = \"0.6 + 0.31*x*y\"\n" + obstacle);
    std::set<GlobalId> expected;
    const Lattice lattice(scene_with(tank, {}).particles[0], 0.1);
    for (GlobalId n = 0; n < 2000; ++n) {
      const Vec3 p = lattice.point(n % 20, n / 20 % 10, n / 200);
      if (p.z() <= surface(p) && (obstacle.empty() || (p - Vec3(1, 0.5, 0.3)).norm() >= 0.2)) expected.insert(n);
    }
    EXPECT_EQ(std::set<GlobalId>(water.id.begin(), water.id.end()), expected);
    EXPECT_EQ(water.id.size(), expected.size());
  }
}

// A body takes as much as it displaces, in the mean over its places: no gap is around it.
TEST(InitialParticles, LeaveOutWhatABodyDisplaces) {
  GlobalId taken = 0;
  constexpr int places = 40;
  constexpr Real radius = 0.3;
  for (int k = 0; k < places; ++k) {
    const Vec3 middle(0.9 + 0.0137 * (k % 7), 0.45 + 0.0119 * (k % 5), 0.45 + 0.0113 * (k % 11));
    taken += 2000 - static_cast<GlobalId>(
                        start_of(fmt::format("[[body]]\ntype = \"sphere\"\ncenter = [{}, {}, {}]\nradius = {}\n"
                                             "density = 500\n",
                                             middle.x(), middle.y(), middle.z(), radius))
                            .id.size());
  }
  const Real displaced = 4.0 / 3 * std::numbers::pi * std::pow(radius / 0.1, 3);
  EXPECT_NEAR(static_cast<Real>(taken) / places, displaced, 0.03 * displaced);
}

// Faces on planes of the lattice, edges and corners on its points.
TEST(InitialParticles, LeaveOutTheVolumeOfABodyOnTheLattice) {
  for (const auto& [size, volume] :
       {std::pair{"[0.4, 0.4, 0.4]", 64.0}, {"[0.6, 0.4, 0.2]", 48.0}, {"[0.6, 0.3, 0.5]", 90.0}}) {
    GlobalId taken = 0;
    for (int k = 0; k < 8; ++k) {
      taken += 2000 - static_cast<GlobalId>(start_of(fmt::format("[[body]]\ntype = \"box\"\ncenter = [{}, 0.55, 0.45]\n"
                                                                 "size = {}\ndensity = 500\n",
                                                                 0.65 + 0.1 * k, size))
                                                .id.size());
    }
    EXPECT_NEAR(static_cast<Real>(taken) / 8, volume, 1e-9) << size;
  }
}

// Where the expression is no number on one rank alone, too.
TEST(InitialParticles, RefuseAnExpressionThatIsNoNumberOnAllRanks) {
  for (const char* key : {"velocity = [\"sqrt(1.9-x)\", \"0\", \"0\"]\n", "surface = \"sqrt(1.9-x)\"\n"}) {
    const Scene scene = scene_with(tank + key, {});
    try {
      initial_particles(world, scene);
      ADD_FAILURE() << "no error";
    } catch (const InputError& error) {
      EXPECT_THAT(error.what(), testing::HasSubstr("\"sqrt(1.9-x)\" is not a finite number at (1.95"));
    }
  }
}

}  // namespace
}  // namespace trevi::test
