// Reductions over all ranks. Collective.
// Floating-point sums depend on their order, so a sum over particles is formed per cell plane by the plane's one owner,
// and the planes are added in their global order: the same bits on any rank count. Maxima and integer sums need no such
// care.
#pragma once

#include <mpi.h>

#include <cstddef>
#include <cstring>
#include <span>
#include <type_traits>
#include <vector>

#include "base/threads.hpp"
#include "trevi/types.hpp"

namespace trevi {

Real max_over_ranks(MPI_Comm comm, Real value);
Real min_over_ranks(MPI_Comm comm, Real value);
GlobalId sum_over_ranks(MPI_Comm comm, GlobalId value);
std::vector<GlobalId> sum_over_ranks(MPI_Comm comm, std::vector<GlobalId> values);
/// For the rows that the threads of each rank have, all of the same length.
std::vector<GlobalId> sum_over_threads_and_ranks(MPI_Comm comm, PerThread<std::vector<GlobalId>>& rows);
/// Sum over the ranks below this one: the index of this rank's first row if ranks write rows in rank order.
GlobalId sum_over_lower_ranks(MPI_Comm comm, GlobalId value);

/// The data of all ranks, concatenated in the order of the ranks, on all ranks.
std::vector<std::byte> gather_over_ranks(MPI_Comm comm, std::span<const std::byte> mine);
template <class T>
std::vector<T> gather_over_ranks(MPI_Comm comm, const std::vector<T>& mine) {
  static_assert(std::is_trivially_copyable_v<T>);
  const std::vector<std::byte> bytes = gather_over_ranks(comm, std::as_bytes(std::span(mine)));
  std::vector<T> all(bytes.size() / sizeof(T));
  if (!all.empty()) std::memcpy(all.data(), bytes.data(), bytes.size());
  return all;
}

/// `partial` holds one row of `columns` sums for each cell plane this rank owns, in plane order; ranks own planes in
/// rank order. Returns the `columns` totals on all ranks.
std::vector<Real> sum_over_planes(MPI_Comm comm, std::span<const Real> partial, int columns);

/// The same for sums that have names: Sums::for_each(visit) calls visit(number) for each of them.
template <class Sums>
Sums sum_over_planes(MPI_Comm comm, std::vector<Sums>& partial) {
  Sums total;
  int columns = 0;
  total.for_each([&](Real&) { ++columns; });
  std::vector<Real> rows;
  rows.reserve(partial.size() * static_cast<std::size_t>(columns));
  for (Sums& one : partial) one.for_each([&](Real& number) { rows.push_back(number); });
  const std::vector<Real> sums = sum_over_planes(comm, rows, columns);
  auto next = sums.begin();
  total.for_each([&](Real& number) { number = *next++; });
  return total;
}

}  // namespace trevi
