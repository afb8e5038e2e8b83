// Sums over a cell and the 26 around it with the weights 1 and projection::tent along each axis, row by row of cells:
// first across the planes, then across the rows of the plane, then along the row. The order of the additions is that of
// the cells: the same bits on any ranks and threads. Of cells beyond a wall there is nothing; where the box repeats
// they are those at its other end, and ghost planes must have come; values beyond a row's own columns must be empty.
// Not collective.
#pragma once

#include <vector>

#include "projection/affine.hpp"
#include "projection/grid.hpp"

namespace trevi {

/// use(c, sum) for the cells of row (k, r) for which needed(at). `get(at)` is the value of a cell.
template <class T, class Needed, class Get, class Use>
void for_each_tent(const ProjectionGrid& grid, LocalId k, LocalId r, const Needed& needed, const Get& get,
                   const Use& use) {
  const LocalId rows = grid.rows();
  const std::size_t floor = grid.index(k, r, 0);
  LocalId columns = grid.columns(k, r);
  while (columns > 0 && !needed(floor + static_cast<std::size_t>(columns) - 1)) --columns;
  if (columns == 0) return;
  const bool repeats = grid.repeats()[2];
  if (repeats) columns = grid.columns();
  const LocalId count = std::min(columns + 1, grid.columns());
  static thread_local std::vector<T> across, sums;
  sums.assign(static_cast<std::size_t>(columns) + 2, T{});
  for (LocalId dr = -1; dr <= 1; ++dr) {
    if (!grid.repeats()[1] && (r + dr < 0 || r + dr >= rows)) continue;
    const LocalId row = (r + dr + rows) % rows;
    across.assign(static_cast<std::size_t>(count), T{});
    for (LocalId dk = -1; dk <= 1; ++dk) {
      const Beside by{dk != 0 ? projection::tent : 1, grid.axis(0), static_cast<Real>(dk)};
      const std::size_t at = grid.index(k + dk, row, 0);
      for (std::size_t c = 0; c < across.size(); ++c)
        if (const T& from = get(at + c); !is_empty(from)) add_beside(across[c], from, by);
    }
    const Beside by{dr != 0 ? projection::tent : 1, grid.axis(1), static_cast<Real>(dr)};
    for (std::size_t c = 0; c < across.size(); ++c)
      if (!is_empty(across[c])) add_beside(sums[c + 1], across[c], by);
  }
  if (repeats) {
    sums.front() = sums[static_cast<std::size_t>(columns)];
    sums.back() = sums[1];
  }
  for (LocalId c = 0; c < columns; ++c) {
    const auto i = static_cast<std::size_t>(c);
    if (!needed(floor + i)) continue;
    T sum = sums[i + 1];
    add_beside(sum, sums[i], {projection::tent, 2, -1});
    add_beside(sum, sums[i + 2], {projection::tent, 2, 1});
    use(c, sum);
  }
}

}  // namespace trevi
