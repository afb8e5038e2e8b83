// A contiguous range of particles, or of other things that a rank numbers.
#pragma once

#include "trevi/types.hpp"

namespace trevi {

/// [begin, end); owned particles are numbered without ghosts.
struct Range {
  LocalId begin = 0, end = 0;
  LocalId size() const { return end - begin; }
};

}  // namespace trevi
