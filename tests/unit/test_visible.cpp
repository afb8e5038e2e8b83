// Which particles are drawn: against brute force over the 26 cells around, and the promises of the thinning. And the
// messages between run and viewer: what is written is read, what is damaged is not.
#include <gtest/gtest.h>

#include <random>
#include <set>

#include "live/viewer_messages.hpp"
#include "live/visible.hpp"
#include "trevi/error.hpp"

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

TEST(ViewerMessages, ComeBackAsTheyWere) {
  ViewedFrame frame;
  frame.step = 12;
  frame.time = 0.1;
  frame.particles = 1'000'000'000'000;
  frame.level = 3;
  frame.fountains = {{NAN, 0}, {64, 7.5}};
  frame.rank_counts = {0, 2};
  frame.shown = {{1, 2, 3, 4}, {5, 6, 7, 8, 1001, {1, 2, 255}}};
  const std::string bytes(reinterpret_cast<const char*>(frame.shown.data()), 2 * sizeof(ViewedParticle));
  const auto back = read_frame(text_of(frame), bytes);
  ASSERT_TRUE(back.has_value());
  EXPECT_EQ(back->time, 0.1);
  EXPECT_EQ(back->particles, frame.particles);
  EXPECT_TRUE(std::isnan(back->fountains[0].note));
  EXPECT_EQ(back->fountains[1].note, 64);
  EXPECT_EQ(back->shown[1].rgb[2], 255);
  EXPECT_TRUE(std::isnan(back->shown[0].density));
  EXPECT_FALSE(read_frame(text_of(frame), bytes.substr(0, sizeof(ViewedParticle))).has_value());
  EXPECT_FALSE(read_wishes(text_of(frame)).has_value());
  const auto wishes = read_wishes(text_of(ViewerWishes{true, 3, 12, 100, false, true}));
  ASSERT_TRUE(wishes.has_value());
  EXPECT_EQ(wishes->single_steps, 3);
  EXPECT_TRUE(wishes->stop);
  for (const char* bad :
       {"", "{", "[]", "{\"kind\":\"wishes\",\"protocol\":1}", "{\"kind\":\"wishes\",\"protocol\":2}"})
    EXPECT_FALSE(read_wishes(bad).has_value()) << bad;
}

TEST(ViewerMessages, Addresses) {
  EXPECT_EQ(viewer_endpoint("--view", "5555"), "tcp://127.0.0.1:5555");
  EXPECT_EQ(viewer_endpoint("--view", "node7:80"), "tcp://node7:80");
  for (const char* bad : {"", ":", "host:", ":80", "host:0", "host:65536", "host:8o", "tcp://host:-1"})
    EXPECT_THROW(viewer_endpoint("--view", bad), InputError) << bad;
}

}  // namespace
}  // namespace trevi
