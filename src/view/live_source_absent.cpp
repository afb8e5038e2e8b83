// Replaces live_source.cpp if ZeroMQ is not built in.
#include "trevi/error.hpp"
#include "view/live_source.hpp"

namespace trevi {

namespace {

[[noreturn]] void refuse() {
  throw InputError(
      "this build cannot watch runs live; configure with -DTREVI_WITH_LIVE=ON (it needs libzmq3-dev, cppzmq-dev)");
}

}  // namespace

std::unique_ptr<LiveSource> start_run(const RunToStart&, const LiveOptions&) { refuse(); }
std::unique_ptr<LiveSource> listen_for_run(const std::string&, const std::string&, const LiveOptions&) { refuse(); }

}  // namespace trevi
