// Cubic interpolation between the nodes of a grid (Catmull & Rom, 1974), in vectors of four nodes, with the same bits
// on every instruction set. Not collective.
#pragma once

#include <cmath>
#include <cstddef>

#include "trevi/types.hpp"

namespace trevi {

/// A value and its slope, by intervals between nodes.
struct SplineValue {
  Real value;
  Vec3 slope;
};

/// The values of 4³ nodes: those along x one after the other, rows and planes of them so far apart.
struct SplineNodes {
  const Real* first;
  std::size_t row, plane;
};

/// At t from the second node to the third along each axis, 0 to 1. Where the value is at least `flat` no slope is told.
SplineValue interpolate(const SplineNodes& nodes, const Vec3& t, Real flat = INFINITY);

}  // namespace trevi
