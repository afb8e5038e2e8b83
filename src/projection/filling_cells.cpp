#include "projection/filling_cells.hpp"

#include <algorithm>

namespace trevi {

using namespace projection;

void FillingCells::reset(const ProjectionGrid& grid) {
  rows_of_plane_ = grid.rows();
  rows_.resize(row_index(grid.planes() + 1, 0));
  for (std::vector<Filling>& row : rows_) row.clear();
}

// What the weight alone brings in a step is not left out, so that water at rest keeps its pressure. Nor is it in the
// top cells of open water, whose divergence tells how their level changes.
Real FillingCells::without_filling(const FreeSurface& surface, Real g_dt2, LocalId k, LocalId r, LocalId c, Real flow) {
  const std::size_t at = surface.grid().index(k, r, c);
  const bool cut = surface.is_cut(at), at_rest = cut && !surface.cuts()->floats(at);
  const Real slow = -(at_rest ? by_weight_at_rest : by_weight) * g_dt2 / surface.grid().size()[2];
  if (flow >= slow || surface.is_solid(at) || (surface.is_top(at) && !cut)) return flow;
  const Real room = surface.open(at) * std::max(full_enough - surface.fill(at), 0.0);
  if (room == 0) return flow;
  if (at_rest) rows_[row_index(k, r)].push_back({c, std::min(room / (slow - flow), 1.0)});
  return std::min(flow + room, slow);
}

Real FillingCells::share(LocalId k, LocalId r, LocalId c) const {
  const std::vector<Filling>& row = rows_[row_index(k, r)];
  const auto found = std::lower_bound(row.begin(), row.end(), c,
                                      [](const Filling& one, LocalId column) { return one.column < column; });
  return found != row.end() && found->column == c ? found->share : 0;
}

std::size_t FillingCells::bytes() const {
  std::size_t sum = rows_.capacity() * sizeof(rows_[0]);
  for (const std::vector<Filling>& row : rows_) sum += row.capacity() * sizeof(Filling);
  return sum;
}

}  // namespace trevi
