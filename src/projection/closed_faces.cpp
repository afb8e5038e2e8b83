#include "projection/closed_faces.hpp"

#include <cassert>

namespace trevi {

void ClosedFaces::find(const FreeSurface& surface) {
  const ProjectionGrid& grid = surface.grid();
  rows_.resize(grid);
  for_each_row(grid.rows_of({1, grid.planes() + 1}), [&](LocalId k, LocalId r) { find_in_row(surface, k, r); });
}

void ClosedFaces::find_in_row(const FreeSurface& surface, LocalId k, LocalId r) {
  const ProjectionGrid& grid = surface.grid();
  const ParticlesToGrid& water = surface.water();
  std::vector<SparseRows::Entry>& known = rows_.begin_row(k, r);
  const LocalId columns = grid.columns(k, r);
  // Columns in which solids or drains may close a face; elsewhere only walls do.
  const Range near = surface.openings() != nullptr ? Range{0, columns}
                     : surface.cuts() != nullptr   ? surface.cuts()->columns_near_cut(k, r)
                                                   : Range{0, 0};
  for (LocalId c = 0; c < columns; ++c) {
    const std::size_t at = grid.index(k, r, c);
    if ((c < near.begin || c >= near.end) && !grid.is_at_wall(k, r, c)) continue;
    if (!surface.is_wet(at)) continue;
    if (!water.holds_any(k, r, c) && (c + 1 == columns || !water.holds_any(k, r, c + 1))) continue;
    for (std::size_t a = 0; a < 3; ++a) {
      for (const bool upper : {false, true}) {
        const CellFace face{a, upper};
        if ((a == 1 && grid.is_layer()) || !surface.is_closed(face, k, r, c)) continue;
        known.push_back({number_of(face, c), water.displacement(a, grid.index_of(face, at))});
      }
    }
  }
}

Real ClosedFaces::displacement(const CellFace& face, LocalId k, LocalId r, LocalId c) const {
  const Real* const known = rows_.find(k, r, number_of(face, c));
  assert(known != nullptr);
  return *known;
}

}  // namespace trevi
