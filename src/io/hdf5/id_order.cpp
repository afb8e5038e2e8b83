#include "io/hdf5/id_order.hpp"

#include <algorithm>
#include <array>
#include <limits>
#include <numeric>
#include <utility>

#include "parallel/reductions.hpp"

namespace trevi {

namespace {

/// Ids in ascending order, and the previous index of each.
struct Sorted {
  std::vector<GlobalId> ids;
  std::vector<LocalId> order;
};

Sorted sort_by_comparison(std::span<const GlobalId> ids) {
  Sorted sorted{std::vector<GlobalId>(ids.size()), std::vector<LocalId>(ids.size())};
  std::iota(sorted.order.begin(), sorted.order.end(), 0);
  std::sort(sorted.order.begin(), sorted.order.end(),
            [&](LocalId a, LocalId b) { return ids[static_cast<std::size_t>(a)] < ids[static_cast<std::size_t>(b)]; });
  for (std::size_t k = 0; k < ids.size(); ++k) sorted.ids[k] = ids[static_cast<std::size_t>(sorted.order[k])];
  return sorted;
}

Range all_of(const std::vector<std::uint64_t>& numbers) { return {0, static_cast<LocalId>(numbers.size())}; }

// One pass of a radix sort, by eleven bits of the numbers. Equal digits keep their order, so that it does not matter
// which thread sorts which part.
void sort_digit(const std::vector<std::uint64_t>& from, std::vector<std::uint64_t>& to, int shift) {
  constexpr std::size_t digits = 2048;
  constexpr LocalId part_size = 32768;
  const auto digit = [shift](std::uint64_t n) { return (n >> shift) % digits; };
  std::vector<std::array<LocalId, digits>> starts(from.size() / part_size + 1);  // of each part's share of a digit
  const auto for_each_thread_part = [&](const auto& work) {
    for_each_part(all_of(from), part_size, [&](Range part) {
      work(std::span(from).subspan(static_cast<std::size_t>(part.begin), static_cast<std::size_t>(part.size())),
           starts[static_cast<std::size_t>(part.begin / part_size)].data());
    });
  };
  for_each_thread_part([digit](std::span<const std::uint64_t> numbers, LocalId* counts) {
    const auto own = digit;  // which the compiler may keep in a register
    for (const std::uint64_t n : numbers) ++counts[own(n)];
  });
  LocalId start = 0;
  for (std::size_t d = 0; d < digits; ++d) {
    for (auto& part : starts) start += std::exchange(part[d], start);
  }
  for_each_thread_part([digit, to = to.data()](std::span<const std::uint64_t> numbers, LocalId* places) {
    const auto own = digit;
    std::uint64_t* const sorted = to;
    for (const std::uint64_t n : numbers) sorted[places[own(n)]++] = n;
  });
}

// Five times as fast as comparison, for ids that span less than 2^32: id and index are packed into one number.
Sorted sort_by_ids(std::span<const GlobalId> ids) {
  if (ids.empty()) return {};
  const auto [least, most] = std::minmax_element(ids.begin(), ids.end());
  const auto low = static_cast<std::uint64_t>(*least), range = static_cast<std::uint64_t>(*most) - low;
  if (range >> 32U != 0) return sort_by_comparison(ids);
  std::vector<std::uint64_t> packed(ids.size()), other(ids.size());
  for_each_index(all_of(packed),
                 [&, low](std::size_t k) { packed[k] = (static_cast<std::uint64_t>(ids[k]) - low) << 32U | k; });
  for (int shift = 32; shift < 64 && (range << 32U) >> shift != 0; shift += 11) {
    sort_digit(packed, other, shift);
    packed.swap(other);
  }
  Sorted sorted{std::vector<GlobalId>(ids.size()), std::vector<LocalId>(ids.size())};
  for_each_index(all_of(packed), [&, low](std::size_t k) {
    sorted.ids[k] = static_cast<GlobalId>((packed[k] >> 32U) + low);
    sorted.order[k] = static_cast<LocalId>(packed[k] & 0xffffffffU);
  });
  return sorted;
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

}  // namespace

IdOrder::IdOrder(MPI_Comm comm, std::span<const GlobalId> ids, GlobalId block) : comm_(comm) {
  Sorted sent = sort_by_ids(ids);
  send_order_ = std::move(sent.order);
  total_ = sum_over_ranks(comm_, static_cast<GlobalId>(ids.size()));
  plan_exchange(sent.ids, find_splitters(sent.ids, block));

  ids_.resize(static_cast<std::size_t>(receive_starts_.back() + receive_counts_.back()));
  exchange(sent.ids.data(), ids_.data(), sizeof(GlobalId));
  arrives_sorted_ = std::is_sorted(ids_.begin(), ids_.end());
  if (!arrives_sorted_) {
    Sorted received = sort_by_ids(ids_);
    receive_order_ = std::move(received.order);
    ids_ = std::move(received.ids);
  }

  first_row_ = sum_over_lower_ranks(comm_, static_cast<GlobalId>(ids_.size()));
}

// Splitter k is the smallest id for which the number of ids up to it is at least that belonging to ranks 0 to k.
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
  const bool without_gaps =
      static_cast<std::uint64_t>(high) - static_cast<std::uint64_t>(low) == static_cast<std::uint64_t>(total_ - 1);
  std::vector<GlobalId> lows(n, low), highs(n, high), tried(n), counts(n);
  for (int round = 0; lows != highs; ++round) {
    for (std::size_t k = 0; k < n; ++k) {
      const GlobalId wanted = std::min(total_, rows * static_cast<GlobalId>(k + 1));
      // Ids without gaps, the usual case, are found in two rounds: by the last id that is wanted, and by the one
      // before.
      const bool inside = round < 2 && without_gaps;
      tried[k] = inside ? std::clamp(low + wanted - 1 - round, lows[k], highs[k]) : midpoint(lows[k], highs[k]);
      counts[k] = count_up_to(sorted, tried[k]);
    }
    MPI_Allreduce(MPI_IN_PLACE, counts.data(), static_cast<int>(n), MPI_INT64_T, MPI_SUM, comm_);
    for (std::size_t k = 0; k < n; ++k) {
      if (lows[k] == highs[k]) continue;
      const GlobalId wanted = std::min(total_, rows * static_cast<GlobalId>(k + 1));
      if (counts[k] >= wanted)
        highs[k] = tried[k];
      else
        lows[k] = tried[k] + 1;
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
