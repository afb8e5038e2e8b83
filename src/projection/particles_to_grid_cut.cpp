// Faces beside obstacles. Where a solid leaves a part of a cell there may be no particle in it, though it counts as
// water (free_surface_cut.cpp): a lattice leaves out what is within half a spacing of a curved wall. A face between two
// such cells moves as the fits of the cells around say. As long as such faces stood still, water that turned had a
// divergence there, and pressure braked it: in a cylinder of R = 10 spacings by an eighth in the first turn.
#include <algorithm>

#include "projection/particles_to_grid.hpp"

namespace trevi {

void ParticlesToGrid::find_empty_faces(std::size_t a, LocalId k, LocalId r, const CutCells& cuts) {
  CellNumbers row_below{k, r, 0};
  --row_below[a];
  if (a != 2 && !exists(row_below)) return;
  const Range own = cuts.cut_columns(k, r), other = a == 2 ? own : cuts.cut_columns(row_below[0], row_below[1]);
  const Range cut = own.size() == 0     ? other
                    : other.size() == 0 ? own
                                        : Range{std::min(own.begin, other.begin), std::max(own.end, other.end)};
  if (cut.size() == 0) return;
  // Where columns repeat the lowest cell is beside the highest one.
  const LocalId columns = grid_.columns(k, r);
  const Range near = grid_.repeats()[2] ? Range{0, columns} : Range{cut.begin, std::min(cut.end + 1, columns)};
  for (LocalId c = near.begin; c < near.end; ++c) {
    const std::size_t at = grid_.index(k, r, c);
    if (cuts.face(a, at) == 0 || grid_.is_wall(a, k, r, c)) continue;
    if (cuts.open(at) == 1 && cuts.open(at - grid_.step(a)) == 1) continue;
    CellNumbers above{k, r, c}, below = above;
    --below[a];
    if (!exists(below) || holds_any(above) || holds_any(below)) continue;
    ByAxis middle = cuts.middle_of_face(a, at);
    middle[grid_.axis(a)] = 0;
    ByAxis from_below = middle;
    from_below[grid_.axis(a)] = 1;
    FittedMean mean;
    add_fits_around(a, above, middle, mean);
    add_fits_around(a, below, from_below, mean);
    if (mean.weight > 0) displacement_[a][at] = mean.sum / mean.weight;
  }
}

// Whether there is such a cell, whose number is made that of the other end of the box where rows repeat.
bool ParticlesToGrid::exists(CellNumbers& cell) const {
  cell[1] = grid_.row_beside(cell[1]);
  const bool is_known = cell[1] >= -1 && cell[1] <= grid_.rows() && grid_.has_row(cell[1]);
  return is_known && cell[0] >= 0 && cell[0] <= grid_.planes() + 1 && cell[2] >= 0 && cell[2] < grid_.columns();
}

bool ParticlesToGrid::holds_any(const CellNumbers& cell) const {
  const auto [k, r, c] = cell;
  return c >= filled(k, r).begin && c < filled(k, r).end && sums_.number(0, k, r, c) > 0;
}

// What the fits of the four cells beside `cell` along the face say of a place in it, in cells from its corner.
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
