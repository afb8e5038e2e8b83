// A run of particles, or of other things that a rank counts.
#pragma once

#include "trevi/types.hpp"

namespace trevi {

/// [begin, end); owned particles are counted without ghosts.
struct Range {
  LocalId begin = 0, end = 0;
  LocalId size() const { return end - begin; }
};

}  // namespace trevi
