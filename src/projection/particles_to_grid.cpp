#include "projection/particles_to_grid.hpp"

#include "projection/tent.hpp"

namespace trevi {

ParticlesToGrid::ParticlesToGrid(const ProjectionGrid& grid, Real spacing) : grid_(grid), frame_{} {
  frame_.per_length = grid_.per_length();
  frame_.per_full = 1;
  for (std::size_t a = 0; a < 3; ++a) {
    const std::size_t b = grid_.axis(a);
    frame_.half[b] = spacing / 2 * frame_.per_length[b];
    frame_.nearest[b] = grid_.repeats()[a] ? -INFINITY : frame_.half[b];
    frame_.farthest[b] = grid_.repeats()[a] ? INFINITY : grid_.count(a) - frame_.half[b];
    frame_.per_full *= 2 * frame_.half[b];
  }
}

void ParticlesToGrid::resize() {
  sums_.assign(grid_.cells(), {});
  spread_.assign(grid_.cells(), {});
  fit_.assign(grid_.cells(), {});
  rest2_.assign(grid_.cells(), 0.0);
  for (auto& u : displacement_) u.assign(grid_.cells(), 0.0);
}

// The rest of what a cell without particles has is not looked at.
void ParticlesToGrid::clear_row(LocalId k, LocalId r) {
  const std::size_t begin = grid_.index(k, r, 0), end = begin + static_cast<std::size_t>(grid_.columns(k, r)) + 1;
  for (std::size_t at = begin; at < end; ++at) {
    sums_[at].volume = {};
    sums_[at].moments.at.n = 0;
    fit_[at].weight = 0;
  }
  for (auto& u : displacement_) {
    const auto first = u.begin() + static_cast<std::ptrdiff_t>(begin);
    const auto count = static_cast<std::ptrdiff_t>(end - begin);
    std::fill_n(first, count, 0.0);
    if (r + 1 == grid_.rows()) std::fill_n(first + static_cast<std::ptrdiff_t>(grid_.step(1)), count, 0.0);
  }
}

void ParticlesToGrid::gather(const CellOrder& order, Halo& halo, const Motion& motion, const CutCells* cuts) {
  const LocalId planes = grid_.planes();
  for_each_part({1, planes + 1}, 1, [&](Range k) { sum_plane(order, k.begin, motion); });
  halo.start_planes(sums_, grid_.step(0));
  halo.finish();
  for_each_row(grid_.rows_of({1, planes + 1}), [&](LocalId k, LocalId r) { fit_row(k, r); });
  halo.start_planes(fit_, grid_.step(0));
  halo.finish();
  for_each_row(grid_.rows_of({1, planes + 2}), [&](LocalId k, LocalId r) {
    find_faces(0, k, r, cuts);
    if (k > planes) return;
    find_faces(1, k, r, cuts);
    find_faces(2, k, r, cuts);
  });
  grid_.repeat(displacement_[1]);
  if (grid_.repeats()[2]) grid_.repeat(displacement_[2]);
}

CellParticles ParticlesToGrid::particles_of(const CellOrder& order, LocalId k, LocalId r, LocalId c) const {
  const LocalId cell = r * order.grid().columns() + c;
  const auto begin = static_cast<std::size_t>(order.start(k, cell) - order.low_ghosts());
  const auto end = static_cast<std::size_t>(order.start(k, cell + 1) - order.low_ghosts());
  return {begin, end, grid_.place_of(k, r, c)};
}

void ParticlesToGrid::sum_plane(const CellOrder& order, LocalId k, const Motion& motion) {
  const LocalId rows = grid_.rows(), beyond = grid_.repeats()[1] ? 1 : 0;
  // Where rows repeat, the last one is also before the first, and the first beyond the last: each row is then added to
  // in the same order.
  for (LocalId row = -beyond; row < rows + beyond; ++row) {
    const LocalId r = (row + rows) % rows;
    for (LocalId c = 0; c < grid_.columns(k, r); ++c) {
      const CellParticles cell = particles_of(order, k, r, c);
      if (cell.begin == cell.end) continue;
      const CellSums sums = sum_cell(frame_, motion, cell);
      add_volume(k, row, c, sums);
      if (row != r) continue;
      Moments& moments = sums_[grid_.index(k, r, c)].moments;
      moments.at = {static_cast<Real>(cell.end - cell.begin), sums.motion.y, sums.motion.yy};
      moments.flow = {sums.motion.u, sums.motion.uy};
      moments.more = sums.motion.uu;
    }
  }
}

void ParticlesToGrid::add_volume(LocalId k, LocalId r, LocalId c, const CellSums& sums) {
  const bool along_x = grid_.axis(0) == 0, repeats = grid_.repeats()[2];
  for (LocalId row = std::max(r - 1, 0); row <= std::min(r + 1, grid_.rows() - 1); ++row) {
    const LocalId columns = grid_.columns(k, row);
    for (LocalId column = c - 1; column <= c + 1; ++column) {
      if (!repeats && (column < 0 || column >= columns)) continue;
      auto& volume = sums_[grid_.index(k, row, repeats ? (column + columns) % columns : column)].volume;
      const auto i = static_cast<std::size_t>(row - r + 1), j = static_cast<std::size_t>(column - c + 1);
      for (std::size_t plane = 0; plane < 3; ++plane)
        volume[plane] += along_x ? sums.volume[plane][i][j] : sums.volume[i][plane][j];
    }
  }
}

Real ParticlesToGrid::volume(std::size_t at) const {
  const std::size_t plane = grid_.step(0);
  return sums_[at - plane].volume[2] + sums_[at].volume[1] + sums_[at + plane].volume[0];
}

void ParticlesToGrid::fit_row(LocalId k, LocalId r) {
  const std::size_t floor = grid_.index(k, r, 0);
  const auto moments_at = [&](std::size_t at) -> const Moments& { return sums_[at].moments; };
  for_each_tent<Moments>(
      grid_, k, r, [&](std::size_t at) { return sums_[at].moments.at.n > 0; }, moments_at,
      [&](LocalId c, const Moments& around) {
        const std::size_t at = floor + static_cast<std::size_t>(c);
        spread_[at] = spread_of(around.at);
        fit_[at] = fit_of(spread_[at], around.flow, around.more, &rest2_[at]);
      });
}

// The particles of a cell at one of its faces, whose middle is given in cells from the corner of that cell.
ParticlesToGrid::FaceSum ParticlesToGrid::from_side(std::size_t a, std::size_t cell, bool below,
                                                    const ByAxis& middle) const {
  const Moments& m = sums_[cell].moments;
  if (m.at.n == 0) return {};
  const std::size_t i = grid_.axis(a);
  const ByAxis& slope = fit_[cell].b[i];
  const Real sign = below ? 1 : -1, weight = (below ? 0 : m.at.n) + sign * m.at.y[i];
  Real value = (below ? 0 : m.flow.u[i]) + sign * m.flow.uy[i][i];
  for (std::size_t j = 0; j < 3; ++j)
    value += slope[j] * (middle[j] * weight - ((below ? 0 : m.at.y[j]) + sign * m.at.second(i, j)));
  return {weight, value};
}

// Lower faces of the cells of a row in direction a, and the upper one at the end of the last row or of a column.
void ParticlesToGrid::find_faces(std::size_t a, LocalId k, LocalId r, const CutCells* cuts) {
  const LocalId columns = std::max(grid_.columns(k, r), a == 0 ? grid_.columns(k - 1, r) : 0);
  const LocalId rows = grid_.rows(), last_row = a == 1 && r + 1 == rows && !grid_.repeats()[1] ? r + 1 : r;
  const std::size_t i = grid_.axis(a);
  for (LocalId row = r; row <= last_row; ++row) {
    for (LocalId c = 0; c < columns + (a == 2 ? 1 : 0); ++c) {
      const std::size_t at = grid_.index(k, row, c);
      // Across the ends of an axis that repeats.
      const std::size_t above = a == 2 && c == columns && grid_.repeats()[2] ? grid_.index(k, row, 0) : at;
      const std::size_t below = a == 1 && row == 0 && grid_.repeats()[1] ? grid_.index(k, rows - 1, c)
                                : a == 2 && c == 0 && grid_.repeats()[2] ? grid_.index(k, row, columns - 1)
                                                                         : at - grid_.step(a);
      ByAxis low = cuts != nullptr ? cuts->middle_of_face(a, at) : ByAxis{0.5, 0.5, 0.5}, high = low;
      low[i] = 0;
      high[i] = 1;
      const FaceSum over = from_side(a, above, false, low), under = from_side(a, below, true, high);
      const Real weight = over.weight + under.weight;
      if (weight >= projection::least_face_weight) {
        displacement_[a][at] = (over.value + under.value) / weight;
      } else {
        const Real n_over = sums_[above].moments.at.n, n_under = sums_[below].moments.at.n;
        displacement_[a][at] =
            n_over + n_under > 0
                ? (n_over * fit_[above].at(i, low) + n_under * fit_[below].at(i, high)) / (n_over + n_under)
                : 0;
      }
    }
  }
}

std::size_t ParticlesToGrid::bytes() const {
  std::size_t values = rest2_.capacity();
  for (const auto& u : displacement_) values += u.capacity();
  return values * sizeof(Real) + sums_.capacity() * sizeof(PlaneSums) + spread_.capacity() * sizeof(Spread) +
         fit_.capacity() * sizeof(AffineMap);
}

}  // namespace trevi
