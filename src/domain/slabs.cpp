#include "domain/slabs.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numeric>

#include "trevi/error.hpp"

namespace trevi {

namespace {

constexpr Real max_counted = 2e9;  // below 2^31, with room for water that gathers

// The last cut with at most this weight in the planes before it; `before` holds these weights for each cut.
LocalId cut_at(std::span<const Real> before, Real weight) {
  return static_cast<LocalId>(std::upper_bound(before.begin(), before.end(), weight) - before.begin()) - 1;
}

LocalId nearest_cut(std::span<const Real> before, Real weight) {
  const auto cut = static_cast<std::size_t>(cut_at(before, weight));
  const bool next = cut + 1 < before.size() && before[cut + 1] - weight < weight - before[cut];
  return static_cast<LocalId>(next ? cut + 1 : cut);
}

// The first plane before `end` with at least this weight in the planes before it, looked for from there downwards in
// strides that double: a rank has few of all planes.
LocalId first_within(std::span<const Real> before, LocalId end, Real weight) {
  LocalId last = end, stride = 1;
  while (last > 0 && before[static_cast<std::size_t>(std::max(last - stride, 0))] >= weight) {
    last = std::max(last - stride, 0);
    stride *= 2;
  }
  const auto first = before.begin() + std::max(last - stride, 0);
  return static_cast<LocalId>(std::lower_bound(first, before.begin() + last, weight) - before.begin());
}

// The lowest cuts with at most the weight `largest` on each rank but the first, as far as at least one plane for each
// rank allows.
std::vector<LocalId> min_cuts(std::span<const Real> before, int ranks, Real largest) {
  std::vector<LocalId> cuts(static_cast<std::size_t>(ranks) + 1, 0);
  cuts.back() = static_cast<LocalId>(before.size()) - 1;
  for (int r = ranks - 1; r > 0; --r) {
    const LocalId next = cuts[static_cast<std::size_t>(r) + 1];
    const LocalId cut = first_within(before, next, before[static_cast<std::size_t>(next)] - largest);
    cuts[static_cast<std::size_t>(r)] = std::clamp(cut, r, next - 1);
  }
  return cuts;
}

Real heaviest(std::span<const Real> before, std::span<const LocalId> cuts) {
  Real weight = 0;
  for (std::size_t r = 0; r + 1 < cuts.size(); ++r) {
    weight =
        std::max(weight, before[static_cast<std::size_t>(cuts[r + 1])] - before[static_cast<std::size_t>(cuts[r])]);
  }
  return weight;
}

}  // namespace

Slabs::Slabs(std::span<const Real> weights, int ranks) {
  const auto planes = static_cast<LocalId>(weights.size());
  if (ranks > planes) {
    throw InputError("the box has " + std::to_string(planes) + " cell planes along the slab axis, fewer than the " +
                     std::to_string(ranks) + " ranks; use at most " + std::to_string(planes) +
                     " ranks, another [domain] slab_axis, or a smaller kernel_radius");
  }
  std::vector<Real> before(weights.size() + 1, 0.0);  // weight of all planes before this one
  std::partial_sum(weights.begin(), weights.end(), before.begin() + 1);
  // The smallest possible value of the largest weight of a rank, by bisection down to rounding. It is at least the mean
  // and exceeds that by a plane at most.
  const Real mean = before.back() / ranks, heaviest_plane = *std::max_element(weights.begin(), weights.end());
  constexpr Real rounding = 1e-13;
  Real impossible = std::max(mean, heaviest_plane) * (1 - rounding), largest = before.back();
  for (Real middle = (mean + heaviest_plane) * (1 + rounding); largest - impossible > rounding * largest;) {
    (heaviest(before, min_cuts(before, ranks, middle)) <= middle ? largest : impossible) = middle;
    middle = (impossible + largest) / 2;
  }
  // Among the cuts with no larger weight, those nearest to equal parts.
  const std::vector<LocalId> least = min_cuts(before, ranks, largest);
  cuts_.assign(least.size(), 0);
  cuts_.back() = planes;
  for (int r = 1; r < ranks; ++r) {
    const auto k = static_cast<std::size_t>(r);
    const LocalId low = std::max(least[k], cuts_[k - 1] + 1);
    const LocalId most = cut_at(before, before[static_cast<std::size_t>(cuts_[k - 1])] + largest);
    const LocalId high = std::max(low, std::min(most, planes - (ranks - r)));
    cuts_[k] = std::clamp(nearest_cut(before, before.back() * r / ranks), low, high);
  }
}

Real Slabs::imbalance(std::span<const Real> weights) const {
  std::vector<Real> before(weights.size() + 1, 0.0);
  std::partial_sum(weights.begin(), weights.end(), before.begin() + 1);
  return before.back() > 0 ? heaviest(before, cuts_) * ranks() / before.back() : 1;
}

Real Slabs::cells(int rank, LocalId cells_per_plane) const {
  return static_cast<Real>(end_plane(rank) - first_plane(rank) + 2) * cells_per_plane;
}

bool Slabs::cells_fit(LocalId cells_per_plane) const {
  for (int r = 0; r < ranks(); ++r) {
    if (cells(r, cells_per_plane) > max_counted) return false;
  }
  return true;
}

void Slabs::check_capacity(std::span<const Real> weights, LocalId cells_per_plane, std::size_t record_bytes) const {
  for (int r = 0; r < ranks(); ++r) {
    const auto first = static_cast<std::size_t>(std::max(first_plane(r) - 1, 0));
    const auto last = std::min(static_cast<std::size_t>(end_plane(r)) + 1, weights.size());
    const Real particles = std::accumulate(weights.begin() + static_cast<std::ptrdiff_t>(first),
                                           weights.begin() + static_cast<std::ptrdiff_t>(last), 0.0);
    const Real cells_of_rank = cells(r, cells_per_plane);
    if (particles <= max_counted && cells_of_rank <= max_counted) continue;
    throw InputError(
        fmt::format("rank {} of {} would hold {:.0f} particles and {:.0f} cells, where 2e9 can be counted; "
                    "use more ranks",
                    r, ranks(), particles, cells_of_rank));
  }
  check_messages(weights, cells_per_plane, record_bytes);
}

// The largest messages: the records of a plane's particles, or one number of the coarse grid for each of its cells.
void Slabs::check_messages(std::span<const Real> weights, LocalId cells_per_plane, std::size_t record_bytes) const {
  for (int r = 1; r < ranks(); ++r) {
    for (const LocalId plane : {first_plane(r) - 1, first_plane(r)}) {
      const Real records = weights[static_cast<std::size_t>(plane)] * static_cast<Real>(record_bytes);
      const Real bytes = std::max(records, static_cast<Real>(cells_per_plane) * sizeof(Real));
      if (bytes < max_message_bytes) continue;
      throw InputError(
          fmt::format("cell plane {} at a cut between two ranks would have {:.3g} GB to send, where a message holds 2; "
                      "use another [domain] slab_axis or a single rank",
                      plane, bytes / 1e9));
    }
  }
}

int Slabs::owner(LocalId plane) const {
  return static_cast<int>(std::upper_bound(cuts_.begin(), cuts_.end(), plane) - cuts_.begin()) - 1;
}

}  // namespace trevi
