// Sums with the same bits on any number of ranks, and the n-th smallest without sorting against sorting.
#include <cmath>

#include "parallel/reductions.hpp"
#include "solver/diagnostics.hpp"
#include "support/distributed.hpp"

namespace trevi::test {
namespace {

// Terms of very different size and sign, so that another order of summation shows.
TEST(Reductions, SumOverPlanesIsThatOfOneLoop) {
  constexpr std::size_t planes = 23, columns = 3;
  std::mt19937_64 random(11);
  std::uniform_real_distribution<Real> number(-1, 1);
  std::vector<Real> rows(planes * columns);
  for (Real& value : rows) value = number(random) * std::pow(10, 12 * number(random));
  std::vector<Real> expected(columns, 0.0), reversed(columns, 0.0);
  for (std::size_t k = 0; k < rows.size(); ++k) {
    expected[k % columns] += rows[k];
    reversed[2 - k % columns] += rows[rows.size() - 1 - k];
  }
  EXPECT_NE(expected, reversed) << "the order does not show in this data";
  const Slabs slabs(std::vector<Real>(planes, 1.0), size_of(world));
  const auto begin = static_cast<std::size_t>(slabs.first_plane(rank_of(world))) * columns;
  const auto end = static_cast<std::size_t>(slabs.end_plane(rank_of(world))) * columns;
  EXPECT_EQ(sum_over_planes(world, std::span(rows).subspan(begin, end - begin), columns), expected);
}

TEST(Reductions, ExtremaAndCounts) {
  const int rank = rank_of(world), size = size_of(world);
  EXPECT_EQ(max_over_ranks(world, -3.5 - rank), -3.5);
  EXPECT_EQ(min_over_ranks(world, 2.5 - rank), 2.5 - (size - 1));
  EXPECT_EQ(sum_over_ranks(world, (GlobalId{1} << 40) + rank), (GlobalId{1} << 40) * size + size * (size - 1) / 2);
}

const Box places_box{Vec3(0.6778396292912645, 0, 0), Vec3(5.887519352086528, 1, 1)};
const Real left = places_box.min.x(), width = places_box.max.x() - left;

void expect_as_sorted(const std::vector<Real>& x) {
  std::vector<Vec3> mine;
  for (std::size_t k = 0; k < x.size(); ++k)
    if (static_cast<int>(k * k % 7) % size_of(world) == rank_of(world)) mine.emplace_back(x[k], 0.5, 0.5);
  std::vector<Real> sorted = x;
  std::sort(sorted.begin(), sorted.end());
  for (const std::size_t k : {std::size_t{0}, x.size() / 2, x.size() * 99 / 100, x.size() - 1}) {
    const Real found = nth_smallest(world, mine, 0, static_cast<GlobalId>(k) + 1, places_box);
    EXPECT_NEAR(found, sorted[k], 1e-10 * width) << k << " of " << x.size();
  }
}

TEST(NthSmallest, RandomPlaces) {
  std::mt19937_64 random(2);
  std::uniform_real_distribution<Real> number(left, left + width);
  for (const int n : {1, 2, 100, 1000}) {
    std::vector<Real> x(static_cast<std::size_t>(n));
    for (Real& value : x) value = number(random);
    expect_as_sorted(x);
  }
}

// Places within a rounding of the borders of its intervals, where a particle can be lost between two of them.
TEST(NthSmallest, PlacesOnBorders) {
  for (const int parts : {10, 4096}) {
    std::vector<Real> x;
    for (int k = 0; k <= parts; ++k) x.push_back(std::min(left + width / parts * k, left + width));
    expect_as_sorted(x);
  }
  for (int k = 0; k < 4096; k += 457) {
    const Real border = left + width / 4096 * k;
    expect_as_sorted({border, border, border});
    expect_as_sorted({std::nextafter(border, left), std::nextafter(border, left + width)});
  }
  expect_as_sorted({left + width, left + width});
}

TEST(NthSmallest, OfNothingIsNan) {
  EXPECT_TRUE(std::isnan(nth_smallest(world, {}, 0, 0, {Vec3::Zero(), Vec3::Ones()})));
}

}  // namespace
}  // namespace trevi::test
