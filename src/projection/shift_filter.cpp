#include "projection/shift_filter.hpp"

namespace trevi {

using namespace projection;

namespace {

struct Nothing {};

}  // namespace

// Planes whose sums and fits other ranks need are first; as they do not share memory, they may be.
void ShiftFilter::for_each_plane(Halo& halo, const Input& input, const std::function<void(Range)>& use) {
  const ProjectionGrid& grid = surface_.grid();
  const LocalId last = grid.planes(), step = grid.rolling_planes();
  borrow();
  if (grid.rows_are_cut()) {
    for_each_row_and_send<Nothing>(grid, halo, sums_,
                                   [&](Nothing, LocalId k, LocalId r) { sum_row(input, k, r); });
    for_each_row_and_send<TentMemory>(grid, halo, fit_,
                                      [&](TentMemory& memory, LocalId k, LocalId r) { fit_row(memory, k, r); });
    use({1, last + 1});
  } else {
    if (halo.has_neighbours()) find_ends(halo, input);
    for (LocalId begin = 1; begin <= last; begin += step) {
      const LocalId end = std::min(begin + step, last + 1);
      // What came before has been found already.
      sum_planes(input, {begin, std::min(end + 2, last + 1)});
      fit_planes({begin, std::min(end + 1, last + 1)});
      if (begin == 1) halo.finish();
      use({begin, end});
    }
  }
  give_back();
}

void ShiftFilter::borrow() {
  const ProjectionGrid& grid = surface_.grid();
  sums_.borrow(grid.scratch(), grid.storage_rolling());
  fit_.borrow(grid.scratch(), grid.storage_rolling());
  window_ = grid.storage_rolling().shape().window;
  const auto planes = static_cast<std::size_t>(window_) + 2;  // with the first and the last one
  kept_ = grid.scratch().borrow<Real>(planes * grid.step(0) + EightCells::count);
  kept_.fill(0);
  summed_.assign(static_cast<std::size_t>(grid.planes()) + 2, 0);
  fitted_ = summed_;
}

void ShiftFilter::give_back() {
  sums_.give_back();
  fit_.give_back();
  kept_.give_back();
}

void ShiftFilter::find_ends(Halo& halo, const Input& input) {
  const ProjectionGrid& grid = surface_.grid();
  const LocalId last = grid.planes();
  const std::array<bool, 2> exchanged = grid.storage_rolling().shape().exchanged;
  const auto at_ends = [&](LocalId depth, const auto& find) {
    if (exchanged[0]) find(Range{depth, depth + 1});
    if (exchanged[1]) find(Range{last + 1 - depth, last + 2 - depth});
  };
  at_ends(1, [&](Range plane) { sum_planes(input, plane); });
  sums_.start(halo);
  if (last > 1) at_ends(2, [&](Range plane) { sum_planes(input, plane); });
  halo.finish();
  at_ends(1, [&](Range plane) { fit_planes(plane); });
  fit_.start(halo);
}

void ShiftFilter::sum_planes(const Input& input, Range planes) {
  for_each_row_of_few<Nothing>(surface_.grid(), planes, [&](Nothing, LocalId k, LocalId r) {
    if (summed_[static_cast<std::size_t>(k)] == 0) sum_row(input, k, r);
  });
  std::fill(summed_.begin() + planes.begin, summed_.begin() + planes.end, 1);
}

void ShiftFilter::fit_planes(Range planes) {
  for_each_row_of_few<TentMemory>(surface_.grid(), planes, [&](TentMemory& memory, LocalId k, LocalId r) {
    if (fitted_[static_cast<std::size_t>(k)] == 0) fit_row(memory, k, r);
  });
  std::fill(fitted_.begin() + planes.begin, fitted_.begin() + planes.end, 1);
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
