#include "trevi/output/id_order.hpp"

#include <algorithm>
#include <limits>
#include <numeric>

#include "trevi/base/error.hpp"

namespace trevi {

namespace {

std::vector<LocalId> ascending(std::span<const GlobalId> ids) {
  std::vector<LocalId> order(ids.size());
  std::iota(order.begin(), order.end(), 0);
  std::sort(order.begin(), order.end(),
            [&](LocalId a, LocalId b) { return ids[static_cast<std::size_t>(a)] < ids[static_cast<std::size_t>(b)]; });
  return order;
}

GlobalId midpoint(GlobalId low, GlobalId high) {
  // Unsigned: the ids may span more than half of the int64 range.
  return low + static_cast<GlobalId>((static_cast<std::uint64_t>(high) - static_cast<std::uint64_t>(low)) / 2);
}

GlobalId count_up_to(std::span<const GlobalId> sorted, GlobalId id) {
  return std::upper_bound(sorted.begin(), sorted.end(), id) - sorted.begin();
}

std::vector<int> starts_of(const std::vector<int>& counts) {
  std::vector<int> starts(counts.size());
  std::exclusive_scan(counts.begin(), counts.end(), starts.begin(), 0);
  return starts;
}

std::vector<GlobalId> pick(std::span<const GlobalId> ids, const std::vector<LocalId>& order) {
  std::vector<GlobalId> picked(order.size());
  for (std::size_t k = 0; k < order.size(); ++k) picked[k] = ids[static_cast<std::size_t>(order[k])];
  return picked;
}

}  // namespace

IdOrder::IdOrder(MPI_Comm comm, std::span<const GlobalId> ids, GlobalId block)
    : comm_(comm), send_order_(ascending(ids)) {
  const std::vector<GlobalId> sorted = pick(ids, send_order_);
  const auto count = static_cast<GlobalId>(ids.size());
  MPI_Allreduce(&count, &total_, 1, MPI_INT64_T, MPI_SUM, comm_);
  plan_exchange(sorted, find_splitters(sorted, block));

  std::vector<GlobalId> received(static_cast<std::size_t>(receive_starts_.back() + receive_counts_.back()));
  exchange(sorted.data(), received.data(), sizeof(GlobalId));
  receive_order_ = ascending(received);
  ids_ = pick(received, receive_order_);

  const auto mine = static_cast<GlobalId>(ids_.size());
  MPI_Exscan(&mine, &first_row_, 1, MPI_INT64_T, MPI_SUM, comm_);
  if (rank_of(comm_) == 0) first_row_ = 0;  // MPI_Exscan leaves it undefined there
}

// Splitter k is the smallest id that as many ids do not exceed as belong to the ranks 0 to k.
std::vector<GlobalId> IdOrder::find_splitters(std::span<const GlobalId> sorted, GlobalId block) {
  const auto ranks = static_cast<GlobalId>(size_of(comm_));
  const GlobalId blocks = (total_ + block - 1) / block;
  const GlobalId rows = (blocks + ranks - 1) / ranks * block;
  using Limits = std::numeric_limits<GlobalId>;
  GlobalId low = sorted.empty() ? Limits::max() : sorted.front();
  GlobalId high = sorted.empty() ? Limits::lowest() : sorted.back();
  MPI_Allreduce(MPI_IN_PLACE, &low, 1, MPI_INT64_T, MPI_MIN, comm_);
  MPI_Allreduce(MPI_IN_PLACE, &high, 1, MPI_INT64_T, MPI_MAX, comm_);

  const auto n = static_cast<std::size_t>(ranks - 1);
  if (total_ == 0) return std::vector<GlobalId>(n, 0);
  std::vector<GlobalId> lows(n, low), highs(n, high), counts(n);
  while (lows != highs) {
    for (std::size_t k = 0; k < n; ++k) counts[k] = count_up_to(sorted, midpoint(lows[k], highs[k]));
    MPI_Allreduce(MPI_IN_PLACE, counts.data(), static_cast<int>(n), MPI_INT64_T, MPI_SUM, comm_);
    for (std::size_t k = 0; k < n; ++k) {
      if (lows[k] == highs[k]) continue;
      const GlobalId wanted = std::min(total_, rows * static_cast<GlobalId>(k + 1));
      const GlobalId middle = midpoint(lows[k], highs[k]);
      if (counts[k] >= wanted)
        highs[k] = middle;
      else
        lows[k] = middle + 1;
    }
  }
  return lows;
}

void IdOrder::plan_exchange(std::span<const GlobalId> sorted, std::span<const GlobalId> splitters) {
  const auto ranks = static_cast<std::size_t>(size_of(comm_));
  send_counts_.resize(ranks);
  receive_counts_.resize(ranks);
  GlobalId before = 0;
  for (std::size_t k = 0; k < ranks; ++k) {
    const GlobalId until = k + 1 < ranks ? count_up_to(sorted, splitters[k]) : static_cast<GlobalId>(sorted.size());
    send_counts_[k] = static_cast<int>(until - before);
    before = until;
  }
  MPI_Alltoall(send_counts_.data(), 1, MPI_INT, receive_counts_.data(), 1, MPI_INT, comm_);
  send_starts_ = starts_of(send_counts_);
  receive_starts_ = starts_of(receive_counts_);
}

void IdOrder::exchange(const void* sent, void* received, std::size_t bytes_per_row) const {
  MPI_Datatype row;
  MPI_Type_contiguous(static_cast<int>(bytes_per_row), MPI_BYTE, &row);
  MPI_Type_commit(&row);
  MPI_Alltoallv(sent, send_counts_.data(), send_starts_.data(), row, received, receive_counts_.data(),
                receive_starts_.data(), row, comm_);
  MPI_Type_free(&row);
}

}  // namespace trevi
