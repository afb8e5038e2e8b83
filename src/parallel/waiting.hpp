// Waiting for other ranks in a way that loses little time on a busy machine: a rank polls for about 50 µs, as long as
// most waits of a step take, and then sleeps between polls for a quarter of the time that it has waited, at most 100
// µs. MPI's own waiting polls without end, and so keeps the rank that it waits for off a core that both share with
// other work. For the calls within a step; there are few others. The log has the time of all waiting as Waiting, and
// the part in reductions as Reductions. Collective, like the calls that they replace.
#pragma once

#include <mpi.h>

#include <span>

namespace trevi {

/// MPI_Waitall.
void wait_all(std::span<MPI_Request> requests);

/// MPI_Allreduce in place.
void all_reduce(MPI_Comm comm, void* data, int count, MPI_Datatype type, MPI_Op op);

}  // namespace trevi
