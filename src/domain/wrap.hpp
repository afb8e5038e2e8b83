// Positions in a box that is periodic along some axes. Not collective.
#pragma once

#include <array>
#include <cmath>

#include "trevi/box.hpp"

namespace trevi {

class Wrap {
 public:
  Wrap(const Box& box, const std::array<bool, 3>& periodic) : min_(box.min) {
    for (int a = 0; a < 3; ++a) {
      if (periodic[static_cast<std::size_t>(a)]) length_[a] = box.max[a] - box.min[a];
    }
  }
  /// What brings p back into the box: whole lengths of it, along the periodic axes.
  Vec3 back(const Vec3& p) const {
    Vec3 way = Vec3::Zero();
    for (int a = 0; a < 3; ++a) {
      if (length_[a] > 0) way[a] = -std::floor((p[a] - min_[a]) / length_[a]) * length_[a];
    }
    return way;
  }

 private:
  Vec3 min_, length_ = Vec3::Zero();  // length 0: not periodic
};

}  // namespace trevi
