// Frames read ahead by a thread, so that playing never waits for a disk: the requested one first, then those that come
// next. Keeps the most recently used frames, within a limit of bytes; a loop over a short run is then played from
// memory.
#pragma once

#include <condition_variable>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>

#include "io/frames/viewed_frame.hpp"

namespace trevi {

class FrameCache {
 public:
  /// `read` is called only in the thread; what it throws becomes the frame's error.
  using Read = std::function<ViewedFrame(std::size_t)>;
  FrameCache(Read read, std::size_t max_bytes);
  ~FrameCache();
  FrameCache(const FrameCache&) = delete;
  FrameCache& operator=(const FrameCache&) = delete;

  struct Entry {
    std::shared_ptr<const ViewedFrame> frame;  ///< null if it could not be read
    std::string error;
  };
  /// The frame if it is available; in any case requests it, and the `ahead` frames after it, below `count`.
  std::optional<Entry> get(std::size_t index, std::size_t count);
  /// Like get(), but waits for it.
  Entry wait_for(std::size_t index, std::size_t count);

 private:
  static constexpr std::size_t ahead = 4;

  void work();
  std::optional<std::size_t> next_missing() const;
  void make_room();

  Read read_;
  std::size_t max_bytes_, bytes_ = 0;
  std::mutex mutex_;
  std::condition_variable changed_;
  struct Kept {
    Entry entry;
    std::uint64_t used = 0;
  };
  std::map<std::size_t, Kept> kept_;
  std::uint64_t uses_ = 0;
  std::size_t wanted_ = 0, count_ = 0;
  bool ending_ = false;
  std::thread thread_;
};

}  // namespace trevi
