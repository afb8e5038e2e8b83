// Music for tests: the files of inputs/, and small MIDI and WAV files made in memory, good and bad.
#pragma once

#include <cmath>
#include <fstream>
#include <functional>
#include <iterator>
#include <numbers>
#include <string>
#include <vector>

#include "music/music.hpp"
#include "trevi/error.hpp"

namespace trevi::test {

inline std::string input_file(const std::string& name) {
  std::ifstream file(std::string(TREVI_INPUTS) + "/" + name, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

/// The message of the InputError that `work` throws; empty when it throws none.
inline std::string problem(const std::function<void()>& work) {
  try {
    work();
  } catch (const InputError& error) {
    return error.what();
  }
  return "";
}

inline std::string little_endian(unsigned value, int size) {
  std::string bytes;
  for (int i = 0; i < size; ++i) bytes += static_cast<char>(value >> 8 * i & 0xffU);
  return bytes;
}

/// 16 bits, mono. Samples of [-1, 1].
inline std::string wav(const std::vector<Real>& samples, unsigned rate) {
  std::string data;
  for (const Real sample : samples)
    data += little_endian(static_cast<unsigned>(std::lround(sample * 32767)) & 0xffffU, 2);
  const auto size = static_cast<unsigned>(data.size());
  return "RIFF" + little_endian(36 + size, 4) + "WAVEfmt " + little_endian(16, 4) + little_endian(1, 2) +
         little_endian(1, 2) + little_endian(rate, 4) + little_endian(2 * rate, 4) + little_endian(2, 2) +
         little_endian(16, 2) + "data" + little_endian(size, 4) + data;
}

/// The same samples in two channels, turned over in the second.
inline std::string antiphase_wav(const std::vector<Real>& samples, unsigned rate) {
  std::vector<Real> both;
  for (const Real sample : samples) both.insert(both.end(), {sample, -sample});
  std::string file = wav(both, rate);
  file.replace(22, 2, little_endian(2, 2));
  file.replace(28, 4, little_endian(4 * rate, 4));
  return file.replace(32, 2, little_endian(4, 2));
}

/// A tone with two overtones, at full height from the first sample to the last.
inline std::vector<Real> sung(Real note, Real seconds, Real rate, Real height = 0.5) {
  std::vector<Real> samples(static_cast<std::size_t>(seconds * rate));
  const Real turn = 2 * std::numbers::pi * 440 * std::exp2((note - 69) / 12) / rate;
  for (std::size_t i = 0; i < samples.size(); ++i) {
    const Real phase = turn * static_cast<Real>(i);
    samples[i] = height * (std::sin(phase) + 0.5 * std::sin(2 * phase) + 0.3 * std::sin(3 * phase)) / 1.8;
  }
  return samples;
}

inline std::string big_endian(unsigned value, int size) {
  std::string bytes;
  for (int i = size - 1; i >= 0; --i) bytes += static_cast<char>(value >> 8 * i & 0xffU);
  return bytes;
}

inline std::string midi_header(unsigned tracks, unsigned division = 480) {
  return "MThd" + big_endian(6, 4) + big_endian(tracks > 1 ? 1 : 0, 2) + big_endian(tracks, 2) +
         big_endian(division, 2);
}

/// The end of the track is added.
inline std::string midi_track(std::string events) {
  events += std::string("\x00\xff\x2f\x00", 4);
  return "MTrk" + big_endian(static_cast<unsigned>(events.size()), 4) + events;
}

inline SpeedScale scale_between(Real low, Real high, SpeedMapping mapping = SpeedMapping::linear) {
  MusicSettings settings;
  settings.speed_range = {low, high};
  settings.mapping = mapping;
  return SpeedScale(settings);
}

inline Melody score(const std::string& text) { return read_score("s.txt", text); }

}  // namespace trevi::test
