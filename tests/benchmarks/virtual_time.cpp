// What ranks wait for one another where messages take some time, told without a machine that is quiet or has a core for
// each rank: to be preloaded. hidden_waiting.py makes a table of such runs.
//   LD_PRELOAD=.../libvirtual_time.so TREVI_DELAY_US=1000 mpirun -np 2 build/release/trevi SCENE --threads 1
// Each rank has a clock that moves by the processor time that its first thread computes, and each message brings the
// time at which it was sent. Who has asked for messages goes on at the latest of their times plus TREVI_DELAY_US, if
// that is later than his own; a reduction ends at the latest time of all ranks, plus the delay for each doubling of
// them. What MPI itself takes does not count, nor does copying into messages. TREVI_OVERLAP=0 has the delay pass where
// a message is sent, as a program without work behind messages would have it. TREVI_SLOW_RANK is slower than the others
// by TREVI_SLOW_PERCENT. At the end each rank tells its clock and its waits.
#define OMPI_SKIP_MPICXX
#define MPICH_SKIP_MPICXX
#include <mpi.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <map>
#include <memory>
#include <vector>

namespace {

constexpr int tag_of_times = 10000;  // is added to the tag of the message that a time goes with

double variable(const char* name, double otherwise) {
  const char* const text = std::getenv(name);
  return text != nullptr ? std::atof(text) : otherwise;
}

double processor_seconds() {
  timespec now{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

// A time on its way, kept until MPI no longer reads it.
struct Sent {
  double time = 0;
  MPI_Request request = MPI_REQUEST_NULL;
};

struct Received {
  std::unique_ptr<double> time = std::make_unique<double>(0);
  MPI_Request request = MPI_REQUEST_NULL;
};

class Clock {
 public:
  // Computing ends with a call of MPI, and begins again when that has done what it was called for.
  void stop() {
    if (!runs_) return;
    const double computed = processor_seconds() - since_;
    now_ += computed * slowness_;
    computed_ += computed * slowness_;
    runs_ = false;
  }
  void start() {
    if (slowness_ == 0) find_slowness();
    since_ = processor_seconds();
    runs_ = true;
  }

  double send() {
    if (!sends_) ++exchanges_;
    if (!sends_ && !overlap_) wait_until(now_ + delay_, exchanged_);
    sends_ = true;
    return now_;
  }
  void end_exchange() { sends_ = false; }
  // All messages of an exchange have come, the last was sent then.
  void receive(double then) {
    late_ += std::max(0.0, then - now_);
    if (overlap_) way_ += std::clamp(then + delay_ - now_, 0.0, delay_);
    if (overlap_ && then + delay_ <= now_) ++behind_work_;
    wait_until(then + (overlap_ ? delay_ : 0), exchanged_);
  }
  void reduce(double latest, int ranks) {
    ++reductions_;
    wait_until(latest + delay_ * std::bit_width(static_cast<unsigned>(ranks - 1)), reduced_);
  }
  double now() const { return now_; }

  void tell(int rank) const {
    std::fprintf(
        stderr,
        "virtual time: rank %d clock %.6f computed %.6f exchanges %ld behind %ld waited %.6f late %.6f way %.6f "
        "reductions %ld waited %.6f\n",
        rank, now_, computed_, exchanges_, behind_work_, exchanged_, late_, way_, reductions_, reduced_);
  }

 private:
  void wait_until(double then, double& waits) {
    waits += std::max(0.0, then - now_);
    now_ = std::max(now_, then);
  }
  void find_slowness() {
    int rank = 0;
    PMPI_Comm_rank(MPI_COMM_WORLD, &rank);
    slowness_ = rank == variable("TREVI_SLOW_RANK", -1) ? 1 + variable("TREVI_SLOW_PERCENT", 10) / 100 : 1;
  }

  const double delay_ = 1e-6 * variable("TREVI_DELAY_US", 0);
  const bool overlap_ = variable("TREVI_OVERLAP", 1) != 0;
  double slowness_ = 0, since_ = 0, now_ = 0, computed_ = 0;
  double exchanged_ = 0, late_ = 0, way_ = 0, reduced_ = 0;  // s of waiting, by what for
  long exchanges_ = 0, behind_work_ = 0, reductions_ = 0;
  bool runs_ = false, sends_ = false;
};

Clock timer;
std::array<Sent, 4096> sent;
std::size_t sends = 0;
std::map<MPI_Request, Received> expected;  // by the request of the message itself
MPI_Request reduction = MPI_REQUEST_NULL;
MPI_Request times_of_reduction = MPI_REQUEST_NULL;
double own_time = 0, latest_time = 0;
int reducing_ranks = 1;

// What is to be done when these have come.
void arrive(const std::vector<MPI_Request>& requests) {
  double last = -1;
  for (const MPI_Request request : requests) {
    if (request != MPI_REQUEST_NULL && request == reduction) {
      PMPI_Wait(&times_of_reduction, MPI_STATUS_IGNORE);
      timer.reduce(latest_time, reducing_ranks);
      reduction = MPI_REQUEST_NULL;
    }
    const auto found = expected.find(request);
    if (found == expected.end()) continue;
    PMPI_Wait(&found->second.request, MPI_STATUS_IGNORE);
    last = std::max(last, *found->second.time);
    expected.erase(found);
  }
  if (last >= 0) timer.receive(last);
  timer.end_exchange();
}

}  // namespace

extern "C" {

int MPI_Init_thread(int* argc, char*** argv, int wanted, int* provided) {
  const int result = PMPI_Init_thread(argc, argv, wanted, provided);
  timer.start();
  return result;
}

int MPI_Isend(const void* data, int count, MPI_Datatype type, int to, int tag, MPI_Comm comm, MPI_Request* request) {
  timer.stop();
  Sent& mine = sent[sends++ % sent.size()];
  PMPI_Wait(&mine.request, MPI_STATUS_IGNORE);
  mine.time = timer.send();
  PMPI_Isend(&mine.time, 1, MPI_DOUBLE, to, tag + tag_of_times, comm, &mine.request);
  const int result = PMPI_Isend(data, count, type, to, tag, comm, request);
  timer.start();
  return result;
}

int MPI_Irecv(void* data, int count, MPI_Datatype type, int from, int tag, MPI_Comm comm, MPI_Request* request) {
  timer.stop();
  const int result = PMPI_Irecv(data, count, type, from, tag, comm, request);
  Received& other = expected[*request];
  PMPI_Irecv(other.time.get(), 1, MPI_DOUBLE, from, tag + tag_of_times, comm, &other.request);
  timer.start();
  return result;
}

int MPI_Iallreduce(const void* from, void* to, int count, MPI_Datatype type, MPI_Op op, MPI_Comm comm,
                   MPI_Request* request) {
  timer.stop();
  own_time = timer.now();
  PMPI_Comm_size(comm, &reducing_ranks);
  const int result = PMPI_Iallreduce(from, to, count, type, op, comm, request);
  PMPI_Iallreduce(&own_time, &latest_time, 1, MPI_DOUBLE, MPI_MAX, comm, &times_of_reduction);
  reduction = *request;
  timer.start();
  return result;
}

int MPI_Testall(int count, MPI_Request* requests, int* done, MPI_Status* statuses) {
  timer.stop();
  const std::vector<MPI_Request> asked(requests, requests + count);
  const int result = PMPI_Testall(count, requests, done, statuses);
  if (*done != 0) arrive(asked);
  if (*done != 0) timer.start();
  return result;
}

int MPI_Allreduce(const void* from, void* to, int count, MPI_Datatype type, MPI_Op op, MPI_Comm comm) {
  timer.stop();
  double mine = timer.now(), latest = 0;
  int ranks = 1;
  PMPI_Comm_size(comm, &ranks);
  PMPI_Allreduce(&mine, &latest, 1, MPI_DOUBLE, MPI_MAX, comm);
  const int result = PMPI_Allreduce(from, to, count, type, op, comm);
  timer.reduce(latest, ranks);
  timer.start();
  return result;
}

int MPI_Finalize() {
  timer.stop();
  int rank = 0;
  PMPI_Comm_rank(MPI_COMM_WORLD, &rank);
  timer.tell(rank);
  for (Sent& mine : sent) PMPI_Wait(&mine.request, MPI_STATUS_IGNORE);
  return PMPI_Finalize();
}

}  // extern "C"
