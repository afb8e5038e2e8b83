// Stands in for viewer_link.cpp where ZeroMQ is not built in.
#include "live/viewer_link.hpp"
#include "trevi/error.hpp"

namespace trevi {

std::unique_ptr<ViewerLink> connect_viewer(const std::string&) {
  throw InputError(
      "--view: this build cannot be watched live; configure with -DTREVI_WITH_LIVE=ON (it needs libzmq3-dev, "
      "cppzmq-dev), or leave --view out");
}

}  // namespace trevi
