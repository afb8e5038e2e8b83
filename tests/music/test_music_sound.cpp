// Sound files: the same melody as the text score by pitch and by loudness, and files with nothing to hear.
#include <gtest/gtest.h>

#include <algorithm>

#include "music/sound.hpp"
#include "music_files.hpp"

namespace trevi::test {
namespace {

std::string refused(const std::string& bytes, Follow follow = Follow::loudness) {
  return problem([&] { read_sound("v.wav", bytes, follow); });
}

/// Times at which a melody begins to sound after a rest.
std::vector<Real> onsets(const Melody& melody) {
  std::vector<Real> times;
  for (std::size_t i = 0; i < melody.tones.size(); ++i) {
    if (i == 0 || melody.tones[i].start > melody.tones[i - 1].stop) times.push_back(melody.tones[i].start);
  }
  return times;
}

class OdeToJoy : public testing::Test {
 protected:
  const Melody text = read_score("ode_to_joy.txt", input_file("ode_to_joy.txt"));
  const std::string sound = input_file("ode_to_joy.wav");
};

TEST_F(OdeToJoy, SoundBeginsWhereNotesBegin) {
  for (const Follow follow : {Follow::loudness, Follow::pitch}) {
    const std::vector<Real> heard = onsets(read_sound("v.wav", sound, follow));
    ASSERT_EQ(heard.size(), text.tones.size());
    for (std::size_t i = 0; i < heard.size(); ++i) EXPECT_NEAR(heard[i], text.tones[i].start, 0.025) << i;
  }
}

TEST_F(OdeToJoy, PitchAndItsSpeedAreThoseOfTheScore) {
  const SpeedScale scale = scale_between(8, 20);
  const Melody melody = read_sound("v.wav", sound, Follow::pitch);
  const MelodyPump heard(melody, scale), written(text, scale);
  for (const Tone& tone : text.tones) {
    const Real middle = (tone.start + tone.stop) / 2;
    ASSERT_TRUE(heard.at(middle)) << middle;
    EXPECT_NEAR(heard.at(middle)->note, tone.height, 0.15) << middle;
    EXPECT_NEAR(heard.at(middle)->speed, written.at(middle)->speed, 0.35) << middle;
  }
}

TEST_F(OdeToJoy, LouderNotesGiveHigherSpeeds) {
  const Melody melody = read_sound("v.wav", sound, Follow::loudness);
  const MelodyPump pump(melody, scale_between(0, 1));
  for (const Tone& a : text.tones) {
    const FountainState state = *pump.at((a.start + a.stop) / 2);
    EXPECT_TRUE(std::isnan(state.note));
    // make_music.py plays the lowest note at 2/7 of the peak of the highest.
    const Real x = (a.height - text.lowest) / (text.highest - text.lowest);
    EXPECT_NEAR(state.speed, (0.2 + 0.5 * x) / 0.7, 0.02);
  }
}

TEST(Ear, HearsThePitchOfAVoice) {
  for (const Real rate : {8000.0, 22050.0, 44100.0, 48000.0, 96000.0}) {
    const Ear ear(rate);
    for (Real note = 40; note <= 84; note += 3.3) {
      const std::vector<Real> voice = sung(note, 0.1, rate);
      const std::vector<float> samples(voice.begin(), voice.end());
      EXPECT_NEAR(ear.pitch(samples), note, 0.25) << rate << " Hz";
    }
  }
}

TEST(Ear, HearsNoPitchInNoise) {
  const Ear ear(44100);
  std::vector<float> samples(ear.window());
  unsigned state = 1;
  for (float& sample : samples) sample = static_cast<float>((state = state * 1664525U + 1013904223U) >> 16) / 32768 - 1;
  EXPECT_TRUE(std::isnan(ear.pitch(samples)));
  EXPECT_TRUE(std::isnan(ear.pitch(std::vector<float>(ear.window(), 0.0F))));
}

TEST(Ear, LoudnessIsTheRootMeanSquare) {
  const Ear ear(44100);
  EXPECT_NEAR(ear.loudness(std::vector<float>(ear.window(), -0.5F)), 0.5, 1e-6);
}

TEST(Sound, AGlidingVoiceRises) {
  std::vector<Real> samples;
  for (int note = 60; note <= 72; ++note) {
    const std::vector<Real> part = sung(note, 0.2, 16000);
    samples.insert(samples.end(), part.begin(), part.end());
  }
  const Melody melody = read_sound("v.wav", wav(samples, 16000), Follow::pitch);
  EXPECT_NEAR(melody.lowest, 60, 0.2);
  EXPECT_NEAR(melody.highest, 72, 0.2);
  for (int k = 0; k < 12; ++k) EXPECT_LT(melody.at(0.1 + 0.2 * k)->height, melody.at(0.3 + 0.2 * k)->height);
}

TEST(Sound, EmptySilentAndForeignFilesAreErrors) {
  EXPECT_NE(refused("").find("v.wav: byte 0: the sound file is empty"), std::string::npos);
  EXPECT_NE(refused(wav({}, 8000)).find("silent"), std::string::npos) << refused(wav({}, 8000));
  EXPECT_NE(refused(wav(std::vector<Real>(8000, 0.0), 8000)).find("silent in all its 1.0"), std::string::npos);
  EXPECT_NE(refused("no sound at all").find("cannot read it"), std::string::npos);
  EXPECT_NE(refused(wav(sung(60, 0.5, 8000), 10)).find("10 Hz"), std::string::npos);
  const std::string whole = wav(sung(60, 0.5, 8000), 8000);
  EXPECT_EQ(refused(whole), "");
  for (const char* const size : {"\0\0\0", "\xFF\xFF\xFF\xFF", "\x24\0\0\x80", "\x24\xF0\xFF\x7F"}) {  // of streams
    std::string streamed = whole;
    streamed.replace(4, 4, size, 4);
    EXPECT_EQ(refused(streamed), "");
  }
  EXPECT_NE(refused(whole.substr(0, 1000)).find("v.wav: holds 1000 bytes of the 8044 "), std::string::npos)
      << refused(whole.substr(0, 1000));
}

TEST(Sound, WithoutAVoiceThereIsNoPitch) {
  std::vector<Real> noise(8000);
  unsigned state = 1;
  for (Real& sample : noise) sample = ((state = state * 1664525U + 1013904223U) >> 16) / 40000.0 - 0.8;
  EXPECT_NE(refused(wav(noise, 8000), Follow::pitch).find("no voice"), std::string::npos);
  EXPECT_EQ(refused(wav(noise, 8000), Follow::loudness), "");
}

TEST(Sound, CutShortAnywhereIsReadOrRefused) {
  const std::string whole = wav(sung(69, 0.2, 8000), 8000);
  for (std::size_t length = 0; length < whole.size(); length += length < 64 ? 1 : 97)
    refused(whole.substr(0, length), Follow::pitch);
}

// Their mean is silence; a listener hears either.
TEST(Sound, ChannelsInOppositePhaseAreNotSilent) {
  const std::vector<Real> tone = sung(69, 1, 16000);
  const Melody one = read_sound("v.wav", wav(tone, 16000), Follow::pitch);
  const Melody two = read_sound("v.wav", antiphase_wav(tone, 16000), Follow::pitch);
  ASSERT_FALSE(one.tones.empty());
  ASSERT_EQ(one.tones.size(), two.tones.size());
  for (std::size_t k = 0; k < one.tones.size(); ++k) EXPECT_NEAR(one.tones[k].height, two.tones[k].height, 1e-3);
}

}  // namespace
}  // namespace trevi::test
