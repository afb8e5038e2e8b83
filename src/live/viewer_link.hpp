// A run's end of the connection to its viewer, on rank 0. The run calls, repeatedly if necessary, so a viewer may come,
// go and come back at any time; the run opens no port itself. Invariant: nothing here waits for the viewer except
// wait(), for no longer than it is told, and greet(), once. No failure of the connection reaches the run: it counts as
// an absent viewer, which requests nothing. Rank-local.
//
// Transport: ZeroMQ (which sends and receives in a thread of its own). A build without live viewing has live_absent.cpp
// instead of this module: connecting throws InputError.
#pragma once

#include <memory>
#include <string>
#include <utility>

#include "live/viewer_messages.hpp"

namespace trevi {

class ViewerLink {
 public:
  virtual ~ViewerLink() = default;

  /// Takes in what has arrived; if nothing has, waits for up to this many milliseconds.
  virtual void wait(int milliseconds) = 0;
  /// Before the first step: waits half a second for a viewer to answer the call, and five seconds for one that has
  /// answered to send its requests, so that a run may begin paused.
  virtual void greet() = 0;
  /// All false and 0 while there is no viewer.
  const ViewerWishes& wishes() const { return wishes_; }
  /// Whether the viewer has sent its requests.
  bool has_viewer() const { return has_viewer_; }
  /// Whether a viewer was found or lost since the last call.
  bool changed() { return std::exchange(changed_, false); }

  /// Calls the viewer; `scene` is what it is told when it is found. InputError if the folder's key (viewer_key.hpp) is
  /// not valid.
  virtual void introduce(const ViewedScene& scene) = 0;
  /// Why nobody has ever answered, for the user; empty if somebody has.
  virtual std::string trouble() const { return {}; }
  virtual void send(const ViewedFrame& frame) = 0;
  /// The last message; it may still be on its way for a second after the link is gone.
  virtual void end(const std::string& reason) = 0;

 protected:
  void accept(const ViewerWishes& wishes) {
    changed_ = changed_ || !has_viewer_;
    has_viewer_ = true;
    wishes_ = wishes;
  }
  void forget() {
    changed_ = changed_ || has_viewer_;
    has_viewer_ = false;
    wishes_ = {};
  }

 private:
  ViewerWishes wishes_;
  bool has_viewer_ = false, changed_ = false;
};

/// `address` as given to --view. InputError if viewing is not built in, or for an invalid address.
std::unique_ptr<ViewerLink> connect_viewer(const std::string& address);

}  // namespace trevi
