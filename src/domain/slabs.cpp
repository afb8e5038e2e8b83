#include "trevi/domain/slabs.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "trevi/base/error.hpp"

namespace trevi {

Slabs::Slabs(std::span<const Real> weights, int ranks) {
  const auto planes = static_cast<LocalId>(weights.size());
  if (ranks > planes) {
    throw InputError("the box has " + std::to_string(planes) + " cell planes along the slab axis, fewer than the " +
                     std::to_string(ranks) + " ranks; use at most " + std::to_string(planes) +
                     " ranks, another [domain] slab_axis, or a smaller kernel_radius");
  }
  std::vector<Real> before(weights.size() + 1, 0.0);  // weight of all planes before this one
  std::partial_sum(weights.begin(), weights.end(), before.begin() + 1);
  cuts_.assign(static_cast<std::size_t>(ranks) + 1, 0);
  cuts_.back() = planes;
  for (int r = 1; r < ranks; ++r) {
    const Real target = before.back() * r / ranks;
    auto cut = static_cast<LocalId>(std::lower_bound(before.begin(), before.end(), target) - before.begin());
    if (cut > 0 && target - before[static_cast<std::size_t>(cut) - 1] < before[static_cast<std::size_t>(cut)] - target)
      --cut;
    cuts_[static_cast<std::size_t>(r)] = std::clamp(cut, first_plane(r - 1) + 1, planes - (ranks - r));
  }
}

int Slabs::owner(LocalId plane) const {
  return static_cast<int>(std::upper_bound(cuts_.begin(), cuts_.end(), plane) - cuts_.begin()) - 1;
}

}  // namespace trevi
