// Positions in a box that is periodic along some axes. There they are multiples of a power of two, the quantum, and so
// are the box and the width of its cells: sums and differences of positions are exact, and a flow that starts some
// planes further on is the same to the bit. The quantum is some 1e-14 of the box. Not collective.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>

#include "trevi/box.hpp"

namespace trevi {

class Wrap {
 public:
  /// The box with ends on the quantum, a whole number of cells at least h wide between them; at most as much larger.
  static Box fitted(const Box& box, const std::array<bool, 3>& periodic, Real h) {
    const Real q = quantum(box);
    Box fitted = box;
    for (int a = 0; a < 3; ++a) {
      if (!periodic[static_cast<std::size_t>(a)]) continue;
      const Real min = std::floor(box.min[a] / q) * q, cells = std::round((box.max[a] - box.min[a]) / h);
      fitted.min[a] = min;
      fitted.max[a] = min + cells * (std::ceil(std::max(h, (box.max[a] - min) / cells) / q) * q);
    }
    return fitted;
  }

  /// `box` as fitted() has made it.
  Wrap(const Box& box, const std::array<bool, 3>& periodic) : min_(box.min) {
    for (int a = 0; a < 3; ++a) {
      if (!periodic[static_cast<std::size_t>(a)]) continue;
      length_[a] = box.max[a] - box.min[a];
      endless_[a] = 1;
      rounding_[a] = 0x1.8p52 * quantum(box);
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
  /// The nearest multiples of the quantum along the periodic axes; v along others.
  Vec3 rounded(const Vec3& v) const { return Vec3(v + rounding_) - rounding_; }
  /// p without its coordinates along the periodic axes: ways are worked out from there.
  Vec3 without_place(const Vec3& p) const { return p - place(p); }
  /// From p to where `target` is, seen from without_place(p).
  Vec3 moved(const Vec3& p, const Vec3& target) const { return place(p) + rounded(target); }
  /// The same for a target that is seen from the box.
  Vec3 moved_to(const Vec3& p, const Vec3& target) const { return moved(p, target - place(p)); }

 private:
  // Coordinates in the box have 46 bits, so that there is room for sums. What fitted() adds to the box does not change
  // it.
  static Real quantum(const Box& box) {
    const Real largest = box.min.cwiseAbs().cwiseMax(box.max.cwiseAbs()).maxCoeff();
    return std::ldexp(1.0, std::ilogb(largest / 1.9) + 2 - 46);
  }
  Vec3 place(const Vec3& p) const { return p.cwiseProduct(endless_); }

  Vec3 min_, length_ = Vec3::Zero();  // length 0: not periodic
  Vec3 endless_ = Vec3::Zero();       // 1 along periodic axes
  Vec3 rounding_ = Vec3::Zero();      // adding and subtracting it rounds to the quantum
};

}  // namespace trevi
