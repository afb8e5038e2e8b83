// [domain] ranks = "auto": into how many slabs the box is cut, and into how many parts each of them, by the model of
// postprocess/results/scaling.md, whose published form is postprocess/scaling_model.py. Not collective.
#pragma once

#include <array>

#include "solver/halo_traffic.hpp"

namespace trevi {

/// Seconds of a step in the rank with the most cells. Its particles take what one takes on a core; its messages take
/// their latency, and their bytes the way between ranks or, of the ranks of a node together, that out of the node.
Real step_by_model(const RestingWater& water, int slabs, int parts);

/// Slabs and parts, `ranks` in all, for which that is shortest; of equal ones the one with fewer parts. A slab for each
/// rank where no shape fits into the box, which first_slabs() refuses.
std::array<int, 2> ranks_by_model(const RestingWater& water, int ranks);

}  // namespace trevi
