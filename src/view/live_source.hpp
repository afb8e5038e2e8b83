// A run that is watched while it computes: waits for the run's call (live/viewer_link.hpp), shows its frames, steers
// it by what it wishes. A run that ends, fails or is killed leaves its last picture and a message. Without ZeroMQ in
// the build (live_source_absent.cpp) both functions throw InputError.
#pragma once

#include <optional>

#include "view/child.hpp"
#include "view/frame_source.hpp"

namespace trevi {

struct LiveOptions {
  std::int64_t budget = 0;  ///< particles of a picture, about
  bool paused = false;
};

/// mpirun -np `ranks` trevi `scene` `arguments`, with the trevi that lies beside this program.
struct RunToStart {
  std::string scene;
  int ranks = 1;
  std::vector<std::string> arguments;
};

class LiveSource : public FrameSource {
 public:
  /// Exit code of the run we started, once it has ended.
  virtual std::optional<int> exit_code() = 0;
};

std::unique_ptr<LiveSource> start_run(const RunToStart& run, const LiveOptions& options);
/// `address` as --listen gives it, for the run whose folder this is (or will be). InputError when the address is none,
/// or taken.
std::unique_ptr<LiveSource> listen_for_run(const std::string& address, const std::string& directory,
                                           const LiveOptions& options);

}  // namespace trevi
