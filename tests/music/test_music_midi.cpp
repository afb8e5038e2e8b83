// MIDI files: the same melody as the text score, choice of track and channel, tempo, and damage of every kind.
#include <gtest/gtest.h>

#include <random>

#include "music_files.hpp"

namespace trevi::test {
namespace {

using namespace std::string_literals;

Melody midi(const std::string& bytes, int track = 0, int channel = 0) {
  MusicSettings settings;
  settings.track = track;
  settings.channel = channel;
  return read_midi("m.mid", bytes, settings);
}

std::string refused(const std::string& bytes, int track = 0, int channel = 0) {
  return problem([&] { midi(bytes, track, channel); });
}

TEST(Midi, OdeToJoyIsThatOfTheScore) {
  const Melody text = read_score("ode_to_joy.txt", input_file("ode_to_joy.txt"));
  const Melody melody = midi(input_file("ode_to_joy.mid"), 2);
  ASSERT_EQ(melody.tones.size(), text.tones.size());
  ASSERT_EQ(text.tones.size(), 30u);
  for (std::size_t i = 0; i < text.tones.size(); ++i) {
    EXPECT_NEAR(melody.tones[i].start, text.tones[i].start, 1e-4) << i;
    EXPECT_NEAR(melody.tones[i].stop, text.tones[i].stop, 2e-3) << i;
    EXPECT_EQ(melody.tones[i].height, text.tones[i].height) << i;
  }
  EXPECT_EQ(melody.lowest, text.lowest);
  EXPECT_EQ(melody.highest, text.highest);
}

TEST(Midi, TrackAndChannelChooseAVoice) {
  const std::string ode = input_file("ode_to_joy.mid");
  EXPECT_EQ(midi(ode, 3).highest, 48);
  EXPECT_EQ(midi(ode, 0, 2).highest, 48);
  EXPECT_EQ(midi(ode, 0, 1).highest, 67);
  EXPECT_EQ(midi(ode).lowest, 43);
  EXPECT_EQ(midi(ode).highest, 67);
  EXPECT_NE(refused(ode, 1).find("no note in track 1"), std::string::npos);
  EXPECT_NE(refused(ode, 2, 2).find("notes are in track 2 channel 1, track 3 channel 2"), std::string::npos)
      << refused(ode, 2, 2);
}

TEST(Midi, TempoChangesWhereTheFileSays) {
  // A quarter at 0.5 s, then one at 1 s; running status and a note-on of velocity 0 as its end.
  const Melody melody =
      midi(midi_header(1) + midi_track("\x00\x90\x3c\x40"s + "\x83\x60\x3c\x00"s + "\x00\xff\x51\x03\x0f\x42\x40"s +
                                       "\x00\x90\x40\x40"s + "\x83\x60\x80\x40\x00"s));
  ASSERT_EQ(melody.tones.size(), 2u);
  EXPECT_DOUBLE_EQ(melody.tones[0].stop, 0.5);
  EXPECT_DOUBLE_EQ(melody.tones[1].start, 0.5);
  EXPECT_DOUBLE_EQ(melody.tones[1].stop, 1.5);
}

TEST(Midi, DrumsPlayOnlyWhenAskedFor) {
  const std::string drums = midi_header(1) + midi_track("\x00\x99\x24\x40\x60\x89\x24\x00"s);
  EXPECT_NE(refused(drums).find("drums"), std::string::npos);
  EXPECT_EQ(midi(drums, 0, 10).highest, 36);
}

TEST(Midi, LongTextsAndExclusiveMessagesAreSkipped) {
  const std::string text = "\x00\xff\x01\x81\x48"s + std::string(200, 'x');
  const Melody melody = midi(midi_header(1) + midi_track(text + "\x00\xf0\x02\x01\x02\x10\xf7\x02\x03\xf7"s +
                                                         "\x00\x90\x3c\x40\x60\x80\x3c\x00"s));
  ASSERT_EQ(melody.tones.size(), 1u);
  EXPECT_DOUBLE_EQ(melody.tones[0].start, 16 * 0.5 / 480);  // the time of what is skipped counts
}

TEST(Midi, NotesWithoutAnEndLastToTheEnd) {
  const Melody melody = midi(midi_header(1) + midi_track("\x00\x90\x3c\x40\x83\x60\x90\x40\x40\x83\x60\x80\x40\x00"s));
  ASSERT_EQ(melody.tones.size(), 2u);
  EXPECT_EQ(melody.at(0.2)->height, 60);
  EXPECT_EQ(melody.at(0.7)->height, 64);
}

TEST(Midi, CutShortAtAnyByteIsAnErrorThatNamesIt) {
  const std::string ode = input_file("ode_to_joy.mid");
  ASSERT_GT(ode.size(), 400u);
  for (std::size_t length = 0; length < ode.size(); ++length) {
    const std::string text = refused(ode.substr(0, length));
    EXPECT_NE(text.find("m.mid: byte " + std::to_string(length) + ":"), std::string::npos) << length << ": " << text;
  }
}

TEST(Midi, WhatIsNoMidiIsNamed) {
  EXPECT_NE(refused("RIFF and so on").find("byte 0: not a Standard MIDI File"), std::string::npos);
  EXPECT_NE(refused(midi_header(1, 0xe728) + midi_track("")).find("SMPTE"), std::string::npos);
  EXPECT_NE(refused(midi_header(1, 0xe728) + midi_track("")).find("SMPTE frames (25 a second)"), std::string::npos);
  EXPECT_NE(refused(midi_header(1, 0) + midi_track("")).find("0 ticks per quarter note"), std::string::npos);
  std::string several = midi_header(1) + midi_track("");
  several[9] = 2;
  EXPECT_NE(refused(several).find("format 2, several pieces"), std::string::npos);
  EXPECT_NE(refused(midi_header(1) + midi_track("\x00\x90\x3c\x40"s)).find("never end (no note-off)"),
            std::string::npos);
  EXPECT_NE(refused(midi_header(1) + midi_track("\x00\x40\x40"s)).find("without a status byte"), std::string::npos);
  EXPECT_NE(refused(midi_header(1) + midi_track("\x00\x90\x80\x40"s)).find("over 127"), std::string::npos);
  EXPECT_NE(refused(midi_header(1) + midi_track("\x00\xff\x51\x03\x00\x00\x00"s)).find("tempo"), std::string::npos);
  EXPECT_NE(refused(midi_header(1) + midi_track("")).find("the file has no notes at all"), std::string::npos);
  EXPECT_NE(refused(midi_header(0)).find("there is no track"), std::string::npos);
}

TEST(Midi, DamagedBytesNeverCrash) {
  const std::string ode = input_file("ode_to_joy.mid");
  std::mt19937 random(3);
  for (int trial = 0; trial < 20000; ++trial) {
    std::string damaged = ode;
    for (int k = 0; k < 1 + trial % 4; ++k) damaged[random() % damaged.size()] = static_cast<char>(random() & 0xff);
    refused(damaged);
  }
}

}  // namespace
}  // namespace trevi::test
