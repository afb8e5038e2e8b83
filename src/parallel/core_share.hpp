// What a rank gets of the cores of its machine. Collective.
#pragma once

#include <mpi.h>

#include <vector>

namespace trevi {

/// Threads for a rank that may use `cores` (base/cores.hpp) and `allowed` processors' worth of time. Ranks of one
/// machine that may use the same core share it, so that all together have no more threads than cores, but for those
/// that have less than a core. What travels is one number for each core of a machine, within it.
int fair_threads(MPI_Comm comm, const std::vector<int>& cores, double allowed);

/// Ranks of `comm` on the machine of this one.
int ranks_of_machine(MPI_Comm comm);

}  // namespace trevi
