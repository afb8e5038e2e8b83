#include "solver/swept_rows.hpp"

#include <algorithm>
#include <atomic>
#include <bit>
#include <type_traits>
#include <utility>

#include "base/hash.hpp"
#include "base/threads.hpp"

namespace trevi {

namespace {

template <class T>
using BitsOf = std::conditional_t<sizeof(T) == 4, std::uint32_t, std::uint64_t>;

}  // namespace

void SweptRows::start(const CellOrder& order) {
  order_ = &order;
  planes_ = order.planes();
  rows_ = order.rows();
  const auto all = static_cast<std::size_t>(planes_ + 2) * static_cast<std::size_t>(rows_ + 2);
  held_.assign(all, 0);
  moved_.assign(all, 1);
  shifted_.assign(all, 0);
  digest_.assign(all, 0);
}

// Plane k is counted with the ghost plane before the owned ones. Where no other rank has rows of the plane, the rows
// beyond the ends are those at the other end, as if the box were periodic.
std::size_t SweptRows::index(LocalId k, LocalId r) const {
  if (!order_->rows_are_cut()) r = (r + rows_) % rows_;
  return static_cast<std::size_t>(k) * static_cast<std::size_t>(rows_ + 2) + static_cast<std::size_t>(r + 1);
}

template <class Visit>
void SweptRows::for_each_row(const Visit& visit) const {
  const LocalId beside = order_->rows_are_cut() ? 1 : 0, rows = rows_ + 2 * beside;
  for_each_part((planes_ + 2) * rows, [&](LocalId row) { visit(row / rows, row % rows - beside); });
}

template <class T>
void SweptRows::find_multipliers(const std::vector<Packed<T>>& records) {
  for_each_row([&](LocalId k, LocalId r) {
    const auto [begin, end] = order_->row(k, r);
    const auto in_row = records.begin();
    held_[index(k, r)] = static_cast<char>(
        std::any_of(in_row + begin, in_row + end, [](const Packed<T>& record) { return record.w != 0; }));
  });
}

void SweptRows::move() {
  for_each_row([&](LocalId k, LocalId r) {
    if (!is_own(k, r)) return;
    const bool moves = is_beside(held_, k, r);
    moved_[index(k, r)] = static_cast<char>(moves);
    if (moves) shifted_[index(k, r)] = 1;
  });
}

template <class T>
void SweptRows::find_moved_ghosts(const std::vector<Packed<T>>& records) {
  for_each_row([&](LocalId k, LocalId r) {
    if (is_own(k, r)) return;
    const auto [begin, end] = order_->row(k, r);
    std::uint64_t digest = 0;
    for (LocalId i = begin; i < end; ++i) {
      const Packed<T>& record = records[static_cast<std::size_t>(i)];
      for (const auto coordinate : {record.x, record.y, record.z})
        digest = mix(digest ^ static_cast<std::uint64_t>(std::bit_cast<BitsOf<T>>(coordinate)));
    }
    moved_[index(k, r)] = static_cast<char>(digest != std::exchange(digest_[index(k, r)], digest));
  });
}

void SweptRows::move_all() {
  std::fill(moved_.begin(), moved_.end(), char{1});
  std::fill(shifted_.begin(), shifted_.end(), char{1});
}

void SweptRows::move(LocalId i) {
  const std::span<const LocalId> starts = order_->row_starts();
  const auto row = static_cast<LocalId>(std::upper_bound(starts.begin(), starts.end(), i) - starts.begin()) - 1;
  for (std::vector<char>* marks : {&moved_, &shifted_})
    std::atomic_ref((*marks)[index(row / rows_ + 1, row % rows_)]).store(1, std::memory_order_relaxed);
}

bool SweptRows::is_beside(const std::vector<char>& marked, LocalId k, LocalId r) const {
  for (LocalId i = k - 1; i <= k + 1; ++i) {
    for (LocalId j = r - 1; j <= r + 1; ++j)
      if (marked[index(i, j)] != 0) return true;
  }
  return false;
}

std::span<const char> SweptRows::find_near_shifts() {
  constexpr LocalId reach = 3;
  const bool cut = order_->rows_are_cut();
  const auto shifts = [&](LocalId k, LocalId r) {
    if (!cut) r = (r % rows_ + rows_) % rows_;
    if (is_own(k, r)) return shifted_[index(k, r)] != 0;
    const auto [begin, end] = order_->row(k, r);
    return end > begin;
  };
  near_.assign(static_cast<std::size_t>(planes_) * static_cast<std::size_t>(rows_), 0);
  for_each_part(planes_ * rows_, [&](LocalId row) {
    const LocalId k = row / rows_ + 1, r = row % rows_;
    const Range planes{std::max(k - reach, 0), std::min(k + reach, planes_ + 1) + 1};
    const Range rows{cut ? std::max(r - reach, -1) : r - reach, (cut ? std::min(r + reach, rows_) : r + reach) + 1};
    for (LocalId i = planes.begin; i < planes.end; ++i) {
      for (LocalId j = rows.begin; j < rows.end; ++j)
        if (shifts(i, j)) near_[static_cast<std::size_t>(row)] = 1;
    }
  });
  return near_;
}

std::vector<Range> SweptRows::beside(const std::vector<char>& marked, bool bridged) const {
  constexpr LocalId shortest = 2048;  // shorter ranges are not worth a loop of their own
  const LocalId gap = bridged ? shortest : 0;
  const std::span<const LocalId> starts = order_->row_starts();
  std::vector<Range> found;
  for (LocalId row = 0; row < planes_ * rows_; ++row) {
    const Range owned{starts[static_cast<std::size_t>(row)], starts[static_cast<std::size_t>(row) + 1]};
    if (owned.size() == 0 || !is_beside(marked, row / rows_ + 1, row % rows_)) continue;
    if (!found.empty() && owned.begin - found.back().end <= gap) {
      found.back().end = owned.end;
    } else {
      found.push_back(owned);
    }
  }
  return found;
}

template void SweptRows::find_multipliers(const std::vector<Packed<float>>&);
template void SweptRows::find_multipliers(const std::vector<Packed<double>>&);
template void SweptRows::find_moved_ghosts(const std::vector<Packed<float>>&);
template void SweptRows::find_moved_ghosts(const std::vector<Packed<double>>&);

}  // namespace trevi
