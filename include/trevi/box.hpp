// The closed box that holds the water, metres. Plain data.
#pragma once

#include "trevi/types.hpp"

namespace trevi {

struct Box {
  Vec3 min = Vec3::Zero(), max = Vec3::Zero();
  /// Surface included; false for a NaN.
  bool contains(const Vec3& p) const { return (p.array() >= min.array()).all() && (p.array() <= max.array()).all(); }
  /// Whether they share a place.
  bool meets(const Box& other) const {
    return (other.max.array() >= min.array()).all() && (other.min.array() <= max.array()).all();
  }
  bool operator==(const Box&) const = default;
};

}  // namespace trevi
