// Live sound: rank 0 alone has the stream, all ranks agree on what is heard, and nobody waits for it.
#include <gtest/gtest.h>
#include <unistd.h>

#include <array>
#include <cstdio>

#include "music/sound.hpp"
#include "music_files.hpp"
#include "trevi/error.hpp"

namespace trevi::test {
namespace {

constexpr Real rate = 22050;

std::string raw(const std::vector<Real>& samples) { return wav(samples, 22050).substr(44); }

StepInfo step_at(std::int64_t step, Real dt = 0.01) { return {step, 0, static_cast<Real>(step) * dt, dt}; }

bool root() { return rank_of(MPI_COMM_WORLD) == 0; }

void expect_same_everywhere(Real value) {
  const Real all[2] = {value, -value};
  Real most[2];
  MPI_Allreduce(all, most, 2, MPI_DOUBLE, MPI_MAX, MPI_COMM_WORLD);
  EXPECT_EQ(most[0], -most[1]);
}

/// A pipe on rank 0; the other ranks have nothing to read from.
class LivePipe : public testing::Test {
 protected:
  LivePipe() {
    if (root() && pipe(ends.data()) != 0) ADD_FAILURE() << "no pipe";
  }
  ~LivePipe() override { hang_up(); }

  void play(const std::string& bytes) {
    if (root() && write(ends[1], bytes.data(), bytes.size()) != static_cast<ssize_t>(bytes.size()))
      ADD_FAILURE() << "the pipe is full";
  }
  void hang_up() {
    if (root() && ends[1] >= 0) close(ends[1]);
    ends[1] = -1;
  }

  std::array<int, 2> ends = {-1, -1};
};

TEST_F(LivePipe, AllRanksHearTheSameAndNobodyWaits) {
  LiveSound sound(MPI_COMM_WORLD, ends[0], rate);
  sound.listen(step_at(0));  // nothing to hear yet
  EXPECT_EQ(sound.level(), 0);
  play(raw(sung(69, 0.2, rate)));
  sound.listen(step_at(1));
  EXPECT_EQ(sound.level(), 1);
  EXPECT_NEAR(sound.pitch(), 69, 0.2);
  expect_same_everywhere(sound.pitch());
  sound.listen(step_at(2));  // nothing new: what was heard last holds
  EXPECT_EQ(sound.level(), 1);
  play("x" + raw(sung(72, 0.1, rate, 0.25)).substr(1));
  sound.listen(step_at(3));
  EXPECT_NEAR(sound.level(), 0.5, 0.02);
  expect_same_everywhere(sound.level());
  hang_up();
  sound.listen(step_at(4));
  EXPECT_EQ(sound.level(), 0);
  EXPECT_TRUE(std::isnan(sound.pitch()));
}

TEST_F(LivePipe, HalfASampleWaitsForItsOtherHalf) {
  LiveSound sound(MPI_COMM_WORLD, ends[0], rate);
  const std::string bytes = raw(sung(69, 0.2, rate));
  play(bytes.substr(0, 4001));
  sound.listen(step_at(0));
  EXPECT_NEAR(sound.pitch(), 69, 0.2);
  play(bytes.substr(4001, 1000));
  sound.listen(step_at(1));
  EXPECT_NEAR(sound.pitch(), 69, 0.2);
}

TEST_F(LivePipe, TwoPumpsShareOneStream) {
  const auto sound = std::make_shared<LiveSound>(MPI_COMM_WORLD, ends[0], rate);
  const SpeedScale scale = scale_between(8, 20);
  LivePump loud(sound, Follow::loudness, scale), sings(sound, Follow::pitch, scale);
  EXPECT_FALSE(loud.at(0));
  EXPECT_FALSE(sings.at(0));
  play(raw(sung(66, 0.1, rate)));
  loud.prepare(step_at(0));
  sings.prepare(step_at(0));
  EXPECT_EQ(loud.at(0)->speed, 20);
  EXPECT_TRUE(std::isnan(loud.at(0)->note));
  EXPECT_NEAR(sings.at(0)->speed, 14, 0.2);  // half way from C3 to C6
}

TEST(LiveFile, IsHeardAtTheSimulatedTime) {
  std::FILE* file = root() ? std::tmpfile() : nullptr;
  std::string bytes = raw(sung(60, 1, rate)) + raw(sung(72, 1, rate));
  if (root()) std::fwrite(bytes.data(), 1, bytes.size(), file);
  if (root()) std::fflush(file);
  LiveSound sound(MPI_COMM_WORLD, root() ? fileno(file) : -1, rate);
  sound.listen(step_at(1, 0.5));
  EXPECT_NEAR(sound.pitch(), 60, 0.2);
  sound.listen(step_at(3, 0.5));
  EXPECT_NEAR(sound.pitch(), 72, 0.2);
  sound.listen(step_at(9, 0.5));
  EXPECT_EQ(sound.level(), 0);
  if (root()) std::fclose(file);
}

TEST(LiveNothing, IsAnErrorOnAllRanks) { EXPECT_THROW(LiveSound(MPI_COMM_WORLD, -1, rate), InputError); }

}  // namespace
}  // namespace trevi::test
