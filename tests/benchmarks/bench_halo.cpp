// usage: mpirun -np P bench_halo [ROUNDS, default 300]
// What the performance model of postprocess/scaling.py rests on: the time of one exchange with both neighbours in the
// chain of ranks, as the halo does it, against the bytes of a message, and of the sum of one number over all ranks.
// Prints CSV: operation, bytes of a message, ranks, fastest and median time in microseconds on the slowest rank.
#include <fmt/format.h>
#include <mpi.h>

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <functional>
#include <vector>

#include "trevi/session.hpp"

namespace trevi {
namespace {

void exchange(MPI_Comm comm, std::vector<char>& sent, std::vector<char>& received) {
  const int rank = rank_of(comm), count = static_cast<int>(sent.size() / 2);
  std::vector<MPI_Request> requests;
  for (const int side : {0, 1}) {
    const int peer = rank + 2 * side - 1;
    if (peer < 0 || peer >= size_of(comm)) continue;
    MPI_Irecv(received.data() + side * count, count, MPI_BYTE, peer, 1 - side, comm, &requests.emplace_back());
    MPI_Isend(sent.data() + side * count, count, MPI_BYTE, peer, side, comm, &requests.emplace_back());
  }
  MPI_Waitall(static_cast<int>(requests.size()), requests.data(), MPI_STATUSES_IGNORE);
}

/// Prints a row; all ranks begin each round together.
void measure(MPI_Comm comm, const char* operation, std::size_t bytes, int rounds, const std::function<void()>& work) {
  std::vector<double> times;
  for (int k = 0; k < 10; ++k) work();
  for (int k = 0; k < rounds; ++k) {
    MPI_Barrier(comm);
    const double start = MPI_Wtime();
    work();
    times.push_back(1e6 * (MPI_Wtime() - start));
  }
  MPI_Allreduce(MPI_IN_PLACE, times.data(), rounds, MPI_DOUBLE, MPI_MAX, comm);
  std::sort(times.begin(), times.end());
  if (rank_of(comm) != 0) return;
  fmt::print("{},{},{},{:.3f},{:.3f}\n", operation, bytes, size_of(comm), times.front(), times[times.size() / 2]);
  std::fflush(stdout);
}

void bench(MPI_Comm comm, int rounds) {
  if (rank_of(comm) == 0) fmt::print("operation,bytes,ranks,fastest_us,median_us\n");
  double number = 1, sum = 0;
  measure(comm, "reduce", sizeof number, rounds, [&] { MPI_Allreduce(&number, &sum, 1, MPI_DOUBLE, MPI_SUM, comm); });
  for (std::size_t bytes = 16; bytes <= (std::size_t{1} << 24U); bytes *= 4) {
    std::vector<char> sent(2 * bytes, 'x'), received(2 * bytes, ' ');
    measure(comm, "exchange", bytes, rounds, [&] { exchange(comm, sent, received); });
  }
}

}  // namespace
}  // namespace trevi

int main(int argc, char** argv) {
  const trevi::Session session(argc, argv);
  const int rounds = argc > 1 ? std::atoi(argv[1]) : 300;
  if (rounds < 1 || session.size() < 2) {
    std::fprintf(stderr, "usage: mpirun -np P bench_halo [ROUNDS]; P and ROUNDS are at least 2 and 1\n");
    return 2;
  }
  trevi::bench(session.comm(), rounds);
}
