// What ranks get of the cores of their machine, with masks made up for each of them.
#include <cmath>
#include <numeric>

#include "parallel/core_share.hpp"
#include "support/distributed.hpp"

namespace trevi::test {
namespace {

std::vector<int> cores(int first, int count) {
  std::vector<int> all(static_cast<std::size_t>(count));
  std::iota(all.begin(), all.end(), first);
  return all;
}

TEST(CoreShare, OfRanksThatMayUseAllCores) {
  for (const int count : {1, 2, 3, 8, 64})
    EXPECT_EQ(fair_threads(world, cores(0, count), INFINITY), std::max(1, count / size_of(world)));
}

TEST(CoreShare, OfRanksWithCoresOfTheirOwn) {
  const int rank = rank_of(world);
  EXPECT_EQ(fair_threads(world, cores(4 * rank, 4), INFINITY), 4);
  EXPECT_EQ(fair_threads(world, cores(100 * rank, rank + 1), INFINITY), rank + 1);
}

TEST(CoreShare, OfRanksThatOverlap) {
  // Each has two cores of its own and two that all have.
  std::vector<int> mine = cores(0, 2);
  for (const int core : cores(2 + 2 * rank_of(world), 2)) mine.push_back(core);
  EXPECT_EQ(fair_threads(world, mine, INFINITY), 2 + 2 / size_of(world));
}

TEST(CoreShare, OfARankWithoutCores) {
  EXPECT_EQ(fair_threads(world, {}, INFINITY), 1);
  EXPECT_EQ(fair_threads(world, rank_of(world) == 0 ? cores(0, 3) : cores(0, 0), INFINITY),
            rank_of(world) == 0 ? 3 : 1);
}

TEST(CoreShare, OfAContainer) { EXPECT_EQ(fair_threads(world, cores(64 * rank_of(world), 64), 6), 6 / size_of(world)); }

TEST(CoreShare, OfTwoRunsSideBySideIsThatOfEachAlone) {
  MPI_Comm half = MPI_COMM_NULL;
  MPI_Comm_split(world, rank_of(world) % 2, 0, &half);
  EXPECT_EQ(fair_threads(half, cores(0, 12), INFINITY), 12 / size_of(half));
  MPI_Comm_free(&half);
}

}  // namespace
}  // namespace trevi::test
