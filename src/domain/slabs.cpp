#include "domain/slabs.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

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

// The first plane before `end` with at least this weight in the planes before it. The search goes downwards from `end`
// in strides that double, because a rank has few of all planes.
LocalId first_within(std::span<const Real> before, LocalId end, Real weight) {
  LocalId last = end, stride = 1;
  while (last > 0 && before[static_cast<std::size_t>(std::max(last - stride, 0))] >= weight) {
    last = std::max(last - stride, 0);
    stride *= 2;
  }
  const auto first = before.begin() + std::max(last - stride, 0);
  return static_cast<LocalId>(std::lower_bound(first, before.begin() + last, weight) - before.begin());
}

// The lowest cuts with at most the weight `largest` on each rank except the first, as far as at least one plane per
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

std::vector<LocalId> even_cuts(std::span<const Real> weights, int parts) {
  const auto count = static_cast<LocalId>(weights.size());
  std::vector<Real> before(weights.size() + 1, 0.0);  // weight of all before this one
  std::partial_sum(weights.begin(), weights.end(), before.begin() + 1);
  // By bisection down to rounding. The result is at least the mean and exceeds it by at most one weight.
  const Real mean = before.back() / parts, heaviest_one = *std::max_element(weights.begin(), weights.end());
  constexpr Real rounding = 1e-13;
  Real impossible = std::max(mean, heaviest_one) * (1 - rounding), largest = before.back();
  for (Real middle = (mean + heaviest_one) * (1 + rounding); largest - impossible > rounding * largest;) {
    (heaviest(before, min_cuts(before, parts, middle)) <= middle ? largest : impossible) = middle;
    middle = (impossible + largest) / 2;
  }
  // Among the cuts with no larger weight, those nearest to an equal division.
  const std::vector<LocalId> least = min_cuts(before, parts, largest);
  std::vector<LocalId> cuts(least.size(), 0);
  cuts.back() = count;
  for (int r = 1; r < parts; ++r) {
    const auto k = static_cast<std::size_t>(r);
    const LocalId low = std::max(least[k], cuts[k - 1] + 1);
    const LocalId most = cut_at(before, before[static_cast<std::size_t>(cuts[k - 1])] + largest);
    const LocalId high = std::max(low, std::min(most, count - (parts - r)));
    cuts[k] = std::clamp(nearest_cut(before, before.back() * r / parts), low, high);
  }
  return cuts;
}

Slabs::Slabs(std::span<const Real> weights, int slabs) {
  const auto planes = static_cast<LocalId>(weights.size());
  if (slabs > planes) {
    throw InputError("the box has " + std::to_string(planes) + " cell planes along the slab axis, fewer than the " +
                     std::to_string(slabs) + " ranks; use at most " + std::to_string(planes) +
                     " ranks, cuts inside slabs ([domain] ranks = \"auto\"), another [domain] slab_axis, or a smaller "
                     "kernel_radius");
  }
  cuts_.planes = even_cuts(weights, slabs);
  for (int k = 0; k < slabs; ++k) cuts_.rows.insert(cuts_.rows.end(), {0, 1});
}

void Slabs::set_rows(std::vector<LocalId> rows, int parts) {
  cuts_.rows = std::move(rows);
  cuts_.parts = parts;
}

Real Slabs::imbalance(std::span<const Real> weights) const {
  std::vector<Real> before(weights.size() + 1, 0.0);
  std::partial_sum(weights.begin(), weights.end(), before.begin() + 1);
  return before.back() > 0 ? heaviest(before, cuts_.planes) * slabs() / before.back() : 1;
}

Real Slabs::cells(int rank, LocalId rows, LocalId columns) const {
  const CellWindow own = window(rank, rows);
  const LocalId ghost_rows = parts() == 1 ? 0 : 2;
  return static_cast<Real>(own.planes.size() + 2) * (own.rows.size() + ghost_rows) * columns;
}

bool Slabs::cells_fit(LocalId rows, LocalId columns) const {
  for (int r = 0; r < ranks(); ++r) {
    if (cells(r, rows, columns) > max_counted) return false;
  }
  return true;
}

void Slabs::check_capacity(std::span<const Real> weights, const std::array<LocalId, 2>& rows_and_columns,
                           Real bytes_of_particle) const {
  for (int r = 0; r < ranks(); ++r) {
    const auto first = static_cast<std::size_t>(std::max(first_plane(r) - 1, 0));
    const auto last = std::min(static_cast<std::size_t>(end_plane(r)) + 1, weights.size());
    const Real particles = std::accumulate(weights.begin() + static_cast<std::ptrdiff_t>(first),
                                           weights.begin() + static_cast<std::ptrdiff_t>(last), 0.0) /
                           parts();
    const Real cells_of_rank = cells(r, rows_and_columns[0], rows_and_columns[1]);
    if (particles <= max_counted && cells_of_rank <= max_counted) continue;
    throw InputError(
        fmt::format("rank {} of {} would hold {:.0f} particles and {:.0f} cells, where 2e9 can be counted; "
                    "use more ranks",
                    r, ranks(), particles, cells_of_rank));
  }
  check_messages(weights, rows_and_columns, bytes_of_particle);
}

// The largest messages: the data of its particles that a plane sends, or one number of the coarse grid per cell.
void Slabs::check_messages(std::span<const Real> weights, const std::array<LocalId, 2>& rows_and_columns,
                           Real bytes_of_particle) const {
  const Real cells_per_plane = static_cast<Real>(rows_and_columns[0]) * rows_and_columns[1];
  for (int k = 1; k < slabs(); ++k) {
    const LocalId cut = cuts_.planes[static_cast<std::size_t>(k)];
    for (const LocalId plane : {cut - 1, cut}) {
      const Real of_particles = weights[static_cast<std::size_t>(plane)] * bytes_of_particle;
      const Real bytes = std::max(of_particles, cells_per_plane * sizeof(Real)) / parts();
      if (bytes < max_message_bytes) continue;
      throw InputError(
          fmt::format("cell plane {} at a cut between two ranks would have {:.3g} GB to send, where a message holds 2; "
                      "use another [domain] slab_axis or a single rank",
                      plane, bytes / 1e9));
    }
  }
}

int Slabs::slab_of(LocalId plane) const {
  return static_cast<int>(std::upper_bound(cuts_.planes.begin(), cuts_.planes.end(), plane) - cuts_.planes.begin()) - 1;
}

int Slabs::owner(LocalId plane, LocalId row) const {
  const int slab = slab_of(plane);
  if (parts() == 1) return slab;
  const auto first = cuts_.rows.begin() + std::ptrdiff_t{slab} * (parts() + 1);
  return slab * parts() + static_cast<int>(std::upper_bound(first, first + parts(), row) - first) - 1;
}

}  // namespace trevi
