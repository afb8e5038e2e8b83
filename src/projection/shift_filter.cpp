#include "projection/shift_filter.hpp"

namespace trevi {

using namespace projection;

void ShiftFilter::for_each_plane(Halo& halo, const Input& input, const std::function<void(Range)>& use) {
  borrow();
  const PlaneStage sums{[&](TentMemory&, LocalId k, LocalId r) { sum_row(input, k, r); }, [&] { sums_.start(halo); }};
  const PlaneStage fits{[&](TentMemory& memory, LocalId k, LocalId r) { fit_row(memory, input, k, r); },
                        [&] { fit_.start(halo); }};
  for_each_plane_in_turn<TentMemory>(surface_.grid(), halo, sums, fits, [&](Range planes) {
    if (planes.begin == 1) halo.finish();
    use(planes);
  });
  give_back();
}

void ShiftFilter::borrow() {
  const ProjectionGrid& grid = surface_.grid();
  window_ = grid.storage_rolling().shape().window;
  fit_.borrow_briefly(grid.scratch(), grid.storage_rolling());
  const auto planes = static_cast<std::size_t>(window_) + 2;  // including the first and the last one
  kept_ = grid.scratch().borrow_briefly<Real>(planes * grid.step(0) + FourCells::count);
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
  const ParticlesToGrid& water = surface_.water();
  sums_.clear(k, r);
  if (!input.near.has(k, r)) return;
  water.for_each_cell(input.order, k, r, [&](LocalId c, const CellParticles& cell) {
    const MotionSums motion = sum_motion(water.frame(), input.shifts, cell);
    Moments sums{{static_cast<Real>(cell.end - cell.begin), motion.y, motion.yy}, {motion.u, motion.uy}, 0};
    for (std::size_t i = cell.begin; i < cell.end; ++i) sums.more += input.densities.rho[i];
    sums.more = sums.more / input.densities.rest - sums.at.n;
    sums_.set(k, r, c, sums);
  });
}

void ShiftFilter::fit_row(TentMemory& memory, const Input& input, LocalId k, LocalId r) {
  if (!input.near.has(k, r)) return fit_.clear(k, r);
  const ProjectionGrid& grid = surface_.grid();
  const Range cells = surface_.water().filled(k, r);
  const std::size_t floor = grid.index(k, r, 0);
  Real* const kept = kept_of(k, r);
  static thread_local std::vector<Real> water;
  water.assign(static_cast<std::size_t>(grid.columns()) + FourCells::count, 0.0);
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
