// Cubic interpolation between the nodes of a grid (Catmull & Rom, 1974), in vectors of four nodes, with the same bits
// on every instruction set. Not collective.
#pragma once

#include <cmath>
#include <cstddef>

#include "trevi/types.hpp"

namespace trevi {

/// A value and its slope, per interval between nodes.
struct SplineValue {
  Real value;
  Vec3 slope;
};

/// The values of 4³ nodes: those along x are contiguous; `row` and `plane` are the strides of rows and planes.
struct SplineNodes {
  const Real* first;
  std::size_t row, plane;
};

/// At t from the second node to the third along each axis, 0 to 1. No slope is computed if the value is at least
/// `flat`.
SplineValue interpolate(const SplineNodes& nodes, const Vec3& t, Real flat = INFINITY);

}  // namespace trevi
