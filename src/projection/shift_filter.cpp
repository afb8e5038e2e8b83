#include "projection/shift_filter.hpp"

namespace trevi {

using namespace projection;

// Planes whose sums and fits other ranks need are first; as they do not share memory, they may be.
void ShiftFilter::for_each_plane(Halo& halo, const Input& input, const std::function<void(Range)>& use) {
  const ProjectionGrid& grid = surface_.grid();
  const LocalId last = grid.planes(), step = grid.rolling_planes();
  struct Nothing {};
  const auto sum = [&](Nothing, LocalId k, LocalId r) { sum_row(input, k, r); };
  const auto fit = [&](TentMemory& memory, LocalId k, LocalId r) { fit_row(memory, k, r); };
  borrow();
  if (grid.rows_are_cut()) {
    for_each_row_and_send<Nothing>(grid, halo, sums_, sum);
    for_each_row_and_send<TentMemory>(grid, halo, fit_, fit);
    use({1, last + 1});
    return give_back();
  }
  PlanesOnce<Nothing, decltype(sum)> sums(grid, sum);
  PlanesOnce<TentMemory, decltype(fit)> fits(grid, fit);
  if (halo.has_neighbours()) {
    sums.find_at_ends(1);
    sums_.start(halo);
    sums.find_at_ends(2);
    halo.finish();
    fits.find_at_ends(1);
    fit_.start(halo);
  }
  for (LocalId begin = 1; begin <= last; begin += step) {
    const LocalId end = std::min(begin + step, last + 1);
    sums.find({begin, end + 2});
    fits.find({begin, end + 1});
    if (begin == 1) halo.finish();
    use({begin, end});
  }
  give_back();
}

void ShiftFilter::borrow() {
  const ProjectionGrid& grid = surface_.grid();
  window_ = grid.storage_rolling().shape().window;
  fit_.borrow_briefly(grid.scratch(), grid.storage_rolling());
  const auto planes = static_cast<std::size_t>(window_) + 2;  // with the first and the last one
  kept_ = grid.scratch().borrow_briefly<Real>(planes * grid.step(0) + EightCells::count);
  kept_.fill(0);
  sums_.borrow_briefly(grid.scratch(), grid.storage_rolling());
}

void ShiftFilter::give_back() {
  sums_.give_back();
  fit_.give_back();
  kept_.give_back();
}

void ShiftFilter::find_smooth(Smooth& smooth, LocalId k, LocalId r) const {
  const ProjectionGrid& grid = surface_.grid();
  smooth.row.resize(fit_.per_row());
  average_maps(rows_around(grid, fit_, {k, r, surface_.water().filled(k, r)}, smooth.memory), kept_of(k, r),
               smooth.row.data());
}

void ShiftFilter::sum_row(const Input& input, LocalId k, LocalId r) {
  const auto& [order, shifts, densities] = input;
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
  Real* const kept = kept_of(k, r);
  static thread_local std::vector<Real> water;
  water.assign(static_cast<std::size_t>(grid.columns()) + EightCells::count, 0.0);
  for (LocalId c = cells.begin; c < cells.end; ++c) {
    const auto i = static_cast<std::size_t>(c);
    water[i] = sums_.number(0, k, r, c) > 0 && is_water(floor + i) ? 1 : 0;
  }
  fit_.clear_around(k, r, cells);
  fit_shifts(rows_around(grid, sums_, {k, r, cells}, memory), {fit_.row(k, r), water.data(), kept});
  for (LocalId c = cells.begin; c < cells.end; ++c) {
    kept[c] = 1 - std::clamp((kept[c] - swelling_begins) / (swelling_full - swelling_begins), 0.0, 1.0);
  }
}

}  // namespace trevi
