// A run that is watched while it computes: waits for the run's call (live/viewer_link.hpp), shows its frames, and
// steers it by requests. A run that ends, fails or is killed leaves its last picture and a message. Without ZeroMQ in
// the build (live_source_absent.cpp) both functions throw InputError.
#pragma once

#include <optional>

#include "view/child.hpp"
#include "view/frame_source.hpp"

namespace trevi {

struct LiveOptions {
  std::int64_t budget = 0;  ///< approximate number of particles in a picture
  bool paused = false;
};

/// mpirun -np `ranks` trevi `scene` `arguments`, with the trevi beside this program.
struct RunToStart {
  std::string scene;
  int ranks = 1;
  std::vector<std::string> arguments;
};

class LiveSource : public FrameSource {
 public:
  /// Exit code of the run that we started, once it has ended.
  virtual std::optional<int> exit_code() = 0;
};

std::unique_ptr<LiveSource> start_run(const RunToStart& run, const LiveOptions& options);
/// `address` as given to --listen, for the run whose folder this is (or will be). InputError if the address is invalid
/// or in use.
std::unique_ptr<LiveSource> listen_for_run(const std::string& address, const std::string& directory,
                                           const LiveOptions& options);

}  // namespace trevi
