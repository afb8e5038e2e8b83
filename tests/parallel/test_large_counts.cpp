// Ids, counts and file offsets past 2^31, by arithmetic: what belongs to all ranks together is counted in 64 bits, and
// what one rank could not count in 32 is refused before it is made. Nothing here takes memory; files are mostly holes.
#include <gtest/gtest.h>
#include <petscsys.h>

#include <numeric>

#include "io/hdf5/hdf5_reader.hpp"
#include "io/hdf5/hdf5_writer.hpp"
#include "io/hdf5/id_order.hpp"
#include "parallel/reductions.hpp"
#include "scene/initial_particles.hpp"
#include "scene/lattice.hpp"
#include "solver/first_slabs.hpp"
#include "support/output_fixture.hpp"
#include "trevi/forcing.hpp"

namespace trevi::test {
namespace {

constexpr GlobalId past = GlobalId{1} << 31U;

/// A basin of 4000 x 1000 x `layers` particles, full to the brim; 2000 planes of cells.
Scene large_scene(int layers, const std::vector<std::string>& overrides = {}) {
  const std::string corner = "[400.0, 100.0, " + std::to_string(layers) + "e-1]\n";
  return parse_scene("large.toml",
                     "[domain]\nmin = [0, 0, 0]\nmax = " + corner + "[fluid]\nspacing = 0.1\n" +
                         "[[particles]]\nmin = [0, 0, 0]\nmax = " + corner + "[time]\ndt = 0.01\nend = 1\n",
                     overrides);
}

CellGrid grid_of(const Scene& scene) {
  return {scene.domain.min, scene.domain.max, scene.fluid.kernel_radius, scene.slab_axis};
}

TEST(LargeCounts, IdsOfALatticeAreIts64BitPlaces) {
  const Scene scene = large_scene(25000);
  const Lattice lattice(scene.particles[0], scene.fluid.spacing);
  EXPECT_EQ(lattice.size(), 100'000'000'000);
  EXPECT_EQ(lattice.id(3999, 999, 24999), 99'999'999'999);
  EXPECT_EQ(lattice.id(1, 0, 24999) - lattice.id(0, 0, 24999), 1);
  EXPECT_GT(lattice.id(0, 600, 537), past);
}

TEST(LargeCounts, PlanesAreWeighedAndCutWithoutParticles) {
  const Scene scene = large_scene(500);  // 2e9 particles
  std::vector<Real> weights;
  if (size_of(world) == 1) {
    EXPECT_NO_THROW(initial_slabs(world, scene, grid_of(scene), weights));
  }
  const Scene larger = large_scene(25000);  // 1e11 particles, too many for a few ranks
  EXPECT_THROW(initial_slabs(world, larger, grid_of(larger), weights), InputError);
  EXPECT_EQ(std::accumulate(weights.begin(), weights.end(), 0.0), 1e11);
  const Slabs slabs(weights, 200);
  EXPECT_NO_THROW(slabs.check_capacity(weights, {grid_of(larger).rows(), grid_of(larger).columns()}, 16));
  EXPECT_DOUBLE_EQ(slabs.imbalance(weights), 1);
}

TEST(LargeCounts, WhatARankCannotCountIsRefused) {
  const std::vector<Real> weights(100, 1e8);
  EXPECT_NO_THROW(Slabs(weights, 10).check_capacity(weights, {1, 1000}, 16));
  EXPECT_THROW(Slabs(weights, 5).check_capacity(weights, {1, 1000}, 16), InputError) << "with its ghosts it has 2.2e9";
  EXPECT_THROW(Slabs(weights, 10).check_capacity(weights, {1, 200'000'000}, 16), InputError)
      << "2.4e9 cells with ghosts";
}

TEST(LargeCounts, CutsAreNotMovedToWhereCellsCannotBeCounted) {
  std::vector<Real> gathered(100, 0);
  gathered[0] = gathered[1] = 1;  // the second of two ranks gets 99 planes
  EXPECT_TRUE(Slabs(gathered, 2).cells_fit(1, 19'000'000)) << "1.92e9 with its ghosts";
  EXPECT_FALSE(Slabs(gathered, 2).cells_fit(1, 21'000'000)) << "2.1e9";
  EXPECT_TRUE(Slabs(std::vector<Real>(100, 1), 2).cells_fit(1, 21'000'000));
}

TEST(LargeCounts, SolversOfPetscCountUnknownsIn32Bits) {
  const std::string anderson = "density.method='anderson'";
  std::vector<Real> weights;
  const Scene scene = large_scene(200);  // 8e8 particles
  EXPECT_NO_THROW(initial_slabs(world, scene, grid_of(scene), weights));
  const Scene refused = large_scene(200, {anderson});
  if (sizeof(PetscInt) == 4) {
    EXPECT_THROW(initial_slabs(world, refused, grid_of(refused), weights), InputError);
  }
  const Scene smaller = large_scene(150, {anderson});  // 6e8
  EXPECT_NO_THROW(initial_slabs(world, smaller, grid_of(smaller), weights));
}

TEST(LargeCounts, PlanesThatNoMessageHoldsAreRefused) {
  const std::vector<Real> weights(8, 1e8);
  EXPECT_THROW(Slabs(weights, 2).check_capacity(weights, {1, 1000}, 32), InputError) << "3.2 GB of records";
  EXPECT_THROW(Slabs(weights, 4).check_capacity(weights, {1, 300'000'000}, 16), InputError)
      << "2.4 GB of the coarse grid";
  EXPECT_NO_THROW(Slabs(weights, 1).check_capacity(weights, {1, 1000}, 32)) << "nothing is sent";
  Settings settings;
  settings.domain = {Vec3::Zero(), Vec3(4, 2, 2)};
  settings.fluid.spacing = 0.1;
  settings.density.precision = Precision::single;
  settings = resolved(settings);
  const CellGrid grid = cell_grid(settings, settings.domain);
  EXPECT_DOUBLE_EQ(bytes_of_particle(settings, grid), 26) << "an eighth of a cell of 26 numbers";
  settings.density.coarse_grid = false;
  EXPECT_EQ(bytes_of_particle(settings, grid), 16) << "a record";
}

TEST(LargeCounts, RandomNumbersSeeTheUpperHalfOfAnId) {
  const StepInfo info{3, 0, 0.0, 0.01};
  EXPECT_EQ(uniform(1, 5 * past + 7, info, 0), uniform(1, 5 * past + 7, info, 0));
  EXPECT_NE(uniform(1, 7, info, 0), uniform(1, 2 * past + 7, info, 0));
}

TEST(LargeCounts, SumsOverRanksAreWide) { EXPECT_EQ(sum_over_ranks(world, past), past * size_of(world)); }

TEST(LargeCounts, SlicesOfATableMeet) {
  for (const GlobalId total : {past - 1, past + 1, GlobalId{100'000'000'000}, GlobalId{100'000'000'007}}) {
    for (const int ranks : {1, 3, 1000, 100'000}) {
      GlobalId next = 0;
      for (int r = 0; r < ranks; ++r) {
        const RowSlice slice = equal_slice(total, r, ranks, 1024);
        ASSERT_EQ(slice.first, next);
        ASSERT_GE(slice.count, 0);
        next += slice.count;
      }
      EXPECT_EQ(next, total);
    }
  }
}

TEST(LargeCounts, IdsPast32BitsAreSortedAcrossRanks) {
  std::vector<GlobalId> ids;
  const GlobalId ranks = size_of(world), rank = rank_of(world);
  for (GlobalId k = 0; k < 100; ++k) ids.push_back(50 * past + (99 - k) * 3 * past + (ranks - rank));
  const IdOrder order(world, ids);
  EXPECT_EQ(order.total(), 100 * ranks);
  EXPECT_TRUE(std::is_sorted(order.ids().begin(), order.ids().end()));
  const GlobalId row = order.first_row();
  for (std::size_t k = 0; k < order.ids().size(); ++k) {
    const GlobalId at = row + static_cast<GlobalId>(k);
    EXPECT_EQ(order.ids()[k], 50 * past + at / ranks * 3 * past + at % ranks + 1);
  }
}

class LargeTable : public Output {};

// 72 GB of positions and 24 GB of ids, of which a few rows at the end of each rank's slice are written and read.
TEST_F(LargeTable, RowsLieWhereTheyShouldPast2To31) {
  constexpr GlobalId total = 3'000'000'000;
  const RowSlice share = equal_slice(total, rank_of(world), size_of(world), 1024);
  const RowSlice end{share.first + share.count - 3, 3, total};
  std::vector<Vec3> places;
  std::vector<GlobalId> ids;
  for (GlobalId k = 0; k < end.count; ++k) {
    ids.push_back(end.first + k);
    places.push_back(static_cast<Real>(end.first + k) * Vec3(1, 2, 3));
  }
  {
    Hdf5Writer file(world, path("large.h5"));
    file.write("/particles/position", places, end);
    file.write("/particles/id", ids, end);
    file.close();
  }
  const Hdf5Reader file(path("large.h5"));
  EXPECT_EQ(file.rows<GlobalId>("/particles/id"), total);
  EXPECT_EQ(file.read<GlobalId>("/particles/id", end), ids);
  EXPECT_EQ(file.read<Vec3>("/particles/position", end), places);
  const RowSlice hole{end.first - 2, 1, total};
  EXPECT_EQ(file.read<GlobalId>("/particles/id", hole), std::vector<GlobalId>{0});
}

}  // namespace
}  // namespace trevi::test
