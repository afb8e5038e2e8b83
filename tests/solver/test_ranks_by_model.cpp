// The rule for [domain] ranks = "auto" is that of the published model, postprocess/scaling_model.py: both are compared
// with the same table, which test_scaling.py asks the model for.
#include <gtest/gtest.h>

#include <fstream>
#include <sstream>

#include "solver/ranks_by_model.hpp"

namespace trevi::test {
namespace {

/// A basin of `length` x `width` layers of particles `depth` deep, and layers of air above it, h = 2 spacings.
struct Basin {
  int length, width, depth, air;
};

RestingWater water_of(const Basin& basin) {
  RestingWater water{.planes = (basin.length + 1) / 2,
                     .rows = (basin.width + 1) / 2,
                     .columns = (basin.depth + basin.air) / 2,
                     .wet_columns = (basin.depth + 1) / 2,
                     .iterations = 4,
                     .record_bytes = 16};
  water.particles_per_row = Real{1} * basin.length * basin.width * basin.depth / water.planes / water.rows;
  return water;
}

TEST(RanksByModel, AreThoseOfThePublishedModel) {
  std::ifstream table(TREVI_INPUTS "/../tests/solver/ranks_by_model.csv");
  std::string line;
  std::getline(table, line);
  ASSERT_EQ(line, "length,width,depth,air,ranks,slabs,parts");
  int rows = 0, shared = 0;
  while (std::getline(table, line)) {
    std::istringstream cells(line);
    Basin basin{};
    int ranks = 0, slabs = 0, parts = 0;
    char comma = 0;
    cells >> basin.length >> comma >> basin.width >> comma >> basin.depth >> comma >> basin.air >> comma >> ranks >>
        comma >> slabs >> comma >> parts;
    const std::array<int, 2> found = ranks_by_model(water_of(basin), ranks);
    EXPECT_EQ(found, (std::array{slabs, parts})) << line;
    ++rows;
    shared += parts > 1 ? 1 : 0;
  }
  EXPECT_GE(rows, 40);
  EXPECT_GE(shared, 20);
  EXPECT_GE(rows - shared, 10);
}

TEST(RanksByModel, SlabsWhereNoShapeFits) {
  EXPECT_EQ(ranks_by_model(water_of({20, 20, 20, 10}), 101), (std::array{101, 1}));
}

}  // namespace
}  // namespace trevi::test
