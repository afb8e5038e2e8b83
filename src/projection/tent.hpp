// Sums over a cell and the 26 around it with the weights 1, 1/2 of a tent along each axis, row by row of cells: first
// over the 3 x 3 rows around, then along the row. The order of the additions is that of the cells: the same bits on any
// ranks and threads. Of cells beyond a wall there is nothing; where the box repeats they are those at its other end, and
// ghost planes must have come; values beyond a row's own columns must be empty. Not collective.
#pragma once

#include <vector>

#include "projection/grid.hpp"
#include "projection/parameters.hpp"

namespace trevi {

/// use(c, sum) for the cells of row (k, r). `get(at)` is the value of a cell, which has add(from, weight, z).
template <class T, class Get, class Use>
void for_each_tent(const ProjectionGrid& grid, LocalId k, LocalId r, std::vector<T>& memory, const Get& get,
                   const Use& use) {
  const LocalId columns = grid.columns(k, r), rows = grid.rows(), count = std::min(columns + 1, grid.columns());
  memory.assign(static_cast<std::size_t>(columns) + 2, T{});
  const bool repeats = grid.repeats()[1];
  ByAxis z{};
  for (LocalId dk = -1; dk <= 1; ++dk) {
    for (LocalId dr = -1; dr <= 1; ++dr) {
      if (!repeats && (r + dr < 0 || r + dr >= rows)) continue;
      const LocalId row = (r + dr + rows) % rows;
      z[grid.axis(0)] = dk;
      z[grid.axis(1)] = dr;
      const Real weight = (dk != 0 ? projection::tent : 1) * (dr != 0 ? projection::tent : 1);
      const std::size_t at = grid.index(k + dk, row, 0);
      for (LocalId c = 0; c < count; ++c)
        memory[static_cast<std::size_t>(c) + 1].add(get(at + static_cast<std::size_t>(c)), weight, z);
    }
  }
  if (grid.repeats()[2]) {
    memory.front() = memory[static_cast<std::size_t>(columns)];
    memory.back() = memory[1];
  }
  for (LocalId c = 0; c < columns; ++c) {
    const auto i = static_cast<std::size_t>(c);
    T sum = memory[i + 1];
    sum.add(memory[i], projection::tent, {0, 0, -1});
    sum.add(memory[i + 2], projection::tent, {0, 0, 1});
    use(c, sum);
  }
}

}  // namespace trevi
