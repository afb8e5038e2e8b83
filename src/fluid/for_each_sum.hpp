// Uses the sums of a pair loop while they are in the first-level cache: the range is worked on in chunks.
#pragma once

#include <algorithm>
#include <array>
#include <tuple>

#include "particles/cell_order.hpp"

namespace trevi {

/// loop(part, sums of each type...) fills the sums of a part of the range; use(i, sum...) is then called for each
/// particle of it.
template <class... Sums, class Loop, class Use>
void for_each_sum(Range range, Loop&& loop, Use&& use) {
  constexpr LocalId chunk = 128;
  std::tuple<std::array<Sums, chunk>...> sums;
  for (LocalId begin = range.begin; begin < range.end; begin += chunk) {
    const Range part{begin, std::min(begin + chunk, range.end)};
    std::apply(
        [&](auto&... sum) {
          loop(part, sum.data()...);
          for (std::size_t k = 0; k < static_cast<std::size_t>(part.size()); ++k)
            use(static_cast<std::size_t>(begin) + k, sum[k]...);
        },
        sums);
  }
}

}  // namespace trevi
