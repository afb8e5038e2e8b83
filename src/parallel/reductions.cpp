#include "parallel/reductions.hpp"

#include <algorithm>
#include <functional>
#include <numeric>
#include <utility>

#include "parallel/waiting.hpp"
#include "trevi/session.hpp"

namespace trevi {

namespace {

template <class T>
T reduced(MPI_Comm comm, T value, MPI_Datatype type, MPI_Op op) {
  all_reduce(comm, &value, 1, type, op);
  return value;
}

}  // namespace

Real max_over_ranks(MPI_Comm comm, Real value) { return reduced(comm, value, MPI_DOUBLE, MPI_MAX); }
Real min_over_ranks(MPI_Comm comm, Real value) { return reduced(comm, value, MPI_DOUBLE, MPI_MIN); }
GlobalId sum_over_ranks(MPI_Comm comm, GlobalId value) { return reduced(comm, value, MPI_INT64_T, MPI_SUM); }

std::vector<GlobalId> sum_over_ranks(MPI_Comm comm, std::vector<GlobalId> values) {
  all_reduce(comm, values.data(), static_cast<int>(values.size()), MPI_INT64_T, MPI_SUM);
  return values;
}

std::vector<GlobalId> sum_over_threads_and_ranks(MPI_Comm comm, PerThread<std::vector<GlobalId>>& rows) {
  std::vector<GlobalId> sums;
  rows.for_each([&](const std::vector<GlobalId>& row) {
    sums.resize(row.size());
    std::transform(row.begin(), row.end(), sums.begin(), sums.begin(), std::plus());
  });
  return sum_over_ranks(comm, std::move(sums));
}

GlobalId sum_over_lower_ranks(MPI_Comm comm, GlobalId value) {
  GlobalId sum = 0;
  MPI_Exscan(&value, &sum, 1, MPI_INT64_T, MPI_SUM, comm);
  return rank_of(comm) == 0 ? 0 : sum;  // MPI_Exscan leaves it undefined on rank 0
}

std::vector<std::byte> gather_over_ranks(MPI_Comm comm, std::span<const std::byte> mine) {
  const int bytes = static_cast<int>(mine.size());
  std::vector<int> counts(static_cast<std::size_t>(size_of(comm)));
  MPI_Allgather(&bytes, 1, MPI_INT, counts.data(), 1, MPI_INT, comm);
  std::vector<int> places(counts.size(), 0);
  std::exclusive_scan(counts.begin(), counts.end(), places.begin(), 0);
  std::vector<std::byte> all(static_cast<std::size_t>(places.back() + counts.back()));
  MPI_Allgatherv(mine.data(), bytes, MPI_BYTE, all.data(), counts.data(), places.data(), MPI_BYTE, comm);
  return all;
}

std::vector<Real> sum_over_planes(MPI_Comm comm, std::span<const Real> partial, int columns) {
  const std::vector<Real> rows = gather_over_ranks(comm, std::vector<Real>(partial.begin(), partial.end()));
  std::vector<Real> totals(static_cast<std::size_t>(columns), 0.0);
  for (std::size_t k = 0; k < rows.size(); ++k) totals[k % totals.size()] += rows[k];
  return totals;
}

}  // namespace trevi
