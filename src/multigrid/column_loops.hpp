// Vectorised loops over the cells of a column in which cells do not depend on each other, with the same operations on
// every processor. Pointers are to the lowest cell. Not collective, on this thread.
#pragma once

#include <cstddef>

#include "trevi/types.hpp"

namespace trevi {

/// Fields at the cells of a column, and the distances to the next row and to the next plane.
struct ColumnOfLevel {
  const Real *x, *wx, *wy, *rhs;
  std::size_t row, plane, count;
};

/// y = rhs plus the contributions of the four sides, by the links wx and wy of their lower faces.
void gather_sides(const ColumnOfLevel& of, Real* y);
/// Vertical links of lower faces, Dirichlet diagonals, and a field that is positive in water.
struct LinksUpwards {
  const Real *wz, *dirichlet, *per;
};
/// y = the residual of x in water, otherwise 0.
void find_residual_of(const ColumnOfLevel& of, const LinksUpwards& up, Real* y);
/// y = x + weight (y − x).
void damp(const Real* x, Real weight, std::size_t count, Real* y);
/// y += x in water.
void add_where_water(const Real* x, const Real* per, std::size_t count, Real* y);

}  // namespace trevi
