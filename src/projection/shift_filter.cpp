#include "projection/shift_filter.hpp"

namespace trevi {

using namespace projection;

void ShiftFilter::resize() { kept_.assign(surface_.grid().cells() + EightCells::count, 0.0); }

void ShiftFilter::find(const CellOrder& order, Halo& halo, const Motion& shifts, const Densities& densities) {
  const ProjectionGrid& grid = surface_.grid();
  struct Nothing {};
  for_each_row_and_send<Nothing>(grid, halo, sums_,
                                 [&](Nothing, LocalId k, LocalId r) { sum_row(order, k, r, shifts, densities); });
  for_each_row_and_send<TentMemory>(grid, halo, fit_,
                                    [&](TentMemory& memory, LocalId k, LocalId r) { fit_row(memory, k, r); });
}

void ShiftFilter::find_smooth(Smooth& smooth, LocalId k, LocalId r) const {
  const ProjectionGrid& grid = surface_.grid();
  smooth.row.resize(fit_.per_row());
  average_maps(rows_around(grid, fit_, {k, r, surface_.water().filled(k, r)}, smooth.memory),
               &kept_[grid.index(k, r, 0)], smooth.row.data());
}

void ShiftFilter::sum_row(const CellOrder& order, LocalId k, LocalId r, const Motion& shifts,
                          const Densities& densities) {
  const ProjectionGrid& grid = surface_.grid();
  const ParticlesToGrid& water = surface_.water();
  sums_.clear(k, r);
  for (LocalId c = 0; c < grid.columns(k, r); ++c) {
    const CellParticles cell = water.particles_of(order, k, r, c);
    if (cell.begin == cell.end) continue;
    const MotionSums motion = sum_motion(water.frame(), shifts, cell);
    Moments sums{{static_cast<Real>(cell.end - cell.begin), motion.y, motion.yy}, {motion.u, motion.uy}, 0};
    for (std::size_t i = cell.begin; i < cell.end; ++i) sums.more += densities.rho[i];
    sums.more = sums.more / densities.rest - sums.at.n;
    sums_.set(k, r, c, sums);
  }
}

void ShiftFilter::fit_row(TentMemory& memory, LocalId k, LocalId r) {
  const ProjectionGrid& grid = surface_.grid();
  const Range cells = surface_.water().filled(k, r);
  const std::size_t floor = grid.index(k, r, 0);
  static thread_local std::vector<Real> water;
  water.assign(static_cast<std::size_t>(grid.columns()) + EightCells::count, 0.0);
  for (LocalId c = cells.begin; c < cells.end; ++c) {
    const auto i = static_cast<std::size_t>(c);
    water[i] = sums_.number(0, k, r, c) > 0 && is_water(floor + i) ? 1 : 0;
  }
  fit_.clear_around(k, r, cells);
  fit_shifts(rows_around(grid, sums_, {k, r, cells}, memory), {fit_.row(k, r), water.data(), &kept_[floor]});
  for (LocalId c = cells.begin; c < cells.end; ++c) {
    Real& kept = kept_[floor + static_cast<std::size_t>(c)];
    kept = 1 - std::clamp((kept - swelling_begins) / (swelling_full - swelling_begins), 0.0, 1.0);
  }
}

}  // namespace trevi
