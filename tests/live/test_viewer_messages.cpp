// The messages between run and viewer: what is written is read, what is damaged is not.
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>

#include "live/viewer_key.hpp"
#include "live/viewer_messages.hpp"
#include "trevi/error.hpp"

namespace trevi {
namespace {

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

std::string with(std::string text, const std::string& old, const std::string& now) {
  const std::size_t at = text.find(old);
  EXPECT_NE(at, std::string::npos) << old;
  return text.replace(at, old.size(), now);
}

TEST(ViewerMessages, EveryCountIsCheckedAgainstTheFrame) {
  ViewedFrame frame;
  frame.rank_counts = {40, 60};
  frame.shown.resize(100);
  const auto bytes_of = [&] {
    return std::string(reinterpret_cast<const char*>(frame.shown.data()), 100 * sizeof(ViewedParticle));
  };
  const std::string text = text_of(frame), bytes = bytes_of(), counts = "[40,60]";
  EXPECT_TRUE(read_frame(text, bytes).has_value());
  EXPECT_TRUE(read_frame(with(text, counts, "[0,100,0]"), bytes).has_value());
  for (const char* bad :
       {"[1000000000,-999999900]", "[40,61]", "[40,59]", "[]", "[100.0]", "[1e300]", "[101,-1]",
        "[9223372036854775807,9223372036854775807,102]", "[18446744073709551615,101]", "[null,100]", "7", "[\"100\"]"})
    EXPECT_FALSE(read_frame(with(text, counts, bad), bytes).has_value()) << bad;
  for (const auto& [old, bad] :
       {std::pair("\"level\":0", "\"level\":63"), std::pair("\"level\":0", "\"level\":-1"),
        std::pair("\"step\":0", "\"step\":-1"), std::pair("\"step\":0", "\"step\":1e19"),
        std::pair("\"particles\":0", "\"particles\":-1"), std::pair("\"time\":0.0", "\"time\":null")})
    EXPECT_FALSE(read_frame(with(text, old, bad), bytes).has_value()) << bad;
  EXPECT_FALSE(read_frame(text, bytes + "x").has_value());
  frame.shown[70].y = NAN;
  EXPECT_FALSE(read_frame(text, bytes_of()).has_value());
}

TEST(ViewerMessages, ABoxIsABoxAndAWishIsACount) {
  const std::string scene = text_of(ViewedScene()), wishes = text_of(ViewerWishes());
  EXPECT_TRUE(read_scene(scene).has_value());
  for (const auto& [old, bad] :
       {std::pair("[1.0,1.0,1.0]", "[1.0,1.0]"), std::pair("[1.0,1.0,1.0]", "[1.0,0.0,1.0]"),
        std::pair("[1.0,1.0,1.0]", "[1e308,1e308,null]"), std::pair("\"spacing\":0.1", "\"spacing\":0"),
        std::pair("\"spacing\":0.1", "\"spacing\":-1"), std::pair("\"ranks\":1", "\"ranks\":-2147483649"),
        std::pair("\"last_step\":0", "\"last_step\":1e30"), std::pair("1000.0", "0")})
    EXPECT_FALSE(read_scene(with(scene, old, bad)).has_value()) << bad;
  EXPECT_TRUE(read_wishes(wishes).has_value());
  for (const auto& [old, bad] : {std::pair("\"budget\":0", "\"budget\":-1"), std::pair("\"seen\":-1", "\"seen\":1e99"),
                                 std::pair("\"single_steps\":0", "\"single_steps\":18446744073709551615")})
    EXPECT_FALSE(read_wishes(with(wishes, old, bad)).has_value()) << bad;
}

TEST(ViewerKeys, AreSharedByTheEndsOfARunAndKeptFromOthers) {
  namespace fs = std::filesystem;
  const std::string folder = testing::TempDir() + "viewer_keys", file = folder + "/" + viewer_key_file;
  fs::remove_all(folder);
  const ViewerKey made = viewer_key_of(folder), found = viewer_key_of(folder);
  EXPECT_EQ(made.secret, found.secret);
  EXPECT_EQ(made.open, found.open);
  EXPECT_EQ(fs::status(file).permissions(), fs::perms::owner_read | fs::perms::owner_write);
  EXPECT_NE(new_viewer_key().secret, made.secret);
  fs::permissions(file, fs::perms::group_read, fs::perm_options::add);
  EXPECT_THROW(viewer_key_of(folder), InputError);
  fs::remove(file);
  std::ofstream(file) << "too short";
  fs::permissions(file, fs::perms::owner_read);
  EXPECT_THROW(viewer_key_of(folder), InputError);
  fs::remove(file);
  const std::string elsewhere = folder + "/elsewhere";
  viewer_key_of(elsewhere);
  fs::create_symlink(elsewhere + "/" + viewer_key_file, file);  // to a key that another program may have chosen
  EXPECT_THROW(viewer_key_of(folder), InputError);
  fs::remove_all(folder);
}

TEST(ViewerMessages, Addresses) {
  EXPECT_EQ(viewer_endpoint("--view", "5555"), "tcp://127.0.0.1:5555");
  EXPECT_EQ(viewer_endpoint("--view", "node7:80"), "tcp://node7:80");
  for (const char* bad : {"", ":", "host:", ":80", "host:0", "host:65536", "host:8o", "tcp://host:-1"})
    EXPECT_THROW(viewer_endpoint("--view", bad), InputError) << bad;
}

}  // namespace
}  // namespace trevi
