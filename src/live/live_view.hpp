// An observer that shows the run to a viewer and lets it steer: pause, single steps, stop. Frames are sent on credit:
// one is gathered and sent only after the viewer has received the last one, so the run never waits for a slow viewer,
// and only particles that can be seen are sent (io/frames/visible.hpp). A pause holds all ranks here, between two
// steps, asleep except for a check of the link every few milliseconds. It ends when the viewer asks for that, when the
// viewer is gone, or when the run is asked to stop by other means (a signal, the stop file, the wall limit). Invariant:
// the observer never changes the particles, and all ranks do the same, because rank 0 tells them every step what to do.
// Collective.
#pragma once

#include <functional>
#include <memory>

#include "io/frames/colour.hpp"
#include "live/viewer_link.hpp"
#include "trevi/observer.hpp"
#include "trevi/requests.hpp"
#include "trevi/session.hpp"

namespace trevi {

struct LiveViewOptions {
  std::shared_ptr<ViewerLink> link;         ///< rank 0 only
  std::function<RequestCounts()> requests;  ///< of this rank, from outside; may be empty
  ViewedScene scene;
  Real cell = 0.2;  ///< m, for visibility: the kernel radius
  ColourScale colour;
};

class LiveView : public Observer {
 public:
  LiveView(MPI_Comm comm, LiveViewOptions options);

  bool due(const Clock&) const override { return true; }
  bool wants_density() const override { return density_; }
  void observe(const Frame& frame) override;
  void finish(const Frame& frame) override;

 private:
  /// The orders of rank 0 to all ranks.
  struct Orders {
    std::int64_t hold = 0, frame = 0, density = 0, budget = 0;
  };
  Orders agree(std::int64_t step, bool held);
  Orders decide(std::int64_t step);
  Orders decide_when_held(std::int64_t step);
  bool to_be_held();
  void send(const Frame& frame, std::int64_t budget);
  std::vector<ViewedParticle> pick_visible(const Frame& frame, std::int64_t budget, int& level) const;

  MPI_Comm comm_;
  LiveViewOptions options_;
  bool density_ = false;           ///< whether the viewer asks for it
  bool over_ = false;              ///< the run makes no more steps
  std::int64_t sent_ = -1;         ///< rank 0: step of the last frame that this viewer received
  std::int64_t single_steps_ = 0;  ///< rank 0: number of single steps made for this viewer
};

std::unique_ptr<Observer> make_live_view(MPI_Comm comm, LiveViewOptions options);

}  // namespace trevi
