#include "parallel/core_share.hpp"

#include "base/cores.hpp"
#include "trevi/session.hpp"

namespace trevi {

int fair_threads(MPI_Comm comm, const std::vector<int>& cores, double allowed) {
  MPI_Comm machine = MPI_COMM_NULL;
  MPI_Comm_split_type(comm, MPI_COMM_TYPE_SHARED, 0, MPI_INFO_NULL, &machine);
  int length = cores.empty() ? 0 : cores.back() + 1;
  MPI_Allreduce(MPI_IN_PLACE, &length, 1, MPI_INT, MPI_MAX, machine);
  std::vector<int> users(static_cast<std::size_t>(length)), users_of_mine;
  for (const int core : cores) users[static_cast<std::size_t>(core)] = 1;
  MPI_Allreduce(MPI_IN_PLACE, users.data(), length, MPI_INT, MPI_SUM, machine);
  for (const int core : cores) users_of_mine.push_back(users[static_cast<std::size_t>(core)]);
  const int ranks = size_of(machine);
  MPI_Comm_free(&machine);
  return threads_for_cores(users_of_mine, allowed, ranks);
}

int ranks_of_machine(MPI_Comm comm) {
  MPI_Comm machine = MPI_COMM_NULL;
  MPI_Comm_split_type(comm, MPI_COMM_TYPE_SHARED, 0, MPI_INFO_NULL, &machine);
  const int ranks = size_of(machine);
  MPI_Comm_free(&machine);
  return ranks;
}

}  // namespace trevi
