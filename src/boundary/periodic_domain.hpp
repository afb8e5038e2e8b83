// Positions in a box that is periodic along some axes. Along these, positions, the box and the width of its cells are
// multiples of a power of two, the quantum, so that sums and differences of positions are exact. Cells are counted from
// the one in which the particle with the smallest id was at the start, so that a flow that starts some planes further
// on is bitwise the same, whatever depends on their order. Within a step positions are in the period that begins there;
// between steps they are in the box. The quantum is about 1e-14 of the box. Not collective.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>

#include "trevi/box.hpp"

namespace trevi {

class PeriodicDomain {
 public:
  /// The box with its ends on the quantum and a whole number of cells between them, each at least h wide; it is
  /// enlarged by no more than this requires.
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

  /// `box`, as returned by fitted(), moved on by this number of cells.
  static Box turned(const Box& box, Real h, const std::array<LocalId, 3>& cells) {
    Box turned = box;
    for (int a = 0; a < 3; ++a) {
      const Real length = box.max[a] - box.min[a], cell = cells[static_cast<std::size_t>(a)];
      if (cell == 0) continue;
      turned.min[a] += cell * (length / std::round(length / h));
      turned.max[a] = turned.min[a] + length;
    }
    return turned;
  }

  /// `box` as returned by fitted(); `first`: where the count of cells begins, as returned by turned().
  PeriodicDomain(const Box& box, const std::array<bool, 3>& periodic, const Vec3& first)
      : min_(box.min), first_(first) {
    for (int a = 0; a < 3; ++a) {
      if (!periodic[static_cast<std::size_t>(a)]) continue;
      length_[a] = box.max[a] - box.min[a];
      endless_[a] = 1;
      rounding_[a] = 0x1.8p52 * quantum(box);
    }
  }
  /// The displacement that brings p back into the box: whole periods along the periodic axes.
  Vec3 back(const Vec3& p) const { return into(min_, p); }
  /// The displacement that brings p into the period that begins at the first cell.
  Vec3 in_order(const Vec3& p) const { return into(first_, p); }
  /// The nearest multiples of the quantum along the periodic axes; v along the others.
  Vec3 rounded(const Vec3& v) const { return Vec3(v + rounding_) - rounding_; }
  /// p without its coordinates along the periodic axes: displacements are computed from there.
  Vec3 without_place(const Vec3& p) const { return p - place(p); }
  /// The position reached from p if `target` is the position reached from without_place(p).
  Vec3 moved(const Vec3& p, const Vec3& target) const { return place(p) + rounded(target); }
  /// The same for a target in the coordinates of the box.
  Vec3 moved_to(const Vec3& p, const Vec3& target) const { return moved(p, target - place(p)); }

 private:
  // Coordinates in the box have 46 bits, which leaves room for sums. The enlargement by fitted() does not change the
  // quantum.
  static Real quantum(const Box& box) {
    const Real largest = box.min.cwiseAbs().cwiseMax(box.max.cwiseAbs()).maxCoeff();
    return std::ldexp(1.0, std::ilogb(largest / 1.9) + 2 - 46);
  }
  Vec3 place(const Vec3& p) const { return p.cwiseProduct(endless_); }
  Vec3 into(const Vec3& min, const Vec3& p) const {
    Vec3 displacement = Vec3::Zero();
    for (int a = 0; a < 3; ++a) {
      if (length_[a] > 0) displacement[a] = -std::floor((p[a] - min[a]) / length_[a]) * length_[a];
    }
    return displacement;
  }

  Vec3 min_, first_, length_ = Vec3::Zero();  // length 0: not periodic
  Vec3 endless_ = Vec3::Zero();               // 1 along periodic axes
  Vec3 rounding_ = Vec3::Zero();              // adding and subtracting it rounds to the quantum
};

}  // namespace trevi
