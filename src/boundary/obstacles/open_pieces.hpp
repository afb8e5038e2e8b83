// Parts of the particles beside obstacles and the boxes in which they meet none. Not collective.
#pragma once

#include <algorithm>

#include "base/range.hpp"
#include "trevi/types.hpp"

namespace trevi {

/// visit(open, piece): for all of a part with open_to(part), their open_box(), where it does not lie around an
/// obstacle; else piece by piece, as most of them do not.
template <class OpenTo, class Visit>
void for_each_open_piece(Range part, const OpenTo& open_to, const Visit& visit) {
  constexpr LocalId piece = 16;
  const Box open = open_to(part);
  if (part.size() <= piece || !(open.min.array() > open.max.array()).any()) return visit(open, part);
  for (LocalId begin = part.begin; begin < part.end; begin += piece) {
    const Range some{begin, std::min(begin + piece, part.end)};
    visit(open_to(some), some);
  }
}

}  // namespace trevi
