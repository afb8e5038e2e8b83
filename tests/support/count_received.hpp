// Counts what this process receives from others, by MPI's profiling interface: to be included in one file of a program.
#pragma once

#include <mpi.h>

#include <cstdint>

namespace trevi::test {

/// Bytes, exchanges of all ranks with all, and messages of one rank.
struct Received {
  std::int64_t bytes = 0, exchanges = 0, messages = 0;
};
inline Received received;

inline std::int64_t bytes_of(std::int64_t count, MPI_Datatype type) {
  int bytes = 0;
  MPI_Type_size(type, &bytes);
  return count * bytes;
}

}  // namespace trevi::test

// PETSc has macros of these names.
#undef MPI_Alltoallv
#undef MPI_Irecv

extern "C" int MPI_Alltoallv(const void* sent, const int* send_counts, const int* send_starts, MPI_Datatype send_type,
                             void* to, const int* receive_counts, const int* receive_starts, MPI_Datatype receive_type,
                             MPI_Comm comm) {
  using namespace trevi::test;
  int ranks = 0, own = 0;
  MPI_Comm_size(comm, &ranks);
  MPI_Comm_rank(comm, &own);
  ++received.exchanges;
  for (int rank = 0; rank < ranks; ++rank)
    if (rank != own) received.bytes += bytes_of(receive_counts[rank], receive_type);
  return PMPI_Alltoallv(sent, send_counts, send_starts, send_type, to, receive_counts, receive_starts, receive_type,
                        comm);
}

extern "C" int MPI_Irecv(void* to, int count, MPI_Datatype type, int source, int tag, MPI_Comm comm,
                         MPI_Request* request) {
  ++trevi::test::received.messages;
  trevi::test::received.bytes += trevi::test::bytes_of(count, type);
  return PMPI_Irecv(to, count, type, source, tag, comm, request);
}
