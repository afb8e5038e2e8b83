// What halos send in a step of water at rest, by the formula of postprocess/results/scaling.md, before a run and
// without particles. Exact where the water stands equally high in the whole box, the cuts of neighbour slabs meet,
// nothing is periodic and there are no obstacles. Not collective.
#pragma once

#include "particles/cell_grid.hpp"
#include "trevi/settings.hpp"

namespace trevi {

struct RestingWater {
  LocalId planes = 1, rows = 1, columns = 1;  ///< cells of the box
  LocalId wet_columns = 1;                    ///< cells of water above one another
  Real particles_per_row = 0;                 ///< of a row of a plane
  Real particles_per_cell = 1;                ///< where it is full
  int iterations = 1;
  Real record_bytes = 0;  ///< of a particle
  bool projected = true;
  bool upright = true;  ///< under gravity, where the flow that the filter of noise leaves is sent, too
  bool viscous = false, swirling = false;  ///< velocities are filtered
  bool gradients = false;                  ///< and their gradients exchanged, for nu
};

/// `particles` as if they stood equally high in the whole box.
RestingWater resting_water(const Settings& settings, const CellGrid& grid, Real particles);

/// Cells that one rank has, those of a node, or of all ranks, and what is sent from there.
struct TrafficBlock {
  Real slab_sides = 0, part_sides = 0;  ///< sides on which there is another rank: of slabs, and within slabs
  LocalId planes = 1, rows = 1;
  Real slabs = 1, parts = 1;  ///< ranks side by side along these sides
  bool rows_are_cut = false;
};
/// Of all ranks of a run.
TrafficBlock all_ranks(const RestingWater& water, int slabs, int parts);

struct Traffic {
  Real bytes = 0, messages = 0;
};
Traffic halo_traffic(const RestingWater& water, const TrafficBlock& block);

}  // namespace trevi
