// The small parts everything rests on: when an output is due, who owns a plane, which cell a place is in, how a place
// is encoded for the pair loops, and the random numbers.
#include <gtest/gtest.h>

#include <numeric>
#include <random>

#include "domain/slabs.hpp"
#include "particles/cell_grid.hpp"
#include "particles/packed.hpp"
#include "trevi/clock.hpp"
#include "trevi/error.hpp"
#include "trevi/forcing.hpp"

namespace trevi {
namespace {

// ---- clock ------------------------------------------------------------------------------------------------------

/// Steps up to `last` at which the schedule is due.
std::vector<std::int64_t> due_steps(const Schedule& schedule, Real dt, std::int64_t last) {
  std::vector<std::int64_t> steps;
  for (std::int64_t k = 0; k <= last; ++k)
    if (schedule.due({k, dt, 1})) steps.push_back(k);
  return steps;
}

/// The rule of inputs/README.md, word by word: the first step with time ≥ due time − dt/2, for due times 0, every, ...
std::vector<std::int64_t> due_by_rule(Real every, Real dt, std::int64_t last) {
  std::vector<std::int64_t> steps;
  std::int64_t step = 0;
  for (int output = 0;; ++output) {
    while (static_cast<Real>(step) * dt < output * every - dt / 2 - 1e-9 * dt) ++step;
    if (step > last) return steps;
    if (steps.empty() || steps.back() != step) steps.push_back(step);
  }
}

TEST(Clock, OutputsAreDueByTheRule) {
  for (const Real dt : {1.0 / 60, 0.0166666667, 0.01, 0.003}) {
    for (const Real every : {0.1, 0.0333, 1.0 / 30, 0.25, 1.0, dt, 0.4 * dt, 2.5 * dt})
      EXPECT_EQ(due_steps({every, 0}, dt, 2000), due_by_rule(every, dt, 2000)) << every << " s in steps of " << dt;
  }
}

TEST(Clock, HoweverOftenIsEachStep) {
  for (const Real every : {1e-19, 1e-20, 1e-300}) EXPECT_EQ(due_steps({every, 0}, 0.01, 100).size(), 101u) << every;
}

TEST(Clock, StepsBeatSeconds) {
  EXPECT_EQ(due_steps({0.05, 4}, 0.01, 10), (std::vector<std::int64_t>{0, 4, 8}));
  EXPECT_TRUE(due_steps({0, 0}, 0.01, 100).empty());
}

TEST(Clock, TimeDoesNotDrift) { EXPECT_EQ((Clock{6000000, 1.0 / 60, 1}.time()), 6000000 * (1.0 / 60)); }

// ---- slabs ------------------------------------------------------------------------------------------------------

void expect_sound(const std::vector<Real>& weights, int ranks) {
  const Slabs slabs(weights, ranks);
  ASSERT_EQ(slabs.ranks(), ranks);
  EXPECT_EQ(slabs.end_plane(ranks - 1), static_cast<LocalId>(weights.size()));
  for (int r = 0; r < ranks; ++r) {
    EXPECT_LT(slabs.first_plane(r), slabs.end_plane(r)) << "rank " << r << " owns no plane";
    EXPECT_EQ(slabs.first_plane(r), r == 0 ? 0 : slabs.end_plane(r - 1));
    for (LocalId plane = slabs.first_plane(r); plane < slabs.end_plane(r); ++plane) EXPECT_EQ(slabs.owner(plane, 0), r);
  }
}

TEST(Slabs, CutsCoverAllPlanes) {
  std::mt19937_64 random(8);
  std::uniform_real_distribution<Real> number(0, 1);
  for (int planes = 1; planes < 40; ++planes) {
    std::vector<Real> some(static_cast<std::size_t>(planes)), none(some.size(), 0.0), end(none), start(none);
    for (Real& weight : some) weight = std::floor(1000 * number(random));
    end.back() = start.front() = 50;
    for (int ranks = 1; ranks <= planes; ++ranks) {
      for (const std::vector<Real>& weights : {some, none, end, start}) expect_sound(weights, ranks);
    }
  }
}

// No rank has more than its share and the weight of one plane.
TEST(Slabs, WeightsAreShared) {
  std::mt19937_64 random(8);
  std::uniform_real_distribution<Real> number(1, 3);
  std::vector<Real> weights(60);
  for (Real& weight : weights) weight = number(random);
  const Real total = std::accumulate(weights.begin(), weights.end(), 0.0);
  for (const int ranks : {2, 3, 5, 12}) {
    const Slabs slabs(weights, ranks);
    for (int r = 0; r < ranks; ++r) {
      const auto begin = weights.begin() + slabs.first_plane(r), end = weights.begin() + slabs.end_plane(r);
      EXPECT_LE(std::accumulate(begin, end, 0.0), total / ranks + 3);
    }
  }
}

TEST(Slabs, MoreRanksThanPlanesIsAnInputError) {
  try {
    const Slabs slabs(std::vector<Real>(3, 1.0), 4);
    FAIL() << "accepted";
  } catch (const InputError& error) {
    EXPECT_NE(std::string(error.what()).find('3'), std::string::npos);
    EXPECT_NE(std::string(error.what()).find('4'), std::string::npos);
  }
}

// ---- cells ------------------------------------------------------------------------------------------------------

// Neighbours are at most one cell apart in each direction, at any place of any box.
TEST(CellGrid, ParticlesWithinHAreInTouchingCells) {
  std::mt19937_64 random(6);
  std::uniform_real_distribution<Real> number(0, 1);
  const Vec3 min(-3, 2, 0.5), max(-1.03, 3.3, 2.71);
  constexpr Real h = 0.2;
  for (const int axis : {0, 1}) {
    const CellGrid grid(min, max, h, axis);
    for (int k = 0; k < 20000; ++k) {
      const Vec3 p = min + Vec3(number(random), number(random), number(random)).cwiseProduct(max - min);
      const Vec3 towards = Vec3(number(random), number(random), number(random)) - Vec3::Constant(0.5);
      const Vec3 q = (p + 0.999999 * h * towards.normalized()).cwiseMax(min).cwiseMin(max);
      const LocalId a = grid.cell_in_plane(p), b = grid.cell_in_plane(q);
      EXPECT_LE(std::abs(grid.plane_of(p) - grid.plane_of(q)), 1);
      EXPECT_LE(std::abs(a / grid.columns() - b / grid.columns()), 1);
      EXPECT_LE(std::abs(a % grid.columns() - b % grid.columns()), 1);
    }
  }
}

TEST(CellGrid, CountsAndBorders) {
  const CellGrid grid(Vec3(0, 0, 0), Vec3(2.0, 1.0, 0.6), 0.2, 0);
  EXPECT_EQ(grid.planes(), 10);
  EXPECT_EQ(grid.rows(), 5);
  EXPECT_EQ(grid.columns(), 3);  // 0.6 / 0.2 is a rounding below 3
  EXPECT_EQ(grid.plane_of(Vec3(0, 0, 0)), 0);
  EXPECT_EQ(grid.plane_of(Vec3(2, 1, 0.6)), 9);
  EXPECT_EQ(grid.cell_in_plane(Vec3(2, 1, 0.6)), grid.cells_per_plane() - 1);
  EXPECT_EQ(grid.plane_of(Vec3(-1e9, 0, 0)), 0) << "a place outside counts to the nearest cell";
  EXPECT_EQ(grid.plane_of(Vec3(1e9, 0, 0)), 9);
  EXPECT_EQ(CellGrid(Vec3(0, 0, 0), Vec3(2.0, 1.0, 0.6), 0.2, 1).planes(), 5);
}

// ---- records ----------------------------------------------------------------------------------------------------

// In single precision a difference of two places has the same resolution, 2^-22 h, at the corner of the box and a
// kilometre away.
TEST(Encoding, DifferencesAreAsGoodAKilometreAway) {
  constexpr Real h = 0.2;
  const Encoding<float> encode(Vec3(-5, 3, 0), h);
  const Vec3 d(0.11, -0.07, 0.013);
  for (const Vec3& p : {Vec3(-5, 3, 0), Vec3(95.123, 700.3, 0.77), Vec3(995, 1003, 1000)}) {
    const Packed<float> a = encode(p, 1.5F), b = encode(p + d, 2.5F);
    EXPECT_EQ(a.w, 1.5F);
    const auto difference = [](std::int32_t to, std::int32_t from) {
      return static_cast<std::int32_t>(static_cast<std::uint32_t>(to) - static_cast<std::uint32_t>(from));
    };
    const Vec3 found(difference(b.x, a.x), difference(b.y, a.y), difference(b.z, a.z));
    EXPECT_LT((found * h / Packed<float>::units_per_h - d).cwiseAbs().maxCoeff(), 1.01 * h / 4194304);
  }
}

TEST(Encoding, DoubleIsInUnitsOfH) {
  const Packed<double> a = Encoding<double>(Vec3(1, 2, 3), 0.25)(Vec3(1.5, 2, 4), 7);
  EXPECT_EQ(Vec3(a.x, a.y, a.z), Vec3(2, 0, 4));
  EXPECT_EQ(a.w, 7);
}

// ---- random numbers ---------------------------------------------------------------------------------------------

StepInfo at(std::int64_t step, int substep = 0) { return {step, substep, 0, 0}; }

TEST(Uniform, IsAPureFunctionOfAllItsArguments) {
  const Real u = uniform(1, 5, at(7, 2), 3);
  const Real others[] = {uniform(2, 5, at(7, 2), 3),
                         uniform(1, 6, at(7, 2), 3),
                         uniform(1, 5, at(8, 2), 3),
                         uniform(1, 5, at(7, 1), 3),
                         uniform(1, 5, at(7, 2), 4),
                         uniform(1, 5, at(7 + (1LL << 32), 2), 3),
                         uniform(1, 5 + (1LL << 32), at(7, 2), 3),
                         uniform(1ULL << 32, 5, at(7, 2), 3)};
  for (const Real other : others) EXPECT_NE(other, u);
  EXPECT_EQ(uniform(1, 5, at(7, 2), 3), u);
}

TEST(Uniform, MeanVarianceAndRange) {
  constexpr int n = 200000;
  Real sum = 0, squares = 0, lagged = 0, last = 0.5;
  for (int k = 0; k < n; ++k) {
    const Real u = uniform(3, k % 500, at(k / 500), 0);
    ASSERT_GE(u, 0);
    ASSERT_LT(u, 1);
    sum += u;
    squares += (u - 0.5) * (u - 0.5);
    lagged += (u - 0.5) * (last - 0.5);
    last = u;
  }
  EXPECT_NEAR(sum / n, 0.5, 4 * std::sqrt(1.0 / 12 / n));
  EXPECT_NEAR(squares / n, 1.0 / 12, 4 * std::sqrt(1.0 / 180 / n));
  EXPECT_NEAR(lagged / n, 0, 4 * 1.0 / 12 / std::sqrt(n)) << "neighbours are correlated";
}

}  // namespace
}  // namespace trevi
