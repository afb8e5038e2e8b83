#include "solver/coarse_pressure.hpp"

#include <numbers>

#include "base/threads.hpp"

namespace trevi {

namespace {

// Under-relaxation of the Jacobi sweep: a full step would only change the sign of the checkerboard mode, not damp it.
constexpr Real damping = 0.9;
// From the hydrostatic start 2, 4 and 30 sweeps for each cell of depth give the same waves and the same pools at rest.
constexpr int sweeps_per_cell = 4;

}  // namespace

void CoarsePressure::solve(const CoarseWater& water, Halo& halo, Real fall, Real return_share) {
  const CoarseGrid& grid = water.grid();
  for (auto& weight : weight_) weight.assign(grid.cells(), 0.0);
  for (auto* field : {&source_, &per_diagonal_, &phi_, &previous_}) field->assign(grid.cells(), 0.0);
  wet_columns_.assign((static_cast<std::size_t>(grid.planes()) + 2) * static_cast<std::size_t>(grid.rows()), 0);
  weigh_faces(water);
  find_sources(water, return_share);
  start_at_rest(water, fall);
  const int depth = std::max(water.depth() + 1, 4);
  // The slowest mode is a quarter wave from floor to surface; its eigenvalue is the spectral radius of a sweep.
  const Vec3 stiffness = grid.size().cwiseProduct(grid.size()).cwiseInverse();
  const Real angle = std::numbers::pi / (2.0 * depth);
  const Real radius = 1 - damping * angle * angle / 2 * stiffness[2] / stiffness.sum(), r2 = radius * radius;
  Real omega = 1;
  for (int s = 0; s < sweeps_per_cell * depth; ++s) {
    omega = s == 0 ? 1 : s == 1 ? 2 / (2 - r2) : 4 / (4 - r2 * omega);
    sweep_plane(grid, 1, omega);
    if (grid.planes() > 1) sweep_plane(grid, grid.planes(), omega);
    halo.start_planes(previous_, grid.step(0));
    for_each_part({2, std::max(grid.planes(), 2)}, 1, [&](Range k) { sweep_plane(grid, k.begin, omega); });
    halo.finish();
    std::swap(previous_, phi_);
  }
  for (Real& phi : phi_) phi = std::min(phi, 0.0);
}

void CoarsePressure::weigh_faces(const CoarseWater& water) {
  for (LocalId k = 1; k <= water.grid().planes() + 1; ++k) {
    for (LocalId r = 0; r <= water.grid().rows(); ++r) weigh_row(water, k, r);
  }
}

void CoarsePressure::weigh_row(const CoarseWater& water, LocalId k, LocalId r) {
  const CoarseGrid& grid = water.grid();
  for (LocalId c = 0; c <= grid.columns(); ++c) {
    const std::size_t at = grid.index(k, r, c);
    for (std::size_t a = 0; a < 3; ++a) {
      const std::size_t below = at - grid.step(a);
      const bool low = water.is_wet(below), high = water.is_wet(at);
      if (grid.is_wall(a, k, r, c) || (!low && !high)) continue;
      if (a == 2) {
        weight_[a][at] = low && !high ? 1 / water.above_middle(below) : 1;
      } else {
        weight_[a][at] = low && high ? (water.height(below) + water.height(at)) / 2 : water.height(low ? below : at);
      }
    }
  }
}

// A top cell returns to its volume only as far as the cell above holds water that could fill it.
void CoarsePressure::find_sources(const CoarseWater& water, Real return_share) {
  const CoarseGrid& grid = water.grid();
  const Vec3 stiffness = grid.size().cwiseProduct(grid.size()).cwiseInverse();
  for (LocalId k = 1; k <= grid.planes(); ++k) {
    for (LocalId r = 0; r < grid.rows(); ++r) {
      for (LocalId c = 0; c < grid.columns(); ++c) {
        const std::size_t at = grid.index(k, r, c);
        if (!water.is_wet(at)) continue;
        Real diagonal = 0;
        for (std::size_t a = 0; a < 3; ++a)
          diagonal += stiffness[static_cast<Eigen::Index>(a)] * (weight_[a][at] + weight_[a][at + grid.step(a)]);
        if (diagonal == 0) continue;
        per_diagonal_[at] = 1 / diagonal;
        wet_columns_[row_of(grid, k, r)] = static_cast<std::size_t>(c) + 1;
        const Real covered = water.is_top(at) ? std::min(2 * water.fill(at + 1), 1.0) : 1;
        source_[at] = return_share * covered * (water.fill(at) - 1) - divergence(water, at);
      }
    }
  }
}

// Divergence of the particles' mean displacements. Nothing passes a wall; horizontal faces count with their whole area.
Real CoarsePressure::divergence(const CoarseWater& water, std::size_t at) const {
  const CoarseGrid& grid = water.grid();
  Real sum = 0;
  for (std::size_t a = 0; a < 3; ++a) {
    const std::size_t above = at + grid.step(a);
    Real low = weight_[a][at], high = weight_[a][above];
    if (a == 2) {
      low = low > 0 ? 1 : 0;
      high = high > 0 ? 1 : 0;
    }
    sum += (high * water.displacement(a, above) - low * water.displacement(a, at)) /
           grid.size()[static_cast<Eigen::Index>(a)];
  }
  return sum;
}

// Initial guess: in a column that stands on the floor, the hydrostatic phi below that column's own surface.
void CoarsePressure::start_at_rest(const CoarseWater& water, Real fall) {
  const CoarseGrid& grid = water.grid();
  const Real step = fall * grid.size()[2];
  for (LocalId k = 0; k < grid.planes() + 2; ++k) {
    for (LocalId r = 0; r < grid.rows(); ++r) {
      const std::size_t floor = grid.index(k, r, 0);
      std::size_t end = floor;
      while (end < floor + static_cast<std::size_t>(grid.columns()) && water.is_wet(end)) ++end;
      if (end == floor || !water.is_top(end - 1)) continue;
      Real phi = -step * water.above_middle(end - 1);
      for (std::size_t at = end; at-- > floor; phi -= step) phi_[at] = previous_[at] = phi;
    }
  }
}

// Writes the new phi over that of two sweeps ago (`previous_`), cell by cell, as Chebyshev's recurrence allows.
void CoarsePressure::sweep_plane(const CoarseGrid& grid, LocalId k, Real omega) {
  const std::size_t row = grid.step(1), plane = grid.step(0);
  const Vec3 stiffness = grid.size().cwiseProduct(grid.size()).cwiseInverse();
  const Real sx = stiffness[0], sy = stiffness[1], sz = stiffness[2];
  for (LocalId r = 0; r < grid.rows(); ++r) {
    const std::size_t start = grid.index(k, r, 0);
    const Real *phi = phi_.data() + start, *source = source_.data() + start, *per = per_diagonal_.data() + start;
    const Real *wx = weight_[0].data() + start, *wy = weight_[1].data() + start, *wz = weight_[2].data() + start;
    Real* next = previous_.data() + start;
#pragma GCC ivdep
    for (std::size_t c = 0; c < wet_columns_[row_of(grid, k, r)]; ++c) {
      const Real sum = sx * (wx[c] * phi[c - plane] + wx[c + plane] * phi[c + plane]) +
                       sy * (wy[c] * phi[c - row] + wy[c + row] * phi[c + row]) +
                       sz * (wz[c] * phi[c - 1] + wz[c + 1] * phi[c + 1]);
      next[c] = omega * (phi[c] + damping * (per[c] * (sum - source[c]) - phi[c]) - next[c]) + next[c];
    }
  }
}

Real CoarsePressure::displacement(const CoarseWater& water, std::size_t a, std::size_t at) const {
  const std::size_t below = at - water.grid().step(a);
  const Real u = (phi_[at] - phi_[below]) / water.grid().size()[static_cast<Eigen::Index>(a)];
  return a == 2 && water.is_wet(below) && !water.is_wet(at) ? u / water.above_middle(below) : u;
}

std::size_t CoarsePressure::bytes() const {
  std::size_t values = wet_columns_.capacity();
  for (const auto* field : {&source_, &per_diagonal_, &phi_, &previous_}) values += field->capacity();
  for (const auto& weight : weight_) values += weight.capacity();
  return values * sizeof(Real);
}

}  // namespace trevi
