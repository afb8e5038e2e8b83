// What is heard in a moment of sound: its loudness, and the pitch of a single voice. For sound files and live sound. A
// moment is a window of 40 ms, weighted by a Hann window for the loudness (RMS). Pitch by YIN (de Cheveigné and
// Kawahara, 2002), from 60 to 1500 Hz, on samples reduced to about 11 kHz; noise and chords have none. Live sound is
// raw PCM: 16 bits, little-endian, one channel. It is the one thing in a run that cannot be reproduced. Collective:
// making a LiveSound, and listen().
#pragma once

#include <memory>
#include <span>
#include <vector>

#include "music/music.hpp"

namespace trevi {

/// A moment quieter than this fraction of the loudest is silence (-26 dB).
inline constexpr Real silence = 0.05;

struct Heard {
  Real rms = 0;      ///< 1 is a square wave at full scale
  Real pitch = NAN;  ///< MIDI number with fraction, nan if there is none
};

/// A sound file as it is heard.
struct Recording {
  Real rate = 0;               ///< samples per second
  std::vector<float> samples;  ///< the mean of the channels, -1 to 1
};

/// InputError for bytes that are not a sound file, or if libsndfile is not built in.
Recording read_recording(const std::string& name, const std::string& bytes);

class Ear {
 public:
  explicit Ear(Real rate);  ///< samples per second
  std::size_t window() const { return weights_.size(); }
  /// Both take window() samples.
  Real loudness(std::span<const float> samples) const;
  Real pitch(std::span<const float> samples) const;

 private:
  Real rate_;
  std::vector<float> weights_;  ///< their sum is 1
};

/// The latest moment of a stream on rank 0, broadcast to all ranks. A pipe is emptied without ever waiting, what is
/// older than the latest window is dropped, and what was heard last holds until something new arrives; after the end
/// there is silence. A plain file is heard at the simulated time instead.
class LiveSound {
 public:
  /// InputError if the descriptor on rank 0 is a terminal or closed.
  LiveSound(MPI_Comm comm, int descriptor, Real rate);
  /// To be called once before each step; further calls for the same step do nothing.
  void listen(const StepInfo& step);
  /// 1 is the loudest so far (and no less than 5 % of full scale).
  Real level() const { return level_; }
  Real pitch() const { return pitch_; }

 private:
  void hear(Real time);
  bool read_pipe();
  bool read_file(Real time);

  Event event_{"Music"};
  MPI_Comm comm_;
  int descriptor_;
  Real rate_;
  Ear ear_;
  bool plain_file_ = false, ended_ = false;
  std::vector<unsigned char> bytes_;  ///< the latest window, and an odd byte at times
  std::vector<float> samples_;
  Real loudest_ = 0.05, level_ = 0, pitch_ = NAN;
  std::int64_t step_ = -1;
};

/// Follows live sound. A voice has no known range: the ends of speed_range are C3 and C6, and represent everything
/// beyond.
class LivePump : public Pump {
 public:
  LivePump(std::shared_ptr<LiveSound> sound, Follow follow, const SpeedScale& scale)
      : sound_(std::move(sound)), follow_(follow), scale_(scale) {}
  void prepare(const StepInfo& step) override { sound_->listen(step); }
  std::optional<FountainState> at(Real time) const override;
  std::optional<Real> fastest(const TimeSpan& times) const override;

 private:
  std::shared_ptr<LiveSound> sound_;
  Follow follow_;
  SpeedScale scale_;
};

}  // namespace trevi
