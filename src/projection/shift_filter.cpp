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
  const auto begin = static_cast<std::ptrdiff_t>(surface_.grid().index(k, r, 0));
  const auto count = std::ptrdiff_t{surface_.grid().columns(k, r)} + 1;
  std::fill_n(sums_.begin() + begin, count, Sums{});
  std::fill_n(fit_.begin() + begin, count, AffineMap{});
}

template <class T>
void ShiftFilter::find(const CellOrder& order, Halo& halo, const Motion& shifts, std::span<const T> compression) {
  const ProjectionGrid& grid = surface_.grid();
  const ParticlesToGrid& water = surface_.water();
  const CellRows own = grid.rows_of({1, grid.planes() + 1});
  for_each_row(own, [&](LocalId k, LocalId r) {
    for (LocalId c = 0; c < grid.columns(k, r); ++c) {
      const CellParticles cell = water.particles_of(order, shifts, k, r, c);
      Sums& sums = sums_[grid.index(k, r, c)];
      sums = {};
      if (cell.begin == cell.end) continue;
      const MotionSums motion = sum_motion(water.frame(), shifts, cell);
      const auto n = static_cast<Real>(cell.end - cell.begin);
      sums.at = {n, motion.y, motion.yy};
      sums.flow = {motion.u, motion.uy};
      for (std::size_t i = cell.begin; i < cell.end; ++i) sums.compression += static_cast<Real>(compression[i]);
    }
  });
  halo.start_planes(sums_, grid.step(0));
  halo.finish();
  for_each_row(own, [&](LocalId k, LocalId r) {
    std::vector<Sums> memory;
    const std::size_t floor = grid.index(k, r, 0);
    for_each_tent(
        grid, k, r, memory, [&](std::size_t at) -> const Sums& { return sums_[at]; },
        [&](LocalId c, const Sums& around) {
          const std::size_t at = floor + static_cast<std::size_t>(c);
          const Real mean = around.at.n > 0 ? around.compression / around.at.n : 0;
          kept_[at] = 1 - std::clamp((mean - swelling_begins) / (swelling_full - swelling_begins), 0.0, 1.0);
          fit_[at] = is_water(at) ? fit_of(spread_of(around.at), around.flow) : AffineMap{};
        });
  });
  halo.start_planes(fit_, grid.step(0));
  halo.finish();
  for_each_row(own, [&](LocalId k, LocalId r) {
    std::vector<AffineMap> memory;
    const std::size_t floor = grid.index(k, r, 0);
    for_each_tent(
        grid, k, r, memory, [&](std::size_t at) -> const AffineMap& { return fit_[at]; },
        [&](LocalId c, const AffineMap& sum) {
          const std::size_t at = floor + static_cast<std::size_t>(c);
          map_[at] = {};
          if (sum.weight > 0) map_[at].add(sum, kept_[at] / sum.weight, {});
        });
  });
}

template void ShiftFilter::find(const CellOrder&, Halo&, const Motion&, std::span<const float>);
template void ShiftFilter::find(const CellOrder&, Halo&, const Motion&, std::span<const double>);

}  // namespace trevi
