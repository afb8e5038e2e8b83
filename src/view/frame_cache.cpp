#include "view/frame_cache.hpp"

#include <algorithm>

namespace trevi {

namespace {

std::size_t bytes_of(const FrameCache::Entry& entry) {
  return entry.frame ? entry.frame->shown.size() * sizeof(ViewedParticle) : 0;
}

}  // namespace

FrameCache::FrameCache(Read read, std::size_t max_bytes)
    : read_(std::move(read)), max_bytes_(max_bytes), thread_([this] { work(); }) {}

FrameCache::~FrameCache() {
  {
    const std::lock_guard lock(mutex_);
    ending_ = true;
  }
  changed_.notify_all();
  thread_.join();
}

std::optional<FrameCache::Entry> FrameCache::get(std::size_t index, std::size_t count) {
  const std::lock_guard lock(mutex_);
  wanted_ = index;
  count_ = count;
  changed_.notify_all();
  const auto found = kept_.find(index);
  if (found == kept_.end()) return std::nullopt;
  found->second.used = ++uses_;
  return found->second.entry;
}

FrameCache::Entry FrameCache::wait_for(std::size_t index, std::size_t count) {
  if (const auto ready = get(index, count)) return *ready;
  std::unique_lock lock(mutex_);
  changed_.wait(lock, [&] { return kept_.contains(index); });
  return kept_[index].entry;
}

void FrameCache::work() {
  std::unique_lock lock(mutex_);
  while (!ending_) {
    const auto index = next_missing();
    if (!index) {
      changed_.wait(lock);
      continue;
    }
    lock.unlock();
    Entry entry;
    try {
      entry.frame = std::make_shared<const ViewedFrame>(read_(*index));
    } catch (const std::exception& error) {
      entry.error = error.what();
    }
    lock.lock();
    bytes_ += bytes_of(entry);
    kept_[*index] = {std::move(entry), ++uses_};
    make_room();
    changed_.notify_all();
  }
}

std::optional<std::size_t> FrameCache::next_missing() const {
  for (std::size_t index = wanted_; index < std::min(count_, wanted_ + ahead + 1); ++index) {
    if (!kept_.contains(index)) return index;
  }
  return std::nullopt;
}

void FrameCache::make_room() {
  while (bytes_ > max_bytes_ && kept_.size() > ahead + 2) {
    // Never one that is needed now or next: it would be read again at once.
    auto oldest = kept_.end();
    for (auto it = kept_.begin(); it != kept_.end(); ++it) {
      const bool needed = it->first >= wanted_ && it->first <= wanted_ + ahead;
      if (!needed && (oldest == kept_.end() || it->second.used < oldest->second.used)) oldest = it;
    }
    if (oldest == kept_.end()) return;
    bytes_ -= bytes_of(oldest->second.entry);
    kept_.erase(oldest);
  }
}

}  // namespace trevi
