// Sweeps leave out the rows of cells in which nothing is compressed, and change no bit by it: the same water with an
// artificial pressure that single precision does not tell from none, which has all rows swept, is the reference.
#include "solver/swept_rows.hpp"

#include "support/cloud.hpp"

namespace trevi::test {
namespace {

std::string scene(const std::string& density) {
  return tank_with_gravity({.max = "4.0, 1.2, 2.0",
                            .water = {{"0.0, 0.0, 0.0", "4.0, 1.2, 0.6"}, {"0.4, 0.3, 1.2", "0.9, 0.8, 1.6"}}}) +
         "[density]\nprecision = 'single'\n" + density;
}

// Pairs that a step goes over, of all ranks.
Real pairs_of_step(Solver& solver) {
  const auto sum = [&] {
    Real passes = solver.counters().pair_passes;
    MPI_Allreduce(MPI_IN_PLACE, &passes, 1, MPI_DOUBLE, MPI_SUM, world);
    return passes;
  };
  const Real before = sum();
  solver.step();
  return sum() - before;
}

// The state after so many steps, and the pairs that they went over.
struct Outcome {
  Cloud water;
  Real pairs = 0;
};
Outcome run(const std::string& text, int steps) {
  const std::unique_ptr<Solver> solver = started(scene_with(text, {}));
  Outcome out;
  for (int k = 0; k < steps; ++k) out.pairs += pairs_of_step(*solver);
  out.water = gathered(world, solver->particles());
  return out;
}

constexpr const char* all_rows = "[tensile]\nk = 1e-300\n";

TEST(SweptRows, ChangeNoBit) {
  const std::string ball =
      "[[obstacle]]\ntype = 'sphere'\ncenter = [3.0, 0.6, 0.5]\nradius = 0.25\nvelocity = [-0.5, 0.0, 0.0]\n"
      "[[body]]\ntype = 'sphere'\ncenter = [1.6, 0.6, 0.6]\nradius = 0.2\ndensity = 500.0\n";
  for (const std::string& solids : {std::string(), ball}) {
    const Outcome some = run(scene("") + solids, 40), all = run(scene("") + all_rows + solids, 40);
    expect_same_bits(some.water, all.water);
    EXPECT_LT(some.pairs, (solids.empty() ? 0.95 : 1) * all.pairs);
  }
}

// Two particles in one place are parted, although nothing around them is compressed.
TEST(SweptRows, CoincidentParticlesPart) {
  const Scene far = scene_with(scene(""), {});
  Cloud cloud;
  for (const GlobalId id : {3, 5}) cloud.add(id, Vec3(2.05, 0.55, 1.5), Vec3::Zero());
  const std::unique_ptr<Solver> solver = solver_of(world, far, cloud);
  solver->start();
  for (int k = 0; k < 3; ++k) solver->step();
  const Cloud after = gathered(world, solver->particles());
  ASSERT_EQ(after.id.size(), 2U);
  EXPECT_GT((after.position[0] - after.position[1]).norm(), 1e-3);
}

// One pass finds that there is nothing to do; without that there are four.
TEST(SweptRows, WaterAtRestIsLookedAtOnce) {
  const std::string rest = tank_with_gravity({.max = "4.0, 1.2, 2.0", .water = {{"0.0, 0.0, 0.0", "4.0, 1.2, 1.2"}}}) +
                           "[density]\nprecision = '";
  for (const std::string precision : {"single'\n", "double'\n"}) {
    const std::unique_ptr<Solver> solver = started(scene_with(rest + precision, {}));
    const std::unique_ptr<Solver> swept = started(scene_with(rest + precision + all_rows, {}));
    for (int k = 0; k < 30; ++k) pairs_of_step(*solver);
    const Real of_pass = pairs_of_step(*swept) / 4;
    EXPECT_LT(pairs_of_step(*solver), 1.01 * of_pass) << precision;
  }
}

TEST(SweptRows, PiecesOfARange) {
  std::vector<std::array<int, 3>> pieces;
  for_each_piece({10, 50}, {{0, 12}, {20, 30}, {45, 60}}, [&](Range piece, bool inside) {
    pieces.push_back({piece.begin, piece.end, inside ? 1 : 0});
  });
  const std::vector<std::array<int, 3>> expected = {{10, 12, 1}, {12, 20, 0}, {20, 30, 1}, {30, 45, 0}, {45, 50, 1}};
  EXPECT_EQ(pieces, expected);
}

}  // namespace
}  // namespace trevi::test
