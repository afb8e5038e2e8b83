// The share of a rank in the cores of its machine. Collective.
#pragma once

#include <mpi.h>

#include <vector>

namespace trevi {

/// Threads for a rank that may use `cores` (base/cores.hpp) and the processor time of `allowed` processors. Ranks of
/// one machine that may use the same core share it, so that all together have no more threads than cores, except for
/// ranks with less than one core. One number for each core of a machine is communicated, within the machine.
int fair_threads(MPI_Comm comm, const std::vector<int>& cores, double allowed);

/// The number of ranks of `comm` on the machine of this one.
int ranks_of_machine(MPI_Comm comm);

}  // namespace trevi
