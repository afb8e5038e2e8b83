// Melodies: scores, overlapping notes, and how notes become speeds. MIDI and sound are in their own files.
#include <gtest/gtest.h>

#include "music_files.hpp"

namespace trevi::test {
namespace {

TEST(NoteNames, AreMidiNumbers) {
  EXPECT_EQ(note_number("C4"), 60);
  EXPECT_EQ(note_number("A4"), 69);
  EXPECT_EQ(note_number("F#5"), 78);
  EXPECT_EQ(note_number("Bb3"), 58);
  EXPECT_EQ(note_number("bb3"), 58);
  EXPECT_EQ(note_number("b3"), 59);
  EXPECT_EQ(note_number("Cb4"), 59);
  EXPECT_EQ(note_number("B#4"), 72);
  EXPECT_EQ(note_number("C-1"), 0);
  EXPECT_EQ(note_number("G9"), 127);
  for (const char* none : {"", "C", "H4", "4", " 4", "C#", "C##4", "C10", "C-2", "C4 ", "C4x", "#4", "Cb#4"})
    EXPECT_FALSE(note_number(none)) << none;
}

TEST(Score, LinesBecomeTones) {
  const Melody melody = score("\xEF\xBB\xBF# a comment\r\n\n 0.5 F#4 0.5 # sharp, not a comment\r\n1 60 1\n2\t61.5\t1");
  ASSERT_EQ(melody.tones.size(), 3u);
  EXPECT_EQ(melody.tones[0].height, 66);
  EXPECT_EQ(melody.tones[1].height, 60);
  EXPECT_EQ(melody.tones[2].height, 61.5);
  EXPECT_EQ(melody.lowest, 60);
  EXPECT_EQ(melody.highest, 66);
  EXPECT_EQ(melody.at(0.49), nullptr);
  EXPECT_EQ(melody.at(0.5)->height, 66);
  EXPECT_EQ(melody.at(1)->height, 60);
  EXPECT_EQ(melody.at(2.9)->height, 61.5);
  EXPECT_EQ(melody.at(3), nullptr);
  EXPECT_EQ(melody.at(-1), nullptr);
}

TEST(Score, BadLinesAreAllNamed) {
  const std::string text = problem([] { score("0 C4 1\n1 H4 1\n2 C4\n-1 C4 1\n3 C4 0\n4 128 1\nx C4 1\n5 C4 nan\n"); });
  for (const char* words : {"s.txt:2: pitch", "\"H4\"", "s.txt:3: expected time, pitch and length, got 2",
                            "s.txt:4: time", "s.txt:5: length", "s.txt:6: pitch", "s.txt:7: time", "s.txt:8: length"})
    EXPECT_NE(text.find(words), std::string::npos) << words << " not in\n" << text;
  EXPECT_EQ(text.find("s.txt:1:"), std::string::npos);
}

TEST(Score, WithoutANoteIsAnError) {
  EXPECT_NE(problem([] { score(""); }).find("s.txt:1: no note"), std::string::npos);
  EXPECT_NE(problem([] { score("# nothing\n\n"); }).find("no note"), std::string::npos);
}

TEST(Score, ManyBadLinesAreCounted) {
  std::string text;
  for (int i = 0; i < 50; ++i) text += "nonsense\n";
  EXPECT_NE(problem([&] { score(text); }).find("40 more bad lines"), std::string::npos);
}

TEST(Melody, OfOverlappingNotesTheHighestSounds) {
  const Melody melody = score("0 A4 2\n0.5 C5 0.5\n0.75 E4 3\n0.5 C5 0.25\n");
  const auto note = [&](Real time) { return melody.at(time) != nullptr ? melody.at(time)->height : 0; };
  EXPECT_EQ(note(0.2), 69);
  EXPECT_EQ(note(0.5), 72);
  EXPECT_EQ(note(0.9), 72);
  EXPECT_EQ(note(1.0), 69);
  EXPECT_EQ(note(1.9), 69);
  EXPECT_EQ(note(2.0), 64);
  EXPECT_EQ(note(3.8), 0);
  for (std::size_t i = 1; i < melody.tones.size(); ++i) EXPECT_GE(melody.tones[i].start, melody.tones[i - 1].stop);
}

TEST(Pump, HigherNoteHigherJetOverAnOctave) {
  std::string text;
  for (int k = 0; k <= 12; ++k) text += std::to_string(k) + " " + std::to_string(60 + k) + " 1\n";
  for (const SpeedMapping mapping : {SpeedMapping::linear, SpeedMapping::energy}) {
    const MelodyPump pump(score(text), scale_between(8, 20, mapping));
    Real last = 0;
    for (int k = 0; k <= 12; ++k) {
      const std::optional<FountainState> state = pump.at(k + 0.5);
      ASSERT_TRUE(state);
      EXPECT_EQ(state->note, 60 + k);
      EXPECT_GT(state->speed, last);
      last = state->speed;
    }
    EXPECT_EQ(pump.at(0)->speed, 8);
    EXPECT_DOUBLE_EQ(pump.at(12)->speed, 20);
    EXPECT_FALSE(pump.at(13));
  }
}

TEST(Pump, EqualEnergyIsLinearInTheSquareOfTheSpeed) {
  const SpeedScale energy = scale_between(6, 10, SpeedMapping::energy), linear = scale_between(6, 10);
  EXPECT_DOUBLE_EQ(energy.speed(0), 6);
  EXPECT_DOUBLE_EQ(energy.speed(0.5), std::sqrt((36.0 + 100.0) / 2));
  EXPECT_DOUBLE_EQ(energy.speed(1), 10);
  EXPECT_DOUBLE_EQ(linear.speed(0.25), 7);
  EXPECT_DOUBLE_EQ(linear.speed(2), 10);
}

TEST(Pump, FastestOfSomeTimeIsItsHighestNote) {
  const MelodyPump pump(score("0 C4 1\n1 C5 0.5\n2 F#4 1"), scale_between(8, 20));
  EXPECT_EQ(pump.fastest({0, 1}), 8);
  EXPECT_EQ(pump.fastest({0.5, 1.01}), 20);
  EXPECT_EQ(pump.fastest({1.5, 2}), std::nullopt);
  EXPECT_EQ(pump.fastest({1.5, 2.5}), 14);
  EXPECT_EQ(pump.fastest({1.2, 9}), 20);
  EXPECT_EQ(pump.fastest({3, 9}), std::nullopt);
}

TEST(Pump, OneNotePlaysAtTheHighEnd) {
  const MelodyPump pump(score("0 C4 1"), scale_between(8, 20));
  EXPECT_EQ(pump.at(0.5)->speed, 20);
}

}  // namespace
}  // namespace trevi::test
