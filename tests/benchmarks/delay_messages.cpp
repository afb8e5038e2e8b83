// Messages as if the way between two ranks took some time, and a rank that is slower than the others: to be preloaded.
//   LD_PRELOAD=.../libdelay_messages.so TREVI_DELAY_US=1000 mpirun -np 2 build/release/trevi SCENE
// Nothing that this rank waits for is complete until TREVI_DELAY_US microseconds after it sent its own part of the
// exchange, as ranks do so at about the same time. With TREVI_DELAY_AT_ONCE=1 the time passes where a message is sent,
// so that no work is behind it: as a program without overlap would have it. TREVI_SLOW_RANK lengthens each stretch of
// that rank's computing by TREVI_SLOW_PERCENT percent. At the end each rank tells how many exchanges had come when it
// first asked, all of their way behind work, and what part of the way of all of them was.
#include <mpi.h>

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <cstdlib>

namespace {

using Clock = std::chrono::steady_clock;
using Seconds = std::chrono::duration<double>;

double variable(const char* name, double otherwise) {
  const char* const text = std::getenv(name);
  return text != nullptr ? std::atof(text) : otherwise;
}

const Seconds& delay() {
  static const Seconds read(1e-6 * variable("TREVI_DELAY_US", 0));
  return read;
}

bool at_once() {
  static const bool read = variable("TREVI_DELAY_AT_ONCE", 0) > 0;
  return read;
}

// Polling, as a sleep would be longer and would leave the core to others.
void pass(Seconds time) {
  const Clock::time_point begin = Clock::now();
  while (Clock::now() - begin < time) continue;
}

// Exchanges, those of them that had come when they were asked for, and the time that was still to come of the others.
struct Count {
  long all = 0, hidden = 0;
  Seconds left{0};
  ~Count() {
    if (all == 0) return;
    const double way = static_cast<double>(all) * delay().count();
    std::fprintf(stderr, "messages: %ld exchanges, %ld of them behind work; %.1f %% of their way\n", all, hidden,
                 way > 0 ? 100 * (1 - left.count() / way) : 0);
  }
} count_of_exchanges;

Clock::time_point arrival;  // of what was sent last
bool asked = true;          // whether it has been asked for
Clock::time_point computing_since = Clock::now();

double slowness() {
  static const double part = [] {
    int rank = 0;
    PMPI_Comm_rank(MPI_COMM_WORLD, &rank);
    return rank == variable("TREVI_SLOW_RANK", -1) ? variable("TREVI_SLOW_PERCENT", 10) / 100 : 0;
  }();
  return part;
}

// To be called where a stretch of computing ends.
void end_computing() {
  if (slowness() > 0) pass(slowness() * (Clock::now() - computing_since));
  computing_since = Clock::now();
}

void note_sending() {
  end_computing();
  if (at_once() && asked) pass(delay());
  arrival = Clock::now() + std::chrono::duration_cast<Clock::duration>(at_once() ? Seconds(0) : delay());
  asked = false;
}

// The first question after an exchange was sent.
void note_question() {
  end_computing();
  const Seconds left = at_once() ? delay() : std::max(Seconds(arrival - Clock::now()), Seconds(0));
  ++count_of_exchanges.all;
  if (left.count() <= 0) ++count_of_exchanges.hidden;
  count_of_exchanges.left += left;
  asked = true;
}

}  // namespace

extern "C" {

int MPI_Isend(const void* data, int count, MPI_Datatype type, int to, int tag, MPI_Comm comm, MPI_Request* request) {
  note_sending();
  const int result = PMPI_Isend(data, count, type, to, tag, comm, request);
  computing_since = Clock::now();
  return result;
}

int MPI_Iallreduce(const void* from, void* to, int count, MPI_Datatype type, MPI_Op op, MPI_Comm comm,
                   MPI_Request* request) {
  note_sending();
  const int result = PMPI_Iallreduce(from, to, count, type, op, comm, request);
  computing_since = Clock::now();
  return result;
}

int MPI_Testall(int count, MPI_Request* requests, int* done, MPI_Status* statuses) {
  if (!asked) note_question();
  *done = 0;
  const bool has_come = Clock::now() >= arrival;
  const int result = has_come ? PMPI_Testall(count, requests, done, statuses) : MPI_SUCCESS;
  if (*done != 0) computing_since = Clock::now();
  return result;
}

}  // extern "C"
