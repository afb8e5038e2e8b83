// A scene's music as samples: tones of scores and MIDI files as a sine with two overtones, sound files as recorded.
#include <algorithm>
#include <cmath>
#include <numbers>
#include <set>

#include "io/run_directory/files.hpp"
#include "music/sound.hpp"
#include "view/music_player.hpp"

namespace trevi {

namespace {

constexpr double loudness = 0.3;  // of full scale, for one voice
constexpr double attack = 0.01;   // s
constexpr double release = 0.05;  // s
constexpr double loudest_sum = 0.9;

void add(Pcm& music, std::size_t at, double value) {
  if (at >= music.samples.size()) music.samples.resize(at + 1, 0.0F);
  music.samples[at] += static_cast<float>(value);
}

void add_tone(Pcm& music, const Tone& tone) {
  const double frequency = 440 * std::exp2((tone.height - 69) / 12), length = tone.stop - tone.start;
  const auto first = static_cast<std::size_t>(std::max(0.0, tone.start) * pcm_rate);
  const auto count = static_cast<std::size_t>((length + release) * pcm_rate);
  for (std::size_t k = 0; k < count; ++k) {
    const double t = static_cast<double>(k) / pcm_rate, phase = 2 * std::numbers::pi * frequency * t;
    const double swell = std::min(1.0, t / attack), fade = std::clamp((length + release - t) / release, 0.0, 1.0);
    const double wave = std::sin(phase) + 0.3 * std::sin(2 * phase) + 0.1 * std::sin(3 * phase);
    add(music, first + k, loudness * swell * fade * std::exp(-1.5 * t) * wave);
  }
}

/// At our sample rate, interpolated from the nearest two samples.
void add_recording(Pcm& music, const Recording& recording) {
  const double step = recording.rate / pcm_rate;
  const auto count = static_cast<std::size_t>(static_cast<double>(recording.samples.size()) / step);
  for (std::size_t k = 0; k < count; ++k) {
    const double position = static_cast<double>(k) * step;
    const auto left = static_cast<std::size_t>(position);
    const std::size_t right = std::min(left + 1, recording.samples.size() - 1);
    const double part = position - static_cast<double>(left);
    add(music, k, std::lerp(static_cast<double>(recording.samples[left]), recording.samples[right], part));
  }
}

void add_music(Pcm& music, const MusicSettings& settings) {
  if (settings.kind == MusicKind::live) return;  // live sound is gone
  const std::string bytes = read_text(settings.source);
  if (settings.kind == MusicKind::sound) return add_recording(music, read_recording(settings.source, bytes));
  for (const Tone& tone : read_melody(bytes, settings).tones) add_tone(music, tone);
}

}  // namespace

Pcm music_of(const Scene& scene) {
  Pcm music;
  std::set<std::string> heard;  // fountains that follow one file are one voice each of the same sound
  for (const FountainSettings& fountain : scene.fountains) {
    if (!fountain.music) continue;
    const MusicSettings& settings = *fountain.music;
    const bool tracks = settings.kind == MusicKind::midi;
    const std::string voice = settings.source + (tracks ? std::to_string(settings.track * 17 + settings.channel) : "");
    if (heard.insert(voice).second) add_music(music, settings);
  }
  float peak = 0;
  for (const float sample : music.samples) peak = std::max(peak, std::abs(sample));
  if (peak > loudest_sum)
    for (float& sample : music.samples) sample *= static_cast<float>(loudest_sum) / peak;
  return music;
}

}  // namespace trevi
