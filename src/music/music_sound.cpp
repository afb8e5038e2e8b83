// Sound files, read by libsndfile from memory: loudness or pitch every 10 ms.
#include <sndfile.h>

#include <algorithm>
#include <cstring>
#include <memory>
#include <numeric>

#include "music/sound.hpp"
#include "trevi/error.hpp"

namespace trevi {

namespace {

constexpr Real hop = 0.01;                                 // s, from one moment to the next
constexpr Real min_peak = 1e-4;                            // of full scale (-80 dB): what never gets louder is silent
constexpr int smoothing_radius = 3;                        // moments before and after, for the median of a pitch
constexpr std::size_t held = 5;                            // moments that a pitch must last to count
constexpr std::size_t max_samples = std::size_t{1} << 28;  // silence packs into next to nothing
constexpr Real near = 1;                                   // semitones within which a pitch is the same

/// libsndfile's view of bytes in memory.
struct Memory {
  const std::string& bytes;
  sf_count_t at = 0;

  static Memory& of(void* self) { return *static_cast<Memory*>(self); }
  static sf_count_t length(void* self) { return static_cast<sf_count_t>(of(self).bytes.size()); }
  static sf_count_t seek(sf_count_t offset, int whence, void* self) {
    Memory& m = of(self);
    const sf_count_t base = whence == SEEK_CUR ? m.at : whence == SEEK_END ? length(self) : 0;
    m.at = std::clamp<sf_count_t>(base + offset, 0, length(self));
    return m.at;
  }
  static sf_count_t read(void* target, sf_count_t count, void* self) {
    Memory& m = of(self);
    const sf_count_t given = std::clamp<sf_count_t>(length(self) - m.at, 0, count);
    std::memcpy(target, m.bytes.data() + m.at, static_cast<std::size_t>(given));
    m.at += given;
    return given;
  }
  static sf_count_t write(const void*, sf_count_t, void*) { return 0; }
  static sf_count_t tell(void* self) { return of(self).at; }
};

// Bytes 4 to 7 of a WAV file contain the number of bytes that follow; 0 or about 2 or 4 GB if its recorder could not
// return to them, as when writing into a pipe. The last byte may be padding to an even number.
void check_whole(const std::string& name, const std::string& bytes) {
  constexpr std::size_t head = 8;
  if (bytes.size() < head + 4 || !bytes.starts_with("RIFF") || bytes.compare(head, 4, "WAVE") != 0) return;
  std::size_t told = 0;
  for (std::size_t k = 4; k-- > 0;) told = 256 * told + static_cast<unsigned char>(bytes[4 + k]);
  constexpr std::size_t unknown = 0x7FFFF000;
  if (told == 0 || told >= unknown || told + head <= bytes.size() + 1) return;
  throw InputError(name + ": holds " + std::to_string(bytes.size()) + " bytes of the " + std::to_string(told + head) +
                   " that it says it has, so it is cut short; copy it again");
}

/// The mean of all channels, and the loudest channel alone.
struct Mixes {
  std::vector<float> mean, loudest;
  Real power_of_mean = 0, power_of_loudest = 0;
};

Mixes mixes_of(const std::string& name, SNDFILE* file, std::size_t channels, std::size_t one) {
  constexpr sf_count_t block = 4096;
  std::vector<float> frames(block * channels);
  Mixes mixes;
  for (sf_count_t count = 0; (count = sf_readf_float(file, frames.data(), block)) > 0;) {
    if (mixes.mean.size() > max_samples) {
      throw InputError(name +
                       ": more than 2^28 samples, which is an hour and a half at 48 kHz; cut it, or use a lower rate");
    }
    for (std::size_t i = 0; i < static_cast<std::size_t>(count); ++i) {
      const float* const frame = &frames[i * channels];
      mixes.mean.push_back(std::accumulate(frame, frame + channels, 0.0F) / static_cast<float>(channels));
      mixes.loudest.push_back(frame[one]);
      mixes.power_of_mean += static_cast<Real>(mixes.mean.back()) * mixes.mean.back();
      mixes.power_of_loudest += static_cast<Real>(frame[one]) * frame[one];
    }
  }
  return mixes;
}

// Channels in opposite phase cancel in their mean. If that leaves less than a hundredth of the power of one of them, a
// listener hears that one.
Recording heard_of(const std::string& name, SNDFILE* file, const SF_INFO& info) {
  constexpr Real cancelled = 0.01;
  const auto channels = static_cast<std::size_t>(info.channels);
  Mixes mixes = mixes_of(name, file, channels, 0);
  for (std::size_t one = 1; one < channels && mixes.power_of_mean < cancelled * mixes.power_of_loudest; ++one) {
    sf_seek(file, 0, SEEK_SET);
    Mixes other = mixes_of(name, file, channels, one);
    if (other.power_of_loudest > mixes.power_of_loudest) mixes = std::move(other);
  }
  const bool is_cancelled = mixes.power_of_mean < cancelled * mixes.power_of_loudest;
  return {static_cast<Real>(info.samplerate), std::move(is_cancelled ? mixes.loudest : mixes.mean)};
}

Recording decode(const std::string& name, const std::string& bytes) {
  if (bytes.empty()) throw InputError(name + ": byte 0: the sound file is empty; record or export it again");
  check_whole(name, bytes);
  Memory memory{bytes};
  SF_VIRTUAL_IO calls = {&Memory::length, &Memory::seek, &Memory::read, &Memory::write, &Memory::tell};
  SF_INFO info = {};
  const std::unique_ptr<SNDFILE, int (*)(SNDFILE*)> file(sf_open_virtual(&calls, SFM_READ, &info, &memory), &sf_close);
  if (!file) {
    throw InputError(name + ": libsndfile cannot read it (" + sf_strerror(nullptr) +
                     "); convert it to WAV or FLAC, or copy it again");
  }
  if (info.samplerate < 1000 || info.samplerate > 1000000 || info.channels < 1) {
    throw InputError(name + ": a rate of " + std::to_string(info.samplerate) +
                     " Hz is not from 1 kHz to 1 MHz; convert the file to 44.1 kHz");
  }
  return heard_of(name, file.get(), info);
}

/// Moment k is the window around k hops, with silence before the start and after the end.
std::vector<Heard> listen(const Recording& sound, Follow follow) {
  const Ear ear(sound.rate);
  const std::size_t window = ear.window();
  std::vector<float> padded(window / 2, 0.0F);
  padded.insert(padded.end(), sound.samples.begin(), sound.samples.end());
  padded.resize(padded.size() + window, 0.0F);
  std::vector<Heard> moments;
  const Real length = static_cast<Real>(sound.samples.size()) / sound.rate;
  for (std::size_t k = 0; static_cast<Real>(k) * hop < length; ++k) {
    const auto first = static_cast<std::size_t>(std::lround(static_cast<Real>(k) * hop * sound.rate));
    const auto samples = std::span<const float>(padded).subspan(first, window);
    moments.push_back({ear.loudness(samples), follow == Follow::pitch ? ear.pitch(samples) : NAN});
  }
  return moments;
}

Real peak_of(const std::string& name, const std::vector<Heard>& moments) {
  Real peak = 0;
  for (const Heard& moment : moments) {
    if (!std::isfinite(moment.rms)) throw InputError(name + ": holds samples that are no numbers; export it again");
    peak = std::max(peak, moment.rms);
  }
  if (peak < min_peak) {
    throw InputError(name + ": the sound file is silent in all its " +
                     std::to_string(static_cast<Real>(moments.size()) * hop).substr(0, 6) +
                     " s (below -80 dB of full scale); record it louder");
  }
  return peak;
}

Tone tone_at(std::size_t moment, Real height) {
  // Where one ends the next begins, to the last bit.
  const auto k = static_cast<Real>(moment);
  return {std::max(0.0, (k - 0.5) * hop), (k + 0.5) * hop, height};
}

Melody by_loudness(const std::vector<Heard>& moments, Real peak) {
  Melody melody;
  melody.follow = Follow::loudness;
  for (std::size_t k = 0; k < moments.size(); ++k) {
    const Real before = moments[k > 0 ? k - 1 : k].rms, after = moments[std::min(k + 1, moments.size() - 1)].rms;
    const Real level = (before + 2 * moments[k].rms + after) / (4 * peak);
    if (level >= silence) melody.tones.push_back(tone_at(k, level));
  }
  return melody;
}

/// The median over the nearby moments that have a pitch; an octave error in one of them does not change it.
Real steady_pitch(const std::vector<Heard>& moments, std::size_t k) {
  if (std::isnan(moments[k].pitch)) return NAN;
  std::vector<Real> nearby;
  const std::size_t first = k < smoothing_radius ? 0 : k - smoothing_radius;
  for (std::size_t j = first; j < std::min(k + smoothing_radius + 1, moments.size()); ++j) {
    if (!std::isnan(moments[j].pitch)) nearby.push_back(moments[j].pitch);
  }
  const auto middle = nearby.begin() + static_cast<std::ptrdiff_t>(nearby.size() / 2);
  std::nth_element(nearby.begin(), middle, nearby.end());
  return *middle;
}

Melody by_pitch(const std::string& name, std::vector<Heard> moments, Real peak) {
  for (Heard& moment : moments) {
    if (moment.rms < silence * peak) moment.pitch = NAN;
  }
  std::vector<Real> pitch(moments.size());
  for (std::size_t k = 0; k < moments.size(); ++k) pitch[k] = steady_pitch(moments, k);
  std::vector<Tone> tones;
  for (std::size_t k = 0, next = 0; k < pitch.size(); k = next) {
    next = k + 1;
    if (std::isnan(pitch[k])) continue;
    while (next < pitch.size() && std::abs(pitch[next] - pitch[next - 1]) < near) ++next;
    if (next - k < held) continue;
    for (std::size_t j = k; j < next; ++j) tones.push_back(tone_at(j, pitch[j]));
  }
  if (tones.empty()) {
    throw InputError(name +
                     ": no voice with a pitch is heard in it (one at a time, 60 to 1500 Hz, 50 ms or more); use " +
                     "follow = \"loudness\"");
  }
  return melody_of_notes(std::move(tones));
}

}  // namespace

Recording read_recording(const std::string& name, const std::string& bytes) { return decode(name, bytes); }

Melody read_sound(const std::string& name, const std::string& bytes, Follow follow) {
  std::vector<Heard> moments = listen(decode(name, bytes), follow);
  const Real peak = peak_of(name, moments);
  return follow == Follow::loudness ? by_loudness(moments, peak) : by_pitch(name, std::move(moments), peak);
}

}  // namespace trevi
