// Messages as if the way between two ranks took some time, and a rank that is slower than the others, to be preloaded:
// other orders of what ranks do, which no result may see. What both cost is told by hidden_waiting.py.
//   LD_PRELOAD=.../libdelay_messages.so TREVI_DELAY_US=1000 mpirun -np 2 build/release/trevi SCENE
// Nothing that this rank waits for is complete until TREVI_DELAY_US microseconds after it sent its own part of the
// exchange, as ranks do so at about the same time. TREVI_SLOW_RANK lengthens each stretch of that rank's computing by
// TREVI_SLOW_PERCENT percent.
#include <mpi.h>

#include <chrono>
#include <cstdlib>

namespace {

using Clock = std::chrono::steady_clock;
using Seconds = std::chrono::duration<double>;

double variable(const char* name, double otherwise) {
  const char* const text = std::getenv(name);
  return text != nullptr ? std::atof(text) : otherwise;
}

double slowness() {
  static const double part = [] {
    int rank = 0;
    PMPI_Comm_rank(MPI_COMM_WORLD, &rank);
    return rank == variable("TREVI_SLOW_RANK", -1) ? variable("TREVI_SLOW_PERCENT", 10) / 100 : 0;
  }();
  return part;
}

Clock::time_point arrival;  // of what was sent last
bool computing = true;
Clock::time_point computing_since = Clock::now();

// Polling, as a sleep would be longer and would leave the core to others.
void end_computing() {
  const Clock::time_point now = Clock::now();
  while (computing && Clock::now() - now < slowness() * (now - computing_since)) continue;
  computing = false;
}

void begin_computing() {
  computing = true;
  computing_since = Clock::now();
}

void note_sending() {
  static const Seconds delay(1e-6 * variable("TREVI_DELAY_US", 0));
  end_computing();
  arrival = Clock::now() + std::chrono::duration_cast<Clock::duration>(delay);
}

}  // namespace

extern "C" {

int MPI_Isend(const void* data, int count, MPI_Datatype type, int to, int tag, MPI_Comm comm, MPI_Request* request) {
  note_sending();
  const int result = PMPI_Isend(data, count, type, to, tag, comm, request);
  begin_computing();
  return result;
}

int MPI_Iallreduce(const void* from, void* to, int count, MPI_Datatype type, MPI_Op op, MPI_Comm comm,
                   MPI_Request* request) {
  note_sending();
  const int result = PMPI_Iallreduce(from, to, count, type, op, comm, request);
  begin_computing();
  return result;
}

int MPI_Testall(int count, MPI_Request* requests, int* done, MPI_Status* statuses) {
  end_computing();
  *done = 0;
  const bool has_come = Clock::now() >= arrival;
  const int result = has_come ? PMPI_Testall(count, requests, done, statuses) : MPI_SUCCESS;
  if (*done != 0) begin_computing();
  return result;
}

}  // extern "C"
