// A run's end of the line to its viewer, on rank 0. The run calls, again and again if need be, so a viewer may come,
// go and come back at any time; the run opens no port itself.
// Invariant: nothing here waits for the viewer but wait(), no longer than it is told, and greet(), once; and no failure
// of the line reaches the run: it counts as a viewer that is gone, which wishes nothing. Rank-local.
//
// Transport: ZeroMQ (a thread of its own sends and receives). A build without live viewing has live_absent.cpp in place
// of this module: connecting throws InputError.
#pragma once

#include <memory>
#include <string>
#include <utility>

#include "live/viewer_messages.hpp"

namespace trevi {

class ViewerLink {
 public:
  virtual ~ViewerLink() = default;

  /// Takes in what has arrived; when nothing has, waits for up to so many milliseconds.
  virtual void wait(int milliseconds) = 0;
  /// Before the first step: half a second for a viewer to answer the call, and five for one that has answered to say
  /// what it wishes, so that a run may begin paused.
  virtual void greet() = 0;
  /// All false and 0 while there is no viewer.
  const ViewerWishes& wishes() const { return wishes_; }
  /// Whether the viewer has said what it wishes.
  bool has_viewer() const { return has_viewer_; }
  /// A viewer found or lost since the last call.
  bool changed() { return std::exchange(changed_, false); }

  /// Calls; what a viewer is told when it is found. InputError where the folder's key (viewer_key.hpp) is no good.
  virtual void introduce(const ViewedScene& scene) = 0;
  /// Why nobody has ever answered, for the user; empty when somebody has.
  virtual std::string trouble() const { return {}; }
  virtual void send(const ViewedFrame& frame) = 0;
  /// The last word; it may still be on its way for a second after the link is gone.
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

/// `address` as --view gives it. InputError where viewing is not built in, or for an address that is none.
std::unique_ptr<ViewerLink> connect_viewer(const std::string& address);

}  // namespace trevi
