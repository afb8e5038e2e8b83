// Uses the sums of a pair loop while they are in the first-level cache: the range is processed in chunks, several of
// them in each part that one thread does.
#pragma once

#include <algorithm>
#include <array>
#include <tuple>

#include "base/threads.hpp"

namespace trevi {

/// Number of particles whose sums are used at a time.
inline constexpr LocalId sums_chunk = 128;

/// loop(here, sums of each type...) fills the sums of a few particles, and use(here, sums...) is then called for them:
/// those of particle here.begin + k are the k-th.
template <class... Sums, class Loop, class Use>
void for_each_sum(Range range, const Loop& loop, const Use& use) {
  constexpr LocalId chunk = sums_chunk, chunks_of_a_part = 4;
  for_each_part(range, chunks_of_a_part * chunk, [&](Range part) {
    std::tuple<std::array<Sums, chunk>...> sums;
    for (LocalId begin = part.begin; begin < part.end; begin += chunk) {
      const Range here{begin, std::min(begin + chunk, part.end)};
      std::apply(
          [&](auto&... sum) {
            loop(here, sum.data()...);
            use(here, sum.data()...);
          },
          sums);
    }
  });
}

}  // namespace trevi
