// Loops over the cells of a column that do not wait for each other, in vectors, in the same operations on every
// processor. Pointers are to the lowest cell. Not collective, on this thread.
#pragma once

#include <cstddef>

#include "trevi/types.hpp"

namespace trevi {

/// A field at the cells of a column, and how far it is to the next row and to the next plane.
struct ColumnOfLevel {
  const Real *x, *wx, *wy, *rhs;
  std::size_t row, plane, count;
};

/// y = rhs and what comes from the four sides, by the links wx and wy of their lower faces.
void gather_sides(const ColumnOfLevel& of, Real* y);
/// Links of lower faces upwards, Dirichlet diagonals, and what is positive in water.
struct LinksUpwards {
  const Real *wz, *dirichlet, *per;
};
/// y = rhs less what x gives in water, else 0.
void find_residual_of(const ColumnOfLevel& of, const LinksUpwards& up, Real* y);
/// y = x + weight (y − x).
void damp(const Real* x, Real weight, std::size_t count, Real* y);
/// y += x in water.
void add_where_water(const Real* x, const Real* per, std::size_t count, Real* y);

}  // namespace trevi
