// The closed box that holds the water, metres. Plain data.
#pragma once

#include "trevi/types.hpp"

namespace trevi {

struct Box {
  Vec3 min = Vec3::Zero(), max = Vec3::Zero();
  bool operator==(const Box&) const = default;
};

}  // namespace trevi
