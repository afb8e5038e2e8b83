// Replaces the module of live viewing in a build without it.
#include "live/live_view.hpp"
#include "trevi/error.hpp"

namespace trevi {

namespace {

[[noreturn]] void refuse() {
  throw InputError(
      "--view: this build cannot be watched live; configure with -DTREVI_WITH_LIVE=ON (it needs libzmq3-dev, "
      "cppzmq-dev), or leave --view out");
}

}  // namespace

std::unique_ptr<ViewerLink> connect_viewer(const std::string&) { refuse(); }
std::unique_ptr<Observer> make_live_view(MPI_Comm, LiveViewOptions) { refuse(); }

}  // namespace trevi
