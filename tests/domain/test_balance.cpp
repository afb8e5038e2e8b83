// Cuts that follow the water: after a look at the weights no rank has more to do than whole planes force on it, all
// ranks agree, and nobody is lost on the way.
#include <gtest/gtest.h>

#include <algorithm>
#include <numeric>

#include "domain/balance.hpp"
#include "parallel/reductions.hpp"
#include "support/distributed.hpp"

namespace trevi::test {
namespace {

constexpr Real min_gain = 0.01;

/// A cloud that is denser towards one end of the slab axis, and its mirror image: the water that has sloshed over.
Cloud lopsided(bool mirrored) {
  Cloud cloud = random_cloud(3000, cloud_box, 1);
  const Real width = cloud_box.max.x() - cloud_box.min.x();
  for (Vec3& p : cloud.position) {
    const Real share = (p.x() - cloud_box.min.x()) / width;
    p.x() = mirrored ? cloud_box.max.x() - width * share * share : cloud_box.min.x() + width * share * share;
  }
  return cloud;
}

/// Five ranks share seven planes of which one has most of the work: no cut can help them.
bool can_gain() { return size_of(world) >= 2 && size_of(world) <= 4; }

/// Planes' particles over the whole cloud, the largest of them as a share of all.
Real heaviest_plane(const Cloud& cloud, const CellGrid& grid) {
  std::vector<Real> count(static_cast<std::size_t>(grid.planes()), 0.0);
  for (const Vec3& p : cloud.position) count[static_cast<std::size_t>(grid.plane_of(p))] += 1;
  return *std::max_element(count.begin(), count.end()) / static_cast<Real>(cloud.id.size());
}

std::vector<LocalId> cuts_of(const Slabs& slabs) {
  std::vector<LocalId> cuts;
  for (int r = 0; r < slabs.ranks(); ++r) cuts.push_back(slabs.first_plane(r));
  return cuts;
}

TEST(Balance, CutsFollowTheWater) {
  Distributed<float> d(lopsided(false));
  Balance balance(world, min_gain);
  for (const bool mirrored : {false, true}) {
    const Cloud cloud = lopsided(mirrored);
    d.rebuild(cloud);
    balance.update(0, d.near.order(), d.near.list(), d.slabs);
    d.rebuild(cloud);  // migrates to where the cuts are now
    const Real work = plane_work(d.near.order(), d.near.list(), 0, d.near.order().planes());
    const Real most = max_over_ranks(world, work);
    const auto all = static_cast<Real>(sum_over_ranks(world, static_cast<GlobalId>(work)));
    // Pairs grow with the square of the density, so a plane's share of the work may be twice its share of particles.
    EXPECT_LT(most / all, 1.0 / size_of(world) + 2 * heaviest_plane(cloud, d.grid));
    EXPECT_EQ(sum_over_ranks(world, d.particles.size()), static_cast<GlobalId>(cloud.id.size()));
    for (const LocalId cut : cuts_of(d.slabs)) {
      EXPECT_EQ(max_over_ranks(world, cut), cut);
      EXPECT_EQ(min_over_ranks(world, cut), cut);
    }
  }
  EXPECT_EQ(balance.history().moves >= 1, can_gain());
}

TEST(Balance, MovesOnlyWhenItIsTimeAndWorthIt) {
  Distributed<float> d(lopsided(true));
  Balance balance(world, min_gain), never(world, 1e300);
  const std::vector<LocalId> before = cuts_of(d.slabs);
  balance.update(Balance::interval + 1, d.near.order(), d.near.list(), d.slabs);
  never.update(0, d.near.order(), d.near.list(), d.slabs);
  EXPECT_EQ(cuts_of(d.slabs), before);
  balance.update(0, d.near.order(), d.near.list(), d.slabs);
  EXPECT_EQ(cuts_of(d.slabs) != before, can_gain());
  d.rebuild(lopsided(true));
  balance.update(0, d.near.order(), d.near.list(), d.slabs);
  EXPECT_EQ(balance.history().moves, can_gain() ? 1 : 0) << "the cuts are where they should be";
  EXPECT_EQ(never.history().moves, 0);
}

/// The work of each row of each of these slabs, from all ranks.
std::vector<Real> work_of_all_rows(const Distributed<float>& d, const Slabs& slabs) {
  const CellOrder& order = d.near.order();
  const auto rows = static_cast<std::size_t>(d.grid.rows());
  std::vector<Real> all(static_cast<std::size_t>(slabs.slabs()) * rows, 0.0);
  for (LocalId k = 0; k < order.planes(); ++k) {
    const auto slab = static_cast<std::size_t>(slabs.slab_of(order.window().planes.begin + k));
    for (LocalId r = 0; r < order.rows(); ++r) {
      const Range row = order.row(k + 1, r);
      all[slab * rows + static_cast<std::size_t>(order.window().rows.begin + r)] +=
          work_of(d.near.list(), {row.begin - order.low_ghosts(), row.end - order.low_ghosts()});
    }
  }
  MPI_Allreduce(MPI_IN_PLACE, all.data(), static_cast<int>(all.size()), MPI_DOUBLE, MPI_SUM, world);
  return all;
}

// No rank sees the work of all rows, and yet they are cut as one that does would.
TEST(Balance, CutsInsideSlabsFollowTheWork) {
  for (const int parts : parts_of_slabs(cloud_grid())) {
    if (parts == 1) continue;
    Distributed<float> d(lopsided(false), 0, parts);
    Balance balance(world, -1e300);  // moves whatever that gains
    d.rebuild(lopsided(true));
    std::vector<Real> planes(static_cast<std::size_t>(d.grid.planes()), 0.0);
    for (LocalId k = 0; k < d.near.order().planes(); ++k)
      planes[static_cast<std::size_t>(d.near.order().window().planes.begin + k)] =
          plane_work(d.near.order(), d.near.list(), k, k + 1);
    MPI_Allreduce(MPI_IN_PLACE, planes.data(), static_cast<int>(planes.size()), MPI_DOUBLE, MPI_SUM, world);
    Slabs expected(planes, d.slabs.slabs());
    cut_rows_alone(expected, work_of_all_rows(d, expected), parts);
    const Real own = plane_work(d.near.order(), d.near.list(), 0, d.near.order().planes());
    const Real mean = std::accumulate(planes.begin(), planes.end(), 0.0) / size_of(world);
    balance.update(0, d.near.order(), d.near.list(), d.slabs);
    EXPECT_EQ(d.slabs.cuts(), expected.cuts()) << parts << " parts";
    EXPECT_EQ(balance.history().moves, 1);
    EXPECT_DOUBLE_EQ(balance.history().sum, max_over_ranks(world, own) / mean);
  }
}

TEST(Slabs, ImbalanceIsTheLargestShareOverTheMean) {
  const std::vector<Real> weights = {1, 1, 1, 1, 4};
  EXPECT_DOUBLE_EQ(Slabs(weights, 2).imbalance(weights), 1);
  EXPECT_DOUBLE_EQ(Slabs(weights, 1).imbalance(weights), 1);
  EXPECT_DOUBLE_EQ(Slabs(weights, 5).imbalance(weights), 2.5);
  EXPECT_DOUBLE_EQ(Slabs(weights, 2).imbalance(std::vector<Real>(5, 0.0)), 1);
}

}  // namespace
}  // namespace trevi::test
