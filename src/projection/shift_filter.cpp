#include "projection/shift_filter.hpp"

#include "projection/tent.hpp"

namespace trevi {

using namespace projection;

void ShiftFilter::resize() {
  sums_.assign(surface_.grid().cells(), {});
  fit_.assign(surface_.grid().cells(), {});
  map_.assign(surface_.grid().cells(), {});
  kept_.assign(surface_.grid().cells(), 0.0);
}

void ShiftFilter::clear_row(LocalId k, LocalId r) {
  const ProjectionGrid& grid = surface_.grid();
  const std::size_t begin = grid.index(k, r, 0), end = begin + static_cast<std::size_t>(grid.columns(k, r)) + 1;
  for (std::size_t at = begin; at < end; ++at) sums_[at].at.n = fit_[at].weight = 0;
}

template <class T>
void ShiftFilter::find(const CellOrder& order, Halo& halo, const Motion& shifts, std::span<const T> compression) {
  const ProjectionGrid& grid = surface_.grid();
  const ParticlesToGrid& water = surface_.water();
  const CellRows own = grid.rows_of({1, grid.planes() + 1});
  for_each_row(own, [&](LocalId k, LocalId r) {
    for (LocalId c = 0; c < grid.columns(k, r); ++c) {
      const CellParticles cell = water.particles_of(order, k, r, c);
      Moments& sums = sums_[grid.index(k, r, c)];
      if (cell.begin == cell.end) continue;
      sums.more = 0;
      const MotionSums motion = sum_motion(water.frame(), shifts, cell);
      const auto n = static_cast<Real>(cell.end - cell.begin);
      sums.at = {n, motion.y, motion.yy};
      sums.flow = {motion.u, motion.uy};
      for (std::size_t i = cell.begin; i < cell.end; ++i) sums.more += static_cast<Real>(compression[i]);
    }
  });
  halo.start_planes(sums_, grid.step(0));
  halo.finish();
  const auto needed = [&](std::size_t at) { return sums_[at].at.n > 0; };
  for_each_row(own, [&](LocalId k, LocalId r) {
    const std::size_t floor = grid.index(k, r, 0);
    for_each_tent<Moments>(
        grid, k, r, needed, [&](std::size_t at) -> const Moments& { return sums_[at]; },
        [&](LocalId c, const Moments& around) {
          const std::size_t at = floor + static_cast<std::size_t>(c);
          const Real mean = around.more / around.at.n;
          kept_[at] = 1 - std::clamp((mean - swelling_begins) / (swelling_full - swelling_begins), 0.0, 1.0);
          if (is_water(at)) fit_[at] = fit_of(spread_of(around.at), around.flow);
        });
  });
  halo.start_planes(fit_, grid.step(0));
  halo.finish();
  for_each_row(own, [&](LocalId k, LocalId r) {
    const std::size_t floor = grid.index(k, r, 0);
    for_each_tent<AffineMap>(
        grid, k, r, needed, [&](std::size_t at) -> const AffineMap& { return fit_[at]; },
        [&](LocalId c, const AffineMap& sum) {
          AffineMap& map = map_[floor + static_cast<std::size_t>(c)] = {};
          if (sum.weight > 0) map.add(sum, kept_[floor + static_cast<std::size_t>(c)] / sum.weight);
        });
  });
}

template void ShiftFilter::find(const CellOrder&, Halo&, const Motion&, std::span<const float>);
template void ShiftFilter::find(const CellOrder&, Halo&, const Motion&, std::span<const double>);

}  // namespace trevi
