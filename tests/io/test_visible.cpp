// Which particles are drawn: against brute force over the 26 cells around, and the promises of the thinning.
#include <gtest/gtest.h>

#include <random>
#include <set>

#include "io/frames/visible.hpp"

namespace trevi {
namespace {

const Box box{Vec3(-1, 2, 0), Vec3(0.55, 3.1, 1.3)};
constexpr Real size = 0.2;

using Cell = std::array<int, 3>;

Cell cell_of(const Vec3& p) {
  Cell cell{};
  for (int a = 0; a < 3; ++a) {
    const int last = static_cast<int>(std::ceil((box.max - box.min)[a] / size)) - 1;
    cell[static_cast<std::size_t>(a)] = std::clamp(static_cast<int>(std::floor((p - box.min)[a] / size)), 0, last);
  }
  return cell;
}

bool surrounded(const std::set<Cell>& wet, const Cell& cell) {
  for (int k = 0; k < 27; ++k) {
    if (!wet.contains({cell[0] + k % 3 - 1, cell[1] + k / 3 % 3 - 1, cell[2] + k / 9 - 1})) return false;
  }
  return true;
}

TEST(Visible, HiddenIsWhatWaterSurrounds) {
  std::mt19937 random(3);
  std::uniform_real_distribution<Real> number(0, 1);
  std::vector<Vec3> points;
  std::set<Cell> wet;
  VisibleCells cells(box, size);
  for (int k = 0; k < 900; ++k) {
    points.push_back(box.min + Vec3(number(random), number(random), number(random)).cwiseProduct(box.max - box.min));
    cells.mark(points.back());
    wet.insert(cell_of(points.back()));
  }
  cells.find_hidden();
  int hidden = 0;
  for (const Vec3& p : points) {
    EXPECT_EQ(cells.hidden(p), surrounded(wet, cell_of(p)));
    hidden += cells.hidden(p) ? 1 : 0;
  }
  EXPECT_GT(hidden, 20);
  EXPECT_LT(hidden, 880);
}

TEST(Visible, OutsideAndNowhereAreSafe) {
  VisibleCells cells(box, size);
  for (const Vec3& p : {Vec3(1e300, -1e300, NAN), Vec3(-9, 9, 9)}) {
    cells.mark(p);
    cells.find_hidden();
    EXPECT_FALSE(cells.hidden(p));
  }
  EXPECT_LE(VisibleCells(Box{Vec3::Zero(), Vec3(1e4, 1e4, 1e4)}, 0.1).marks().size(), 2'100'000U);
}

TEST(Visible, ThinningIsNestedAndEven) {
  EXPECT_EQ(thinning_level(1000, 1000), 0);
  EXPECT_EQ(thinning_level(1001, 1000), 1);
  EXPECT_EQ(thinning_level(96000, 1000), 7);
  EXPECT_EQ(thinning_level(5, 0), 2);
  for (int level = 0; level < 8; ++level) {
    int drawn = 0;
    for (GlobalId id = 0; id < 64000; ++id) {
      drawn += drawn_at(id, level) ? 1 : 0;
      EXPECT_TRUE(!drawn_at(id, level + 1) || drawn_at(id, level));
    }
    const double expected = 64000.0 / (1 << level);
    EXPECT_NEAR(drawn, expected, 5 * std::sqrt(expected));
  }
}

}  // namespace
}  // namespace trevi
