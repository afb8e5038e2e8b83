// What is said of scenes that are allowed and hardly ever meant, and that nothing is said of good ones.
#include <gtest/gtest.h>

#include <cstdlib>
#include <fstream>
#include <numeric>

#include "app/launch.hpp"
#include "app/preflight/advice.hpp"
#include "app/preflight/run_cost.hpp"

namespace trevi {
namespace {

const std::string pool =
    "[domain]\nmin = [0, 0, 0]\nmax = [2.4, 1.6, 3]\n[fluid]\nspacing = 0.1\n[[particles]]\nmin = [0, 0, 0]\n"
    "max = [2.4, 1.6, 0.6]\n[time]\ndt = 0.016666666666666667\nend = 1\n[gravity]\n[output.series]\n";
const std::string fountain = "[[fountain]]\ncenter = [1.2, 0.8]\ndiameter = 0.25\nheight = 0.5\n";

std::string said(const std::string& text, const std::vector<std::string>& overrides = {}) {
  const std::vector<std::string> advice = scene_advice(parse_scene("scene.toml", text, overrides));
  return std::accumulate(advice.begin(), advice.end(), std::string());
}

void expect_said(const std::string& word, const std::string& text, const std::vector<std::string>& overrides) {
  const std::string all = said(text, overrides);
  EXPECT_NE(all.find(word), std::string::npos) << word << " is not in \"" << all << '"';
}

TEST(Advice, NothingIsSaidOfGoodScenes) {
  EXPECT_EQ(said(pool), "");
  EXPECT_EQ(said(pool + fountain), "");
}

TEST(Advice, WaterThatDoesNotFitBetweenWalls) {
  expect_said("along x", pool, {"fluid.spacing=0.11"});
  expect_said("along y", pool, {"domain.max=[2.4,1.65,3]", "particles.0.max=[2.4,1.65,0.6]"});
}

// Behind the walls of a vessel the box has no water.
TEST(Advice, NothingIsSaidOfTheLatticeInAVessel) {
  const std::string vessel =
      pool + "[[obstacle]]\ntype = 'cylinder'\ninside = true\ncenter = [1.2, 0.8, 1]\nheight = 3\n";
  EXPECT_EQ(said(vessel + "radius = 0.7\n", {"domain.max=[2.445,1.6,3]"}).find("along x"), std::string::npos);
  expect_said("along x", vessel + "radius = 1.4\n", {"domain.max=[2.445,1.6,3]"});
}

TEST(Advice, ThinWallsOfABasin) {
  const std::string basin =
      pool + "[[obstacle]]\ntype = 'basin'\ncenter = [1.2, 0.8, 1.5]\nradius = 0.4\nheight = 0.5\n";
  EXPECT_EQ(said(basin), "");
  expect_said("walls of the basin", basin, {"obstacle.0.wall=0.3"});
}

TEST(Advice, SheetsThatCellsSeeBothSidesOf) {
  const std::string sheet = pool + "[[obstacle]]\ntype = 'box'\ncenter = [1.2, 0.8, 0.8]\nsize = [0.08, 1.6, 1.6]\n";
  expect_said("the box of line 14 is 0.08 m thick", sheet, {});
  EXPECT_EQ(said(sheet, {"obstacle.0.size=[0.2, 1.6, 1.6]"}), "");
  EXPECT_EQ(said(sheet, {"obstacle.0.size=[0.08, 0.08, 1.6]"}), "");  // a pole
  const std::string boat = pool + "[[body]]\ntype = 'basin'\ncenter = [1.2, 0.8, 0.7]\nsize = [0.8, 0.8, 0.4]\n";
  expect_said("walls of the basin of line 14", boat + "density = 500\nwall = 0.08\n", {});
}

TEST(Advice, RowsOfGaugesWithoutGauges) {
  expect_said("[output.gauges]", pool + "[output.gauges]\nevery = 0.1\n", {});
  EXPECT_EQ(said(pool + "[output.gauges]\nevery = 0.1\n[[gauge]]\ntype = 'height'\ncenter = [1, 1, 0]\n"), "");
}

// A row of 100 gauges is two kilobytes long.
TEST(Advice, TablesAreAmongTheBytesOfTheOutput) {
  const Scene plain = parse_scene("scene.toml", pool + "every_steps = 1\n", {});
  const Scene gauged = parse_scene("scene.toml",
                                   pool + "every_steps = 1\n[[gauge]]\ntype = 'height'\ncenter = [0.2, 0.8, 0]\n"
                                          "to = [2.2, 0.8, 0]\ncount = 100\n",
                                   {});
  EXPECT_NEAR(output_bytes(gauged, 1) - output_bytes(plain, 1), 61 * 100 * 20, 1);
}

TEST(Advice, Overlap) {
  expect_said("overlap", pool, {"particles.1.min=[1,1,0.3]", "particles.1.max=[1.4,1.4,1]"});
  EXPECT_EQ(said(pool, {"particles.1.min=[1,1,0.6]", "particles.1.max=[1.4,1.4,1]"}), "");
}

TEST(Advice, FountainsOutOfTheWater) {
  expect_said("ends above the water", pool + fountain, {"fountain.0.height=1.5"});
  expect_said("holds no water", pool + fountain, {"fountain.0.diameter=0.01"});
  expect_said("holds no water", pool + fountain, {"particles.0.max=[0.8,1.6,0.6]"});
}

TEST(Advice, ColoursThatNoFrameShows) {
  const std::string coloured = pool + "[colour]\nby = \"speed\"\n[output.vtu]\nevery = 0.1\n";
  expect_said("\"rgb\"", coloured + "fields = [\"velocity\"]\n", {});
  EXPECT_EQ(said(coloured + "fields = [\"velocity\", \"rgb\"]\n"), "");
  EXPECT_EQ(said(coloured + "fields = [\"velocity\"]\n[output.vtkhdf]\nevery = 0.1\nfields = [\"rgb\"]\n"), "");
  EXPECT_EQ(said(pool + "[colour]\nby = \"speed\"\n"), "");  // for the viewer
}

TEST(Advice, LongStepsThatAreNeverSplit) {
  expect_said("time.cfl", pool, {"time.dt=0.2", "time.cfl=0"});
  EXPECT_EQ(said(pool, {"time.dt=0.2"}), "");
}

TEST(Advice, ObstaclesOutsideOfTheBox) {
  const std::string ball = "[[obstacle]]\ntype = \"sphere\"\nradius = 0.1\ncenter = ";
  expect_said("wholly outside of the box", pool + ball + "[100, 0.5, 0.5]\n", {});
  EXPECT_EQ(said(pool + ball + "[0.5, 0.5, 0.9]\n"), "");
}

TEST(Advice, MoreWaterThanSpace) {
  const Scene scene = parse_scene("scene.toml", pool, {});
  const Real box = (scene.domain.max - scene.domain.min).prod(), s = scene.fluid.spacing;
  EXPECT_TRUE(volume_warnings(scene, box / (s * s * s)).empty()) << "a full box";
  ASSERT_EQ(volume_warnings(scene, 1.1 * box / (s * s * s)).size(), 1U);
  EXPECT_DOUBLE_EQ(open_volume(scene), box);
}

TEST(Advice, NoOutput) { expect_said("no output", pool.substr(0, pool.find("[output")), {}); }

TEST(RunCost, MoreThanTheDiskHolds) {
  EXPECT_TRUE(disk_warnings(1e3, "there/is/no/such/folder").empty());
  EXPECT_EQ(disk_warnings(1e24, "there/is/no/such/folder").size(), 1U);
}

TEST(RunCost, BytesOfFrames) {
  const Scene scene = parse_scene("scene.toml", pool + "[output.vtu]\nevery = 0.1\nfields = [\"velocity\"]\n", {});
  // 11 frames of 24 bytes for a position and 12 for a velocity, and 61 rows of the series.
  EXPECT_DOUBLE_EQ(output_bytes(scene, 1000), 11 * 1000 * 36 + 61 * 500);
}

}  // namespace
}  // namespace trevi
