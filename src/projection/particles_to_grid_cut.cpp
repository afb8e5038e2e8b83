// Faces without particles on either side. A cell may hold no particle although it counts as water: in a corner of a
// piece of water in flight, or where a solid leaves open a part of a cell (free_surface_cut.cpp), because a lattice
// leaves out what is within half a spacing of a curved wall. A face between two such cells moves as given by the fits
// of the surrounding cells. As long as such faces stood still, water that moved as a whole had a divergence there:
// water in a cylinder of R = 10 spacings was slowed down by an eighth in the first turn, and particles of blocks thrown
// obliquely were kicked by 1 m/s.
#include "projection/particles_to_grid.hpp"

#include <algorithm>

namespace trevi {

void ParticlesToGrid::displace_empty_face(const EmptyFace& face, const CutCells* cuts) {
  const auto& [a, at, above, below] = face;
  ByAxis middle = cuts != nullptr ? cuts->middle_of_face(a, at) : ByAxis{0.5, 0.5, 0.5};
  middle[grid_.axis(a)] = 0;
  ByAxis from_below = middle;
  from_below[grid_.axis(a)] = 1;
  FittedMean mean;
  add_fits_around(a, above, middle, mean);
  add_fits_around(a, below, from_below, mean);
  if (mean.weight > 0) displacement_[a][at] = mean.sum / mean.weight;
}

// Columns in which the faces between the cells of a row and those below them along `a` may have no particles on either
// side but some around them.
Range ParticlesToGrid::cells_without(std::size_t a, LocalId k, LocalId r) const {
  CellNumbers below{k, r, 0};
  if (a != 2) --below[a];
  if (!exists(below)) return {0, 0};
  LocalId highest = 0;
  for (LocalId i = std::max(below[0] - 1, 0); i <= std::min(k + 1, grid_.planes() + 1); ++i) {
    for (LocalId j = r - 1; j <= r + 1; ++j) {
      CellNumbers row{i, j, 0};
      if (exists(row)) highest = std::max(highest, filled(row[0], row[1]).end);
    }
  }
  const LocalId first = std::max(first_empty_[row_index(k, r)], first_empty_[row_index(below[0], below[1])]);
  return {first, grid_.repeats()[2] ? grid_.columns() : std::min(grid_.columns(k, r), highest + 1)};
}

// Whether there is such a cell. Where rows or columns repeat, its number becomes that of the cell at the other end of
// the box.
bool ParticlesToGrid::exists(CellNumbers& cell) const {
  cell[1] = grid_.row_beside(cell[1]);
  if (grid_.repeats()[2]) cell[2] = (cell[2] + grid_.columns()) % grid_.columns();
  const bool is_known = cell[1] >= -1 && cell[1] <= grid_.rows() && grid_.has_row(cell[1]);
  return is_known && cell[0] >= 0 && cell[0] <= grid_.planes() + 1 && cell[2] >= 0 && cell[2] < grid_.columns();
}

// Adds the values at a point of `cell`, in cells from its corner, of the fits of the four neighbours along the face.
void ParticlesToGrid::add_fits_around(std::size_t a, const CellNumbers& cell, const ByAxis& place,
                                      FittedMean& mean) const {
  for (std::size_t b = 0; b < 3; ++b) {
    if (b == a) continue;
    for (const LocalId side : {-1, 1}) {
      CellNumbers beside = cell;
      beside[b] += side;
      if (!exists(beside) || !holds_any(beside)) continue;
      const auto [k, r, c] = beside;
      ByAxis seen = place;
      seen[grid_.axis(b)] -= side;
      const Real n = sums_.number(0, k, r, c);
      mean.sum += n * fit_.cell<AffineMap>(k, r, c).at(grid_.axis(a), seen);
      mean.weight += n;
    }
  }
}

}  // namespace trevi
