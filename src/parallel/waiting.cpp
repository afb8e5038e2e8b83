#include "parallel/waiting.hpp"

#include <sys/prctl.h>

#include <algorithm>
#include <chrono>
#include <thread>

#include "parallel/log.hpp"

namespace trevi {

void wait_all(std::span<MPI_Request> requests) {
  static LastingEvent event("Waiting");
  const Event& waiting = event();  // registered by all ranks alike, also by those without a message
  if (requests.empty()) return;
  const ScopedEvent timed(waiting);
  using Clock = std::chrono::steady_clock;
  constexpr std::chrono::nanoseconds patience = std::chrono::microseconds(50), longest = std::chrono::microseconds(100);
  // Otherwise Linux makes a sleep last 50 µs or more.
  [[maybe_unused]] static const int slack = prctl(PR_SET_TIMERSLACK, 1UL, 0UL, 0UL, 0UL);
  const Clock::time_point begin = Clock::now();
  for (;;) {
    int done = 0;
    MPI_Testall(static_cast<int>(requests.size()), requests.data(), &done, MPI_STATUSES_IGNORE);
    if (done != 0) return;
    const Clock::duration waited = Clock::now() - begin;
    if (waited > patience) std::this_thread::sleep_for(std::min<Clock::duration>(waited / 4, longest));
  }
}

void all_reduce(MPI_Comm comm, void* data, int count, MPI_Datatype type, MPI_Op op) {
  static LastingEvent event("Reductions");
  const ScopedEvent timed(event());
  MPI_Request request;
  MPI_Iallreduce(MPI_IN_PLACE, data, count, type, op, comm, &request);
  wait_all({&request, 1});
}

}  // namespace trevi
