// Raw PCM from a descriptor of rank 0, without ever waiting for it.
#include <poll.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cmath>

#include "music/sound.hpp"
#include "trevi/error.hpp"

namespace trevi {

namespace {

/// The most that is read in one step, so that a source without end (/dev/zero) does not hold up the solver.
constexpr std::size_t max_bytes = 1 << 20;
constexpr Real voice_low = 48, voice_high = 84;  // C3 and C6

}  // namespace

LiveSound::LiveSound(MPI_Comm comm, int descriptor, Real rate)
    : comm_(comm), descriptor_(descriptor), rate_(rate), ear_(rate), samples_(ear_.window(), 0.0F) {
  int usable = 1;
  if (rank_of(comm_) == 0) {
    struct stat status = {};
    usable = fstat(descriptor_, &status) == 0 && isatty(descriptor_) == 0 && !S_ISDIR(status.st_mode) ? 1 : 0;
    plain_file_ = S_ISREG(status.st_mode);
  }
  MPI_Bcast(&usable, 1, MPI_INT, 0, comm_);
  if (usable == 0) {
    throw InputError(
        "[[fountain]] music = \"-\": standard input is a terminal, a folder or closed; pipe raw PCM into it, for "
        "example "
        "arecord -t raw -f S16_LE -c 1 -r 44100 | trevi SCENE.toml");
  }
}

void LiveSound::listen(const StepInfo& step) {
  if (step.step == step_) return;
  step_ = step.step;
  const ScopedEvent timed(event_);
  if (rank_of(comm_) == 0) hear(step.time);
  std::array<Real, 2> heard = {level_, pitch_};
  MPI_Bcast(heard.data(), 2, MPI_DOUBLE, 0, comm_);
  level_ = heard[0];
  pitch_ = heard[1];
}

void LiveSound::hear(Real time) {
  const bool fresh = plain_file_ ? read_file(time) : read_pipe();
  if (!fresh) return;
  const std::size_t count = std::min(bytes_.size() / 2, samples_.size());
  std::fill(samples_.begin(), samples_.end(), 0.0F);
  // The buffer begins with a whole sample, so its latest whole samples end at an even number of bytes.
  const unsigned char* from = bytes_.data() + 2 * (bytes_.size() / 2 - count);
  for (std::size_t i = 0; i < count; ++i) {
    const auto value = static_cast<std::int16_t>(from[2 * i] | from[2 * i + 1] << 8);
    samples_[samples_.size() - count + i] = static_cast<float>(value) / 32768.0F;
  }
  const Real rms = ear_.loudness(samples_);
  loudest_ = std::max(loudest_, rms);
  level_ = rms / loudest_;
  pitch_ = level_ >= silence ? ear_.pitch(samples_) : NAN;
}

// Returns whether there is something new: bytes, or the end.
bool LiveSound::read_pipe() {
  if (ended_) return false;
  std::size_t total = 0;
  std::array<unsigned char, 65536> block;
  pollfd waiting = {descriptor_, POLLIN, 0};
  // After poll() a read returns what there is; the descriptor, shared with other programs, is left as it is.
  while (total < max_bytes && poll(&waiting, 1, 0) > 0) {
    const ssize_t count = read(descriptor_, block.data(), block.size());
    if (count < 0 && (errno == EINTR || errno == EAGAIN)) break;
    if (count <= 0) {
      ended_ = true;
      bytes_.clear();
      return true;
    }
    total += static_cast<std::size_t>(count);
    bytes_.insert(bytes_.end(), block.begin(), block.begin() + count);
    const std::size_t keep = 2 * samples_.size() + bytes_.size() % 2;
    if (bytes_.size() > keep) bytes_.erase(bytes_.begin(), bytes_.end() - static_cast<std::ptrdiff_t>(keep));
  }
  return total > 0;
}

bool LiveSound::read_file(Real time) {
  const auto last = static_cast<off_t>(std::llround(time * rate_)), count = static_cast<off_t>(samples_.size());
  const off_t first = std::max<off_t>(0, last - count);
  bytes_.resize(static_cast<std::size_t>(2 * (last - first)));
  const ssize_t got = pread(descriptor_, bytes_.data(), bytes_.size(), 2 * first);
  bytes_.resize(got > 0 ? static_cast<std::size_t>(got) : 0);
  return true;
}

std::optional<FountainState> LivePump::at(Real) const {
  if (follow_ == Follow::loudness) {
    if (sound_->level() < silence) return std::nullopt;
    return FountainState{NAN, scale_.speed(sound_->level())};
  }
  const Real pitch = sound_->pitch();
  if (std::isnan(pitch)) return std::nullopt;
  return FountainState{pitch, scale_.speed((pitch - voice_low) / (voice_high - voice_low))};
}

// What was heard before the step holds throughout it.
std::optional<Real> LivePump::fastest(const TimeSpan& times) const {
  const std::optional<FountainState> now = at(times.begin);
  return now ? std::optional(now->speed) : std::nullopt;
}

}  // namespace trevi
