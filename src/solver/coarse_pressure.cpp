#include "solver/coarse_pressure.hpp"

namespace trevi {

namespace {

// V-cycles from the hydrostatic start. One is as exact as the four sweeps a cell of depth that stood here before, two
// give the same waves, pools and columns as a converged solution, three the same compression of a falling cube.
constexpr int cycles = 3;
// A cell that a solid cuts returns to its volume that much as fast as others: what it holds is noisier, and water in a
// box turned about three axes rests three times as well so. At 0.1 it stays a quarter of a spacing too high.
constexpr Real cut_return = 0.5;

}  // namespace

void CoarsePressure::solve(const CoarseWater& water, Halo& halo, Real fall, Real return_share) {
  const CoarseGrid& grid = water.grid();
  const LocalId planes = grid.planes();
  multigrid_.resize(planes, grid.rows(), grid.columns(), water.depth());
  for_each_row(grid.rows_of({0, planes + 2}), [&](LocalId k, LocalId r) {
    multigrid_.finest().use_columns(k, r, static_cast<std::size_t>(grid.columns(k, r)));
  });
  for_each_row(grid.rows_of({1, planes + 2}), [&](LocalId k, LocalId r) { weigh_row(water, k, r); });
  grid.repeat(multigrid_.finest().link[1]);
  for_each_row(grid.rows_of({1, planes + 1}), [&](LocalId k, LocalId r) { find_sources(water, return_share, k, r); });
  for_each_row(grid.rows_of({1, planes + 2}), [&](LocalId k, LocalId r) { leave_water(water, k, r); });
  for_each_row(grid.rows_of({0, planes + 2}), [&](LocalId k, LocalId r) { start_at_rest(water, fall, k, r); });
  multigrid_.solve(halo, cycles);
  for_each_row(grid.rows_of({0, planes + 2}), [&](LocalId k, LocalId r) {
    Real* phi = &multigrid_.finest().phi[grid.index(k, r, 0)];
    for (LocalId c = 0; c < grid.columns(k, r); ++c) phi[c] = std::min(phi[c], 0.0);
  });
  grid.repeat(multigrid_.finest().phi);
}

// Where rows do not repeat, the one beyond the last has no water; its lower faces are walls, and stay without weight.
void CoarsePressure::weigh_row(const CoarseWater& water, LocalId k, LocalId r) {
  const CoarseGrid& grid = water.grid();
  auto& weight = multigrid_.finest().link;
  for (LocalId c = 0; c <= grid.columns(k, r); ++c) {
    const std::size_t at = grid.index(k, r, c);
    for (std::size_t a = 0; a < 3; ++a) {
      const std::size_t below = at - grid.step(a);
      const bool low = water.is_wet(below), high = water.is_wet(at);
      weight[a][at] = 0;
      const Real open = water.face(a, at);
      if (grid.is_wall(a, k, r, c) || (!low && !high) || open == 0) continue;
      if (a == 2) {
        weight[a][at] = low && !high ? 1 / water.above_middle(below) : 1;
      } else {
        weight[a][at] = low && high ? (water.height(below) + water.height(at)) / 2 : water.height(low ? below : at);
      }
      weight[a][at] *= open;
    }
  }
}

// A top cell returns to its volume only as far as the cell above holds water that could fill it.
void CoarsePressure::find_sources(const CoarseWater& water, Real return_share, LocalId k, LocalId r) {
  const CoarseGrid& grid = water.grid();
  CoarseLevel& cells = multigrid_.finest();
  const Vec3 stiffness = grid.size().cwiseProduct(grid.size()).cwiseInverse();
  for (LocalId c = 0; c < grid.columns(k, r); ++c) {
    const std::size_t at = grid.index(k, r, c);
    cells.rhs[at] = cells.sink[at] = 0;
    if (!water.is_wet(at)) continue;
    for (std::size_t a = 0; a < 3; ++a) {
      const std::size_t step = grid.step(a);
      const Real low = water.is_wet(at - step) ? 0 : cells.link[a][at];
      const Real high = water.is_wet(at + step) ? 0 : cells.link[a][at + step];
      cells.sink[at] += stiffness[static_cast<Eigen::Index>(a)] * (low + high);
    }
    const Real covered = water.is_top(at) ? std::min(2 * water.fill(at + 1), 1.0) : 1;
    const Real returned = return_share * covered * (water.is_cut(at) ? cut_return : 1);
    cells.rhs[at] = divergence(water, at) - returned * water.open(at) * (water.fill(at) - 1);
  }
}

// Links between two cells of water, 1/m²; those to cells of air are sinks.
void CoarsePressure::leave_water(const CoarseWater& water, LocalId k, LocalId r) {
  const CoarseGrid& grid = water.grid();
  auto& link = multigrid_.finest().link;
  for (std::size_t a = 0; a < 3; ++a) {
    const auto b = static_cast<Eigen::Index>(a);
    const Real stiffness = 1 / (grid.size()[b] * grid.size()[b]);
    for (LocalId c = 0; c < grid.columns(k, r); ++c) {
      const std::size_t at = grid.index(k, r, c);
      link[a][at] *= water.is_wet(at) && water.is_wet(at - grid.step(a)) ? stiffness : 0;
    }
  }
}

// Divergence of the particles' mean displacements. Nothing passes a wall; horizontal faces count with their whole area,
// as far as it is open. A moving solid takes its share of a face along.
Real CoarsePressure::divergence(const CoarseWater& water, std::size_t at) const {
  const CoarseGrid& grid = water.grid();
  const auto& weight = multigrid_.finest().link;
  Real sum = 0;
  for (std::size_t a = 0; a < 3; ++a) {
    const std::size_t above = at + grid.step(a);
    Real low = weight[a][at], high = weight[a][above];
    if (a == 2) {
      low = low > 0 ? water.face(a, at) : 0;
      high = high > 0 ? water.face(a, above) : 0;
    }
    sum += (high * water.displacement(a, above) - low * water.displacement(a, at)) /
           grid.size()[static_cast<Eigen::Index>(a)];
    if (const CoarseSolids* solids = water.solids(); solids != nullptr && solids->moves()) {
      sum +=
          ((1 - solids->face(a, above)) * solids->moved(a, above) - (1 - solids->face(a, at)) * solids->moved(a, at)) /
          grid.size()[static_cast<Eigen::Index>(a)];
    }
  }
  return sum;
}

// In a column that stands on the floor, the hydrostatic phi below that column's own surface, as if solids were water.
void CoarsePressure::start_at_rest(const CoarseWater& water, Real fall, LocalId k, LocalId r) {
  const CoarseGrid& grid = water.grid();
  CoarseLevel& cells = multigrid_.finest();
  const Real step = fall * grid.size()[2];
  const std::size_t floor = grid.index(k, r, 0), ceiling = floor + static_cast<std::size_t>(grid.columns(k, r));
  for (std::size_t at = floor; at < ceiling; ++at) cells.phi[at] = cells.next[at] = 0;
  std::size_t end = floor;
  while (end < ceiling && (water.is_wet(end) || water.is_solid(end))) ++end;
  if (end == floor || !water.is_top(end - 1)) return;
  Real phi = -step * water.above_middle(end - 1);
  for (std::size_t at = end; at-- > floor; phi -= step) cells.phi[at] = phi;
}

}  // namespace trevi
