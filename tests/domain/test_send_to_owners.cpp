// Particles far from home, as after a restart: each arrives where it belongs, in one exchange of all ranks with all,
// and no rank receives more than it will own. MPI's profiling interface counts what this rank receives.
#include <gtest/gtest.h>

#include "domain/migrate.hpp"
#include "support/count_received.hpp"
#include "support/distributed.hpp"

namespace trevi::test {
namespace {

constexpr std::int64_t particle_bytes = 8 + 3 * 24;
constexpr std::int64_t fields = 4;

/// In the order of ids, equal slices, as a checkpoint is read; far from home but for few.
Cloud as_in_a_checkpoint() { return sorted_by_id(random_cloud(2000, cloud_box, 5)); }

TEST(SendToOwners, ARestartIsOneExchangeAndNobodyReceivesMoreThanItsOwn) {
  const CellGrid grid = cloud_grid();
  const Slabs slabs = even_slabs(grid);
  const Cloud all = as_in_a_checkpoint();
  Particles particles = particles_of(all);
  received = {};
  const GlobalId sent = migrate(world, particles, &Particles::position, grid, slabs);
  const Received seen = received;
  const auto own = static_cast<std::int64_t>(particles.id.size());
  EXPECT_LE(seen.bytes, own * particle_bytes);
  if (size_of(world) > 2) {
    EXPECT_EQ(seen.exchanges, fields);
    EXPECT_EQ(seen.messages, 0) << "no round over the neighbours";
    EXPECT_GT(seen.bytes, own * particle_bytes / 3) << "most particles were far from home";
  }
  GlobalId all_sent = sent;
  std::int64_t all_received = seen.bytes;
  MPI_Allreduce(MPI_IN_PLACE, &all_sent, 1, MPI_INT64_T, MPI_SUM, world);
  MPI_Allreduce(MPI_IN_PLACE, &all_received, 1, MPI_INT64_T, MPI_SUM, world);
  if (size_of(world) > 2) {
    EXPECT_EQ(all_received, all_sent * particle_bytes);
  }
  for (const Vec3& p : particles.position) EXPECT_EQ(slabs.owner(grid, p), rank_of(world));
  const Cloud found = gathered(world, particles);
  EXPECT_EQ(found.id, all.id);
  EXPECT_EQ(found.position, all.position);
  EXPECT_EQ(found.velocity, all.velocity);
}

TEST(SendToOwners, ThoseThatStayKeepTheirOrder) {
  const CellGrid grid = cloud_grid();
  const Slabs slabs = even_slabs(grid);
  Particles particles = particles_of(as_in_a_checkpoint());
  std::vector<GlobalId> staying;
  for (std::size_t i = 0; i < particles.id.size(); ++i)
    if (slabs.owner(grid, particles.position[i]) == rank_of(world)) staying.push_back(particles.id[i]);
  migrate(world, particles, &Particles::position, grid, slabs);
  if (size_of(world) < 3) return;
  ASSERT_GE(particles.id.size(), staying.size());
  EXPECT_TRUE(std::equal(staying.begin(), staying.end(), particles.id.begin()));
}

TEST(SendToOwners, WhatMovesOneSlabGoesToTheNeighbourOnly) {
  const CellGrid grid = cloud_grid();
  const Slabs slabs = even_slabs(grid);
  Particles particles = particles_of(as_in_a_checkpoint());
  migrate(world, particles, &Particles::position, grid, slabs);
  received = {};
  for (Vec3& p : particles.position) p.x() += 0.1;
  migrate(world, particles, &Particles::position, grid, slabs);
  EXPECT_EQ(received.exchanges, 0);
  for (const Vec3& p : particles.position) EXPECT_EQ(slabs.owner(grid, p), rank_of(world));
}

}  // namespace
}  // namespace trevi::test
