#include "view/playback.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "trevi/error.hpp"

namespace trevi {

namespace {

constexpr double seconds_between_looks = 0.5;
constexpr std::size_t cache_bytes = std::size_t{512} << 20;

}  // namespace

Playback::Playback(FrameList list, const ViewedScene& scene, const PlaybackOptions& options)
    : list_(std::move(list)),
      scene_(scene),
      fountains_(list_.directory()),
      speed_(options.speed),
      loop_(options.loop),
      paused_(options.paused),
      cache_(
          [this, reader = FrameReader(scene, options.budget, options.all)](std::size_t index) {
            FrameEntry entry;
            {
              const std::lock_guard lock(list_mutex_);
              entry = list_.entries().at(index);
            }
            return reader.read(entry);
          },
          cache_bytes) {
  show(0);
}

void Playback::show(std::size_t index) {
  index_ = index;
  time_ = list_.entries().at(index).time;
  const FrameCache::Entry entry = cache_.wait_for(index, count());
  take(index, entry);
  if (!entry.frame) throw InputError(entry.error);
}

bool Playback::advance(double seconds) {
  since_look_ += seconds;
  if (since_look_ > seconds_between_looks) {
    since_look_ = 0;
    const std::lock_guard lock(list_mutex_);
    list_.refresh();
  }
  index_ = std::min(index_, count() - 1);
  if (!paused_) {
    time_ += seconds * speed_;
    choose_by_time();
  }
  if (frame_ && index_ == shown_) return false;
  const auto entry = cache_.get(index_, count());
  return entry && take(index_, *entry);
}

bool Playback::take(std::size_t index, const FrameCache::Entry& entry) {
  shown_ = index;
  message_ = entry.error;
  if (!entry.frame) return true;
  auto frame = std::make_shared<ViewedFrame>(*entry.frame);
  frame->fountains = fountains_.at(frame->step);
  frame_ = std::move(frame);
  return true;
}

void Playback::choose_by_time() {
  const auto& entries = list_.entries();
  const double last = entries.back().time;
  if (time_ > last) {
    // Before a loop starts again, the last frame is shown as long as the previous one.
    const double pause = entries.size() > 1 ? last - entries[entries.size() - 2].time : 0;
    if (loop_ && time_ > last + pause) time_ = entries.front().time;
    if (!loop_) time_ = last;
  }
  const auto after = std::upper_bound(entries.begin(), entries.end(), time_ + 1e-9,
                                      [](double time, const FrameEntry& entry) { return time < entry.time; });
  index_ = static_cast<std::size_t>(std::max<std::ptrdiff_t>(0, after - entries.begin() - 1));
}

void Playback::pause(bool paused) {
  // At the end, playing means playing again.
  if (!paused && index_ + 1 == count()) time_ = list_.entries().front().time;
  paused_ = paused;
}

void Playback::step(int frames) {
  paused_ = true;
  const auto to = static_cast<std::ptrdiff_t>(index_) + frames;
  index_ = static_cast<std::size_t>(std::clamp<std::ptrdiff_t>(to, 0, static_cast<std::ptrdiff_t>(count()) - 1));
  time_ = list_.entries()[index_].time;
}

void Playback::jump(bool to_end) {
  index_ = to_end ? count() - 1 : 0;
  time_ = list_.entries()[index_].time;
}

void Playback::change_speed(double factor) { speed_ = std::clamp(speed_ * factor, 1.0 / 64, 64.0); }

std::string Playback::pace() const {
  const char* state = paused_ ? "paused" : at_end() ? "at the end" : "playing";
  return fmt::format("{}  x{:g}{}  frame {}/{}", state, speed_, loop_ ? " loop" : "", shown_ + 1, count());
}

}  // namespace trevi
