#include "projection/probe_pressures.hpp"

#include <algorithm>
#include <cmath>

namespace trevi {

namespace {

struct Sum {
  Real phi = 0, weight = 0;
};

// Of the row (k, r), at a height given in cells from the floor.
Sum sum_at(const FreeSurface& surface, const Pressure& pressure, Real g_dt2, std::pair<LocalId, LocalId> row,
           Real height) {
  const ProjectionGrid& grid = surface.grid();
  const Real from_middle = height - 0.5;
  const auto below = static_cast<LocalId>(std::floor(from_middle));
  Sum sum;
  for (LocalId c = std::max(below, 0); c <= below + 1 && c < grid.columns(row.first, row.second); ++c) {
    const std::size_t at = grid.index(row.first, row.second, c);
    if (!surface.is_wet(at) || surface.is_solid(at)) continue;
    const Real part = 1 - std::abs(from_middle - c);
    sum.phi += part * (pressure.phi(at) - g_dt2 * grid.size()[2] * (c - from_middle));
    sum.weight += part;
  }
  return sum;
}

// The number of a cell along direction a that may lie beyond the ends of the box.
LocalId in_box(const ProjectionGrid& grid, std::size_t a, LocalId cell) {
  const LocalId count = grid.count(a);
  return grid.repeats()[a] ? (cell + count) % count : std::clamp(cell, 0, count - 1);
}

}  // namespace

// On the grid phi is negative where there is pressure; in a splash it may have any value.
void probe_pressures(const FreeSurface& surface, const Pressure& pressure, Real g_dt2, PressureProbes& probes) {
  const ProjectionGrid& grid = surface.grid();
  for (std::size_t n = 0; n < probes.count(); ++n) {
    const Vec3& place = probes.place(n);
    const Real height = grid.cells_to(place, 2), x = grid.cells_to(place, 0) - 0.5, y = grid.cells_to(place, 1) - 0.5;
    const auto first_x = static_cast<LocalId>(std::floor(x)), first_y = static_cast<LocalId>(std::floor(y));
    for (LocalId i = first_x; i <= first_x + 1; ++i) {
      const LocalId k = grid.own_plane(in_box(grid, 0, i));
      if (k < 1 || k > grid.planes()) continue;
      for (LocalId j = first_y; j <= first_y + 1; ++j) {
        const Real part = (1 - std::abs(x - i)) * (1 - std::abs(y - j));
        const LocalId r = grid.own_row(in_box(grid, 1, j));
        if (r < 0 || r >= grid.rows()) continue;
        const Sum sum = sum_at(surface, pressure, g_dt2, {k, r}, height);
        if (sum.weight > 0) probes.add(n, part * sum.weight, -std::min(sum.phi / sum.weight, 0.0));
      }
    }
  }
}

}  // namespace trevi
