// What the world outside asks of a run under way: a checkpoint (SIGUSR1), or an end with one (SIGUSR2, SIGTERM, SIGINT,
// a stop file, the wall-clock limit, a viewer). A rank sees only some of this, and two ranks see a signal in different
// steps; so each rank counts, and the largest counts over all ranks, which the solver finds with its vote of each step,
// decide. Nothing here communicates. Signal handlers belong to the process: one watch at a time; the old handlers come
// back with its end.
#pragma once

#include <array>
#include <csignal>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "trevi/session.hpp"

namespace trevi {

/// By kind, in the order of Request: how often asked for since the program started.
enum class Request : std::size_t { checkpoint, stop_signal, terminate_signal, stop_file, wall_limit, viewer };
using RequestCounts = std::array<std::int64_t, 6>;

inline std::int64_t count_of(const RequestCounts& counts, Request kind) {
  return counts[static_cast<std::size_t>(kind)];
}

/// Why a run is to stop, for the user: "SIGUSR2", "the stop file", ...; nothing when it is not.
std::optional<std::string> stop_reason(const RequestCounts& agreed);

struct RequestOptions {
  std::string stop_file;             ///< the appearance of this file (no folder) asks for a stop
  std::optional<double> wall_limit;  ///< s since the watch began
};

class RequestWatch {
 public:
  RequestWatch(MPI_Comm comm, RequestOptions options);
  ~RequestWatch();
  RequestWatch(const RequestWatch&) = delete;
  RequestWatch& operator=(const RequestWatch&) = delete;

  /// Requests this rank knows of, but for a viewer's. Rank 0 alone looks at the clock and, once a second, for the file.
  /// To be called once a (sub)step: the limit is taken to be reached when the next one would pass it.
  RequestCounts poll();

  /// The stop file has done its work: gone, so that it does not stop the restart, too. Rank 0.
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
