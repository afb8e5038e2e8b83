// Waiting for other ranks so that a busy machine loses little: a rank polls for some 50 µs, as long as most waits of a
// step take, and then sleeps between polls, a quarter of the time that it has waited and at most 100 µs. MPI's own
// waiting polls without end, and keeps the rank that it waits for from a core that both share with other work. For the
// calls within a step; the others are few. The log has the time of all waiting as Waiting, and of it that of reductions
// as Reductions. Collective, as the calls that they stand for.
#pragma once

#include <mpi.h>

#include <span>

namespace trevi {

/// MPI_Waitall.
void wait_all(std::span<MPI_Request> requests);

/// MPI_Allreduce in place.
void all_reduce(MPI_Comm comm, void* data, int count, MPI_Datatype type, MPI_Op op);

}  // namespace trevi
