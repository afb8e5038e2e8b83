// Requests to a run from outside: to write a checkpoint (SIGUSR1), or to write one and stop (SIGUSR2, SIGTERM, SIGINT,
// SIGHUP unless it is ignored as under nohup, a stop file, the wall-clock limit, a viewer). A rank sees only some of
// them, and two ranks may see a signal in different steps. Each rank therefore counts requests, and the largest counts
// over all ranks decide; the solver finds these in the consensus of each substep. Nothing here communicates. Signal
// handlers belong to the process, so only one watch may exist at a time; its destructor restores the previous handlers.
#pragma once

#include <array>
#include <csignal>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "trevi/session.hpp"

namespace trevi {

/// The kinds of requests. RequestCounts holds the number of each since the program started, in this order.
enum class Request : std::size_t { checkpoint, stop_signal, terminate_signal, stop_file, wall_limit, viewer };
using RequestCounts = std::array<std::int64_t, 6>;

inline std::int64_t count_of(const RequestCounts& counts, Request kind) {
  return counts[static_cast<std::size_t>(kind)];
}

/// The reason why a run is to stop, for the user: "SIGUSR2", "the stop file", ...; no value if it is not to stop.
std::optional<std::string> stop_reason(const RequestCounts& agreed);

struct RequestOptions {
  std::string stop_file;             ///< the appearance of this file (not a folder) requests a stop
  std::optional<double> wall_limit;  ///< s since the watch began
};

class RequestWatch {
 public:
  RequestWatch(MPI_Comm comm, RequestOptions options);
  ~RequestWatch();
  RequestWatch(const RequestWatch&) = delete;
  RequestWatch& operator=(const RequestWatch&) = delete;

  /// Requests that this rank knows of, except those of a viewer. Only rank 0 checks the clock and, once a second, the
  /// file. To be called once per substep: the limit counts as reached when the next substep would exceed it.
  RequestCounts poll();

  /// Removes the stop file once it has stopped the run, so that it does not stop the restart as well. On rank 0.
  void remove_stop_file() const;

 private:
  bool out_of_time(double now);
  bool file_found(double now);

  RequestOptions options_;
  bool watches_;  ///< rank 0: clock and file
  double began_, last_poll_, last_look_;
  bool stop_file_found_ = false, out_of_time_ = false;
  std::vector<struct sigaction> old_;
};

}  // namespace trevi
