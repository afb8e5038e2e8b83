// The halo traffic of a step of water at rest, by the formula of postprocess/results/scaling.md, before a run and
// without particles. It is exact if the water is equally high in the whole box, the cuts of neighbouring slabs are
// aligned, nothing is periodic and there are no obstacles. Not collective.
#pragma once

#include "particles/cell_grid.hpp"
#include "trevi/settings.hpp"

namespace trevi {

struct RestingWater {
  LocalId planes = 1, rows = 1, columns = 1;  ///< numbers of cells of the box
  LocalId wet_columns = 1;                    ///< number of water cells above one another
  Real particles_per_row = 0;                 ///< for a row of a plane
  Real particles_per_cell = 1;                ///< for a full cell
  int iterations = 1;
  Real record_bytes = 0;  ///< per particle
  bool projected = true;
  bool upright = true;                     ///< under gravity, where the result of the noise filter is sent, too
  bool viscous = false, swirling = false;  ///< velocities are filtered
  bool gradients = false;                  ///< and their gradients exchanged, for nu
};

/// Water of `particles` that are equally high in the whole box.
RestingWater resting_water(const Settings& settings, const CellGrid& grid, Real particles);

/// The cells of one rank, of a node, or of all ranks, from which data are sent.
struct TrafficBlock {
  Real slab_sides = 0, part_sides = 0;  ///< number of sides with another rank: of slabs, and within slabs
  LocalId planes = 1, rows = 1;
  Real slabs = 1, parts = 1;  ///< ranks side by side along these sides
  bool rows_are_cut = false;
};
/// The block of all ranks of a run.
TrafficBlock all_ranks(const RestingWater& water, int slabs, int parts);

struct Traffic {
  Real bytes = 0, messages = 0;
};
Traffic halo_traffic(const RestingWater& water, const TrafficBlock& block);

}  // namespace trevi
