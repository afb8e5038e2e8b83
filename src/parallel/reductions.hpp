// Reductions over all ranks. Collective.
// Floating-point sums depend on their order, so a sum over particles is formed per cell plane by the plane's one owner,
// and the planes are added in their global order: the same bits on any rank count. Maxima and integer sums need no such
// care.
#pragma once

#include <mpi.h>

#include <span>
#include <vector>

#include "trevi/types.hpp"

namespace trevi {

Real max_over_ranks(MPI_Comm comm, Real value);
Real min_over_ranks(MPI_Comm comm, Real value);
GlobalId sum_over_ranks(MPI_Comm comm, GlobalId value);
/// Over the ranks below this one: where its rows begin, when ranks give theirs in rank order.
GlobalId sum_over_lower_ranks(MPI_Comm comm, GlobalId value);

/// What each rank has of its planes, joined in plane order on all ranks; every rank hands in whole rows of one length.
std::vector<Real> gather_planes(MPI_Comm comm, std::span<const Real> partial);

/// `partial` holds one row of `columns` sums for each cell plane this rank owns, in plane order; ranks own planes in
/// rank order. Returns the `columns` totals on all ranks.
std::vector<Real> sum_over_planes(MPI_Comm comm, std::span<const Real> partial, int columns);

}  // namespace trevi
