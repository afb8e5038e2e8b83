#include "view/music_player.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <filesystem>

#include "io/run_directory/files.hpp"

namespace trevi {

namespace {

constexpr double max_drift = 0.25;  // s between picture and sound before the sound is restarted
constexpr double min_rest = 1.0;    // s between two restarts, or it would stutter
constexpr double real_time[] = {0.9, 1.1};

// Each takes a file and ends by itself; quiet, without a window.
std::vector<std::string> find_player() {
  const auto program = find_program({"pw-play", "paplay", "aplay", "ffplay"});
  if (!program) return {};
  if (program->ends_with("aplay") && !program->ends_with("paplay")) return {*program, "-q"};
  if (program->ends_with("ffplay")) return {*program, "-nodisp", "-autoexit", "-loglevel", "quiet"};
  return {*program};
}

template <class T>
void append(std::string& bytes, T value) {
  bytes.append(reinterpret_cast<const char*>(&value), sizeof value);
}

/// A WAV file: one channel, 16 bits.
std::string wave_file(const Pcm& music, std::size_t first) {
  const auto size = static_cast<std::uint32_t>(2 * (music.samples.size() - first));
  std::string bytes = "RIFF";
  append(bytes, size + 36);
  bytes += "WAVEfmt ";
  append(bytes, std::uint32_t{16});
  append(bytes, std::uint16_t{1});  // PCM
  append(bytes, std::uint16_t{1});
  append(bytes, std::uint32_t{pcm_rate});
  append(bytes, std::uint32_t{2 * pcm_rate});
  append(bytes, std::uint16_t{2});
  append(bytes, std::uint16_t{16});
  bytes += "data";
  append(bytes, size);
  for (std::size_t k = first; k < music.samples.size(); ++k)
    append(bytes, static_cast<std::int16_t>(std::lround(32767 * std::clamp(music.samples[k], -1.0F, 1.0F))));
  return bytes;
}

}  // namespace

MusicPlayer::MusicPlayer(Pcm music) : music_(std::move(music)) {
  if (music_.samples.empty()) return;
  player_ = find_player();
  if (player_.empty()) give_up("none of pw-play, paplay, aplay, ffplay is installed");
  file_ = (std::filesystem::temp_directory_path() / fmt::format("trevi_view_{}.wav", getpid())).string();
}

MusicPlayer::~MusicPlayer() {
  stop();
  if (!file_.empty()) std::remove(file_.c_str());
}

void MusicPlayer::give_up(const std::string& why) {
  std::fprintf(stderr, "trevi-view: no music: %s\n", why.c_str());
  player_.clear();
}

void MusicPlayer::follow(double time, double rate) {
  if (player_.empty()) return;
  const auto now = Clock::now();
  if (child_ && child_->exit_code()) {
    if (*child_->exit_code() != 0) return give_up(player_[0] + " found no sound device");
    child_.reset();
  }
  const bool wanted = rate > real_time[0] && rate < real_time[1];
  const double length = static_cast<double>(music_.samples.size()) / pcm_rate;
  if (!wanted || time >= length) return stop();
  if (child_ && std::abs(heard_at(now) - time) < max_drift) return;
  stop();
  if (now >= not_before_) start(time);
}

double MusicPlayer::heard_at(Clock::time_point now) const {
  return from_ + std::chrono::duration<double>(now - started_).count();
}

void MusicPlayer::start(double time) {
  const auto first = static_cast<std::size_t>(std::max(0.0, time) * pcm_rate);
  if (first >= music_.samples.size()) return;
  try {
    replace_file(file_, wave_file(music_, first));
    std::vector<std::string> words = player_;
    words.push_back(file_);
    child_.emplace(words, ChildOptions{.quiet = true});
  } catch (const std::exception& error) {
    return give_up(error.what());
  }
  from_ = time;
  started_ = Clock::now();
  not_before_ = started_ + std::chrono::milliseconds(static_cast<int>(1000 * min_rest));
}

void MusicPlayer::stop() {
  if (child_) child_->terminate();
  child_.reset();
}

}  // namespace trevi
