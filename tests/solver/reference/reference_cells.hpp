// The cells of the reference's coarse grid and values in them. Cells are counted along x, y and z. Not collective.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cmath>
#include <vector>

#include "trevi/types.hpp"

namespace trevi::test {

using Cell = Eigen::Vector3i;

/// The cells of a box that may repeat along some axes.
struct Cells {
  Cell count;
  std::array<bool, 3> periodic;

  bool repeats(int a) const { return periodic[static_cast<std::size_t>(a)]; }
  Cell wrapped(Cell c) const {
    for (int a = 0; a < 3; ++a)
      if (repeats(a)) c[a] = (c[a] + count[a]) % count[a];
    return c;
  }
  /// In cells, to the nearest image.
  Real way(int a, Real to, Real from) const {
    return to - from - (repeats(a) ? count[a] * std::round((to - from) / count[a]) : 0);
  }
};

/// A value for each cell of the box and a ring of one around it.
template <class T>
class CellArray {
 public:
  CellArray(const Cells& cells, const T& value)
      : cells_(cells), size_(cells.count + Cell::Constant(2)), values_(static_cast<std::size_t>(size_.prod()), value) {}
  T& operator[](const Cell& c) { return values_[place(c)]; }
  const T& operator[](const Cell& c) const { return values_[place(c)]; }

 private:
  std::size_t place(const Cell& at) const {
    const Cell c = cells_.wrapped(at);
    return static_cast<std::size_t>(((c.x() + 1) * size_.y() + c.y() + 1) * size_.z() + c.z() + 1);
  }
  Cells cells_;
  Cell size_;
  std::vector<T> values_;
};

}  // namespace trevi::test
