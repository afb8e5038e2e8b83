// The messages between run and viewer: what is written is read, what is damaged is not.
#include <gtest/gtest.h>

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

TEST(ViewerMessages, Addresses) {
  EXPECT_EQ(viewer_endpoint("--view", "5555"), "tcp://127.0.0.1:5555");
  EXPECT_EQ(viewer_endpoint("--view", "node7:80"), "tcp://node7:80");
  for (const char* bad : {"", ":", "host:", ":80", "host:0", "host:65536", "host:8o", "tcp://host:-1"})
    EXPECT_THROW(viewer_endpoint("--view", bad), InputError) << bad;
}

}  // namespace
}  // namespace trevi
