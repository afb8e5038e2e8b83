#include "solver/ranks_by_model.hpp"

#include <algorithm>
#include <limits>

namespace trevi {

namespace {

// A cluster of the model, CHOICE of postprocess/scaling_model.py: seconds per particle and step and per message, bytes
// per second between ranks and out of a node, ranks per node.
constexpr Real particle_seconds = 465e-9, message_seconds = 2e-6, between_ranks = 8.1e9, out_of_node = 12e9;
constexpr int node_ranks = 64;

int quotient_up(int a, int b) { return (a + b - 1) / b; }
Real sides(int pieces) { return std::min(pieces - 1, 2); }

}  // namespace

Real step_by_model(const RestingWater& water, int slabs, int parts) {
  const bool cut = parts > 1;
  const LocalId planes = quotient_up(water.planes, slabs), rows = quotient_up(water.rows, parts);
  const Traffic of_rank = halo_traffic(water, {sides(slabs), sides(parts), planes, rows, 1, 1, cut});
  // The ranks of a slab have consecutive numbers, and so do those of a node.
  const int node_parts = std::min(parts, node_ranks), node_slabs = std::min(slabs, std::max(node_ranks / parts, 1));
  const Traffic of_node =
      halo_traffic(water, {sides(quotient_up(slabs, node_slabs)), sides(quotient_up(parts, node_parts)),
                           std::min(planes * node_slabs, water.planes), std::min(rows * node_parts, water.rows),
                           Real(node_slabs), Real(node_parts), cut});
  const Real work = Real{1} * planes * rows * water.particles_per_row * particle_seconds;
  return work + of_rank.messages * message_seconds +
         std::max(of_rank.bytes / between_ranks, of_node.bytes / out_of_node);
}

std::array<int, 2> ranks_by_model(const RestingWater& water, int ranks) {
  std::array<int, 2> best{ranks, 1};
  Real least = std::numeric_limits<Real>::infinity();
  for (int parts = 1; parts <= std::min(ranks, water.rows); ++parts) {
    const int slabs = ranks / parts;
    if (slabs * parts != ranks || slabs > water.planes) continue;
    const Real seconds = step_by_model(water, slabs, parts);
    if (seconds < least) best = {slabs, parts};
    least = std::min(least, seconds);
  }
  return best;
}

}  // namespace trevi
