// The closed box that holds the water; lengths are metres. Plain data.
#pragma once

#include "trevi/types.hpp"

namespace trevi {

struct Box {
  Vec3 min = Vec3::Zero(), max = Vec3::Zero();
  /// Whether p lies in the box or on its surface; false for a NaN.
  bool contains(const Vec3& p) const { return (p.array() >= min.array()).all() && (p.array() <= max.array()).all(); }
  /// Whether the two boxes have a point in common.
  bool meets(const Box& other) const {
    return (other.max.array() >= min.array()).all() && (other.min.array() <= max.array()).all();
  }
  bool operator==(const Box&) const = default;
};

}  // namespace trevi
