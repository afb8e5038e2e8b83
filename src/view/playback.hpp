// Plays a directory by its frames' times: at speed 1 a simulated second takes a second, and frames that come too fast
// for the screen are skipped. A directory that grows is followed.
#pragma once

#include "view/frame_cache.hpp"
#include "view/frame_list.hpp"
#include "view/frame_reader.hpp"
#include "view/frame_source.hpp"
#include "view/run_folder.hpp"

namespace trevi {

struct PlaybackOptions {
  double speed = 1;
  bool loop = false, paused = false;
  std::int64_t budget = 0;  ///< approximate number of particles in a picture
  bool all = false;         ///< draw those that cannot be seen, too
};

class Playback : public FrameSource {
 public:
  /// InputError if the first frame cannot be read.
  Playback(FrameList list, const ViewedScene& scene, const PlaybackOptions& options);

  bool advance(double seconds) override;
  std::shared_ptr<const ViewedFrame> frame() const override { return frame_; }
  const ViewedScene& scene() const override { return scene_; }
  bool paused() const override { return paused_; }
  void pause(bool paused) override;
  void step(int frames) override;
  void jump(bool to_end) override;
  void change_speed(double factor) override;
  void switch_loop() override { loop_ = !loop_; }
  bool at_end() const override { return index_ + 1 == count() && !loop_; }
  std::string pace() const override;
  std::string message() const override { return message_; }
  double rate() const override { return paused_ || at_end() ? 0 : speed_; }

  std::size_t count() const { return list_.entries().size(); }
  /// Shows a frame at once; InputError if it cannot be read.
  void show(std::size_t index);

 private:
  void choose_by_time();
  bool take(std::size_t index, const FrameCache::Entry& entry);

  FrameList list_;
  ViewedScene scene_;
  FountainSeries fountains_;
  double speed_;
  bool loop_, paused_;
  std::size_t index_ = 0;  ///< of the frame that is to be shown
  std::size_t shown_ = 0;  ///< of the frame that is shown
  double time_ = 0;        ///< current time of playing, s
  double since_look_ = 0;  ///< s since the list was read
  std::shared_ptr<const ViewedFrame> frame_;
  std::string message_;
  std::mutex list_mutex_;  ///< the thread of the cache looks up paths
  FrameCache cache_;       ///< last: its thread must end first
};

}  // namespace trevi
