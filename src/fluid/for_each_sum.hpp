// Uses the sums of a pair loop while they are in the first-level cache: the range is worked on in chunks, several to a
// part that one thread does.
#pragma once

#include <algorithm>
#include <array>
#include <tuple>

#include "base/threads.hpp"

namespace trevi {

/// loop(part, sums of each type...) fills the sums of a part of the range; use(i, sum...) is then called for each
/// particle of it.
template <class... Sums, class Loop, class Use>
void for_each_sum(Range range, const Loop& loop, const Use& use) {
  constexpr LocalId chunk = 128, chunks_of_a_part = 4;
  for_each_part(range, chunks_of_a_part * chunk, [&](Range part) {
    std::tuple<std::array<Sums, chunk>...> sums;
    for (LocalId begin = part.begin; begin < part.end; begin += chunk) {
      const Range here{begin, std::min(begin + chunk, part.end)};
      std::apply(
          [&](auto&... sum) {
            loop(here, sum.data()...);
            for (std::size_t k = 0; k < static_cast<std::size_t>(here.size()); ++k)
              use(static_cast<std::size_t>(begin) + k, sum[k]...);
          },
          sums);
    }
  });
}

}  // namespace trevi
