#include "domain/balance.hpp"

#include <algorithm>

#include "parallel/reductions.hpp"

namespace trevi {

namespace {

constexpr Real pairs_per_particle = 20;

}  // namespace

Real plane_work(const CellOrder& order, const NeighbourList& list, LocalId k, LocalId l) {
  const auto [begin, end] = order.owned_range(k, l);
  return static_cast<Real>(list.pairs({begin, end})) + pairs_per_particle * (end - begin);
}

void Balance::update(std::int64_t step, const CellOrder& order, const NeighbourList& list, Slabs& slabs) {
  if (slabs.ranks() == 1 || step % interval != 0) return;
  std::vector<Real> mine;
  mine.reserve(static_cast<std::size_t>(order.planes()));
  for (LocalId k = 0; k < order.planes(); ++k) mine.push_back(plane_work(order, list, k, k + 1));
  const std::vector<Real> work = gather_planes(comm_, mine);
  const Real now = slabs.imbalance(work);
  ++history_.looks;
  history_.sum += now;
  history_.max = std::max(history_.max, now);
  Slabs even(work, slabs.ranks());
  // Where there is little water a rank may get many empty planes, more than it can count the cells of.
  if (even.imbalance(work) > now - min_gain_ || !even.cells_fit(order.grid().cells_per_plane())) return;
  slabs = std::move(even);
  ++history_.moves;
}

}  // namespace trevi
