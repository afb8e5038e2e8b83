// [domain] ranks = "auto": the number of slabs into which the box is cut, and the number of parts of each slab, by the
// model of postprocess/results/scaling.md, whose published form is postprocess/scaling_model.py. Not collective.
#pragma once

#include <array>

#include "solver/halo_traffic.hpp"

namespace trevi {

/// Time of a step on the rank with the largest number of cells, s. Each of its particles takes the time of one on a
/// core. Its messages take their latency, and their bytes take the bandwidth between ranks or, for all ranks of a node
/// together, that out of the node.
Real step_by_model(const RestingWater& water, int slabs, int parts);

/// The numbers of slabs and parts, for `ranks` in all, for which this time is shortest; among equal times the one with
/// fewer parts. One slab per rank if no shape fits into the box, which first_slabs() refuses.
std::array<int, 2> ranks_by_model(const RestingWater& water, int ranks);

}  // namespace trevi
