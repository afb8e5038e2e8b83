#include "solver/halo_traffic.hpp"

#include <algorithm>
#include <bit>
#include <cmath>

namespace trevi {

namespace {

constexpr Real number_bytes = 8;
constexpr int v_cycles = 3, cycle_sweeps = 4;  // of the multigrid, and in a cycle on each level
constexpr Real gathered_cells = 4096;          // largest number of cells of levels that all ranks hold

// Numbers of rows of planes that are sent, or of messages: to neighbouring slabs, within slabs, across corners.
struct Zones {
  Real beside, within, across;
  Real all() const { return beside + within + across; }
  Real upper() const { return beside / 2 + within / 2 + across / 4; }
  Real of_rows() const { return within + across; }
};

class Sum {
 public:
  Sum(const RestingWater& water, const TrafficBlock& block)
      : water_(water),
        block_(block),
        messages_{block.slab_sides * block.parts, block.part_sides * block.slabs, across()} {
    columns_ = 4 * std::ceil((water.wet_columns + 2) / 4.0);
  }
  Traffic traffic() const { return traffic_; }

  void add_records() {
    const Real again = water_.projected ? 1 : 0;  // positions after the filtered shifts, scalars of the water in flight
    const Real laplacians = water_.gradients ? 2 : 0, curls = water_.swirling ? 1 : 0;
    const Real velocities = water_.gradients ? laplacians : water_.viscous ? 1 : 0;
    const Real gradients = 3 * laplacians, weights = laplacians;  // the last of the three with the weight
    const Real places = 1 + water_.iterations + again + velocities + curls + gradients;
    const Real scalars = water_.iterations + curls;
    const Real records = water_.particles_per_row * water_.record_bytes * (3 * places + scalars + weights) / 4;
    add(zones(block_.planes, block_.rows).all() * (4.0 * water_.columns + records),
        messages_.all() * (1 + places + scalars));
  }

  // In addition to the multigrid: heights of the water, volumes and moments of cells, fits, moments of shifts and their
  // fits; and the fill of cells.
  void add_projection() {
    constexpr Real volumes = 3, moments = 23, fit = 13, flow = 12;
    const Real noise = water_.upright ? flow + fit : 0, ring = columns_ + 2;
    const Zones rows = zones(block_.planes, ringed(block_.rows));
    // For whole planes, the cells of the water and those above it; where rows are cut, all cells.
    const Real held = block_.rows_are_cut ? columns_ : std::min(water_.wet_columns + 1, water_.columns);
    add(rows.all() * 4 + zones(block_.planes, block_.rows).all() * 4 * std::ceil(held / 4) * number_bytes *
                             (volumes + 2 * (moments + fit) + noise),
        messages_.all() * (water_.upright ? 7 : 5));
    add(rows.beside * number_bytes * ring, messages_.beside);
    // Volumes that rows contribute to each other, wet cells, heights of the surface, masses, links, the final pressure.
    add(rows.of_rows() * (9 * number_bytes * columns_ + ring + 4 * number_bytes * ring), messages_.of_rows() * 6);
  }

  void add_multigrid() {
    LocalId planes = water_.planes, rows = water_.rows, own_planes = block_.planes, own_rows = block_.rows;
    const int levels = level_count();
    for (int level = 0; level < levels; ++level) {
      if (level > 0 && Real{1} * planes * rows * columns_ <= gathered_cells) return;
      const bool first = level == 0 && block_.rows_are_cut;
      const Real all = 1 + cycle_sweeps * v_cycles + (first ? 1 : 0);
      const Real upper = (level > 0 || first ? 4 : 1) + (level + 1 < levels ? v_cycles : 0);
      const Zones of_level = zones(own_planes, ringed(own_rows));
      add(number_bytes * (columns_ + 2) * (all * of_level.all() + upper * of_level.upper()),
          all * messages_.all() + upper * messages_.upper());
      for (LocalId* cells : {&planes, &rows, &own_planes, &own_rows}) *cells = (*cells + 1) / 2;
    }
  }

 private:
  Real across() const { return block_.slab_sides * block_.part_sides; }
  Zones zones(LocalId planes, LocalId rows) const {
    return {block_.slab_sides * rows, block_.part_sides * planes, across()};
  }
  // Where rows are not cut, planes are sent with the ring around them.
  LocalId ringed(LocalId rows) const { return rows + (block_.rows_are_cut ? 0 : 2); }
  int level_count() const {
    const auto useful = std::bit_width(static_cast<unsigned>(std::max(water_.wet_columns, 1)));
    const auto possible = std::bit_width(static_cast<unsigned>(std::max(water_.planes, water_.rows) - 1));
    return 1 + static_cast<int>(std::min(useful, possible));
  }
  void add(Real bytes, Real messages) {
    traffic_.bytes += bytes;
    traffic_.messages += messages;
  }

  const RestingWater& water_;
  const TrafficBlock& block_;
  Zones messages_;
  Real columns_;  // of the coarse grid
  Traffic traffic_;
};

}  // namespace

RestingWater resting_water(const Settings& settings, const CellGrid& grid, Real particles) {
  RestingWater water{.planes = grid.planes(), .rows = grid.rows(), .columns = grid.columns()};
  water.particles_per_row = particles / (Real{1} * water.planes * water.rows);
  const Vec3 cell = (settings.domain.max - settings.domain.min)
                        .cwiseQuotient(grid.axis(0) == 0 ? Vec3(water.planes, water.rows, water.columns)
                                                         : Vec3(water.rows, water.planes, water.columns));
  water.particles_per_cell = cell.prod() / std::pow(settings.fluid.spacing, 3);
  constexpr Real rounding = 1e-6;
  const Real high = std::ceil(water.particles_per_row / water.particles_per_cell - rounding);
  water.wet_columns = static_cast<LocalId>(std::clamp<Real>(high, 1, water.columns));
  water.iterations = settings.density.iterations;
  water.record_bytes = settings.density.precision == Precision::single ? 16 : 32;
  water.projected = settings.density.coarse_grid;
  water.upright = settings.gravity && !settings.gravity->isZero();
  water.viscous = settings.viscosity.has_value() || settings.kinematic_viscosity.has_value();
  water.gradients = settings.kinematic_viscosity.has_value();
  water.swirling = settings.vorticity.has_value();
  return water;
}

TrafficBlock all_ranks(const RestingWater& water, int slabs, int parts) {
  return {2.0 * (slabs - 1), 2.0 * (parts - 1), water.planes, water.rows, Real(slabs), Real(parts), parts > 1};
}

Traffic halo_traffic(const RestingWater& water, const TrafficBlock& block) {
  Sum sum(water, block);
  sum.add_records();
  if (water.projected) sum.add_projection();
  if (water.projected) sum.add_multigrid();
  return sum.traffic();
}

}  // namespace trevi
