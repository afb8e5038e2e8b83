// Plays the music of a scene in step with the picture, through whatever plays sound files on this machine (a child
// process); on a machine without sound this is reported once, and it stays silent. Plays only while a simulated second
// takes about a second. Scores and MIDI files are played as plain tones, sound files as they are. Rank-local.
#pragma once

#include <chrono>
#include <optional>
#include <string>
#include <vector>

#include "trevi/scene.hpp"
#include "view/child.hpp"

namespace trevi {

/// Samples of one channel.
struct Pcm {
  std::vector<float> samples;  ///< -1 to 1
};
inline constexpr int pcm_rate = 22050;  ///< Hz

/// The music of all fountains together; empty if there is none. InputError for a file that cannot be used.
Pcm music_of(const Scene& scene);

class MusicPlayer {
 public:
  MusicPlayer() = default;  ///< silent
  /// Reports on stderr if there is music but nothing to play it.
  explicit MusicPlayer(Pcm music);
  ~MusicPlayer();
  MusicPlayer(const MusicPlayer&) = delete;
  MusicPlayer& operator=(const MusicPlayer&) = delete;

  /// To be called repeatedly with the picture's time (s) and its pace (simulated seconds per second).
  void follow(double time, double rate);

 private:
  using Clock = std::chrono::steady_clock;
  double heard_at(Clock::time_point now) const;
  void start(double time);
  void stop();
  void give_up(const std::string& why);

  Pcm music_;
  std::vector<std::string> player_;  ///< words of the program that plays a file; empty: silent
  std::string file_;
  std::optional<Child> child_;
  double from_ = 0;  ///< time of the picture at the start of what is being played
  Clock::time_point started_, not_before_;
};

}  // namespace trevi
