// Messages as if the way between two ranks took some time: to be preloaded, with TREVI_DELAY_US in microseconds.
//   LD_PRELOAD=.../libdelay_messages.so TREVI_DELAY_US=1000 mpirun -np 2 build/release/trevi SCENE
// Nothing that this rank waits for is complete until so long after it sent its own part of the exchange, as ranks do so
// at about the same time. At the end each rank tells how many exchanges had come when it first asked: all of their way
// was behind work.
#include <mpi.h>

#include <chrono>
#include <cstdio>
#include <cstdlib>

namespace {

using Clock = std::chrono::steady_clock;

Clock::time_point arrival;  // of what was sent last
bool asked = true;          // whether it has been asked for

// Exchanges, and those of them that had come when they were asked for.
struct Count {
  long all = 0, hidden = 0;
  ~Count() {
    if (all > 0) std::fprintf(stderr, "messages: %ld exchanges, %ld of them behind work\n", all, hidden);
  }
} count_of_exchanges;

void note_sending() {
  static const auto delay = std::chrono::microseconds(
      std::getenv("TREVI_DELAY_US") == nullptr ? 0 : std::atoi(std::getenv("TREVI_DELAY_US")));
  arrival = Clock::now() + delay;
  asked = false;
}

}  // namespace

extern "C" {

int MPI_Isend(const void* data, int count, MPI_Datatype type, int to, int tag, MPI_Comm comm, MPI_Request* request) {
  note_sending();
  return PMPI_Isend(data, count, type, to, tag, comm, request);
}

int MPI_Iallreduce(const void* from, void* to, int count, MPI_Datatype type, MPI_Op op, MPI_Comm comm,
                   MPI_Request* request) {
  note_sending();
  return PMPI_Iallreduce(from, to, count, type, op, comm, request);
}

int MPI_Testall(int count, MPI_Request* requests, int* done, MPI_Status* statuses) {
  const bool has_come = Clock::now() >= arrival;
  if (!asked) {
    ++count_of_exchanges.all;
    if (has_come) ++count_of_exchanges.hidden;
    asked = true;
  }
  if (has_come) return PMPI_Testall(count, requests, done, statuses);
  *done = 0;
  return MPI_SUCCESS;
}

}  // extern "C"
