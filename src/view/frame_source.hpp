// The source of pictures: a directory that is played, or a run that is watched. The window advances it with the wall
// clock and passes it the keys that steer. Rank-local; no call waits.
#pragma once

#include <memory>
#include <string>

#include "io/frames/viewed_frame.hpp"

namespace trevi {

class FrameSource {
 public:
  virtual ~FrameSource() = default;

  /// Advances; `seconds` since the last call. True if scene(), frame() or message() is new.
  virtual bool advance(double seconds) = 0;
  /// Null before the first frame.
  virtual std::shared_ptr<const ViewedFrame> frame() const = 0;
  virtual const ViewedScene& scene() const = 0;

  virtual bool paused() const = 0;
  virtual void pause(bool paused) = 0;
  /// One frame (in a live run: one step) forwards or back; pauses.
  virtual void step(int frames) = 0;
  virtual void jump(bool to_end) { (void)to_end; }
  virtual void change_speed(double factor) { (void)factor; }
  virtual void switch_loop() {}
  /// Key q: true if the window is to close, false if the source has something to do first (a run that is to stop).
  virtual bool leave() { return true; }
  virtual void want_density(bool wanted) { (void)wanted; }

  /// Whether nothing more will come.
  virtual bool at_end() const = 0;
  /// How the picture moves, for the status line: "playing x1, loop", "live", ...
  virtual std::string pace() const = 0;
  /// A sentence that the user should know; empty if there is nothing to report.
  virtual std::string message() const = 0;
  /// Simulated seconds that pass in a second of wall time, as far as the source knows; 0 when paused.
  virtual double rate() const = 0;
};

}  // namespace trevi
