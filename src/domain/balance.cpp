#include "domain/balance.hpp"

#include <algorithm>

#include "parallel/reductions.hpp"
#include "parallel/waiting.hpp"
#include "trevi/session.hpp"

namespace trevi {

namespace {

constexpr Real pairs_per_particle = 20;

}  // namespace

Real work_of(const NeighbourList& list, Range particles) {
  return static_cast<Real>(list.pairs(particles)) + pairs_per_particle * particles.size();
}

Real plane_work(const CellOrder& order, const NeighbourList& list, LocalId k, LocalId l) {
  return work_of(list, order.owned_range(k, l));
}

// Whole numbers, so that no order of a sum is seen.
std::vector<Real> Balance::work_of_planes(const CellOrder& order, const NeighbourList& list, const Slabs& slabs) const {
  std::vector<Real> mine;
  for (LocalId k = 0; k < order.planes(); ++k) mine.push_back(plane_work(order, list, k, k + 1));
  if (slabs.parts() == 1) return gather_planes(comm_, mine);
  std::vector<Real> all(static_cast<std::size_t>(order.grid().planes()), 0.0);
  std::copy(mine.begin(), mine.end(), all.begin() + order.window().planes.begin);
  all_reduce(comm_, all.data(), static_cast<int>(all.size()), MPI_DOUBLE, MPI_SUM);
  return all;
}

// For each row of each of these slabs, which need not be those that the particles are in.
std::vector<Real> Balance::work_of_rows(const CellOrder& order, const NeighbourList& list, const Slabs& slabs) const {
  const auto rows = static_cast<std::size_t>(order.grid().rows());
  std::vector<Real> all(static_cast<std::size_t>(slabs.slabs()) * rows, 0.0);
  const CellWindow& own = order.window();
  for (LocalId k = 0; k < order.planes(); ++k) {
    const auto first = static_cast<std::size_t>(slabs.slab_of(own.planes.begin + k)) * rows;
    for (LocalId r = 0; r < order.rows(); ++r) {
      const Range row = order.row(k + 1, r);
      all[first + static_cast<std::size_t>(own.rows.begin + r)] +=
          work_of(list, {row.begin - order.low_ghosts(), row.end - order.low_ghosts()});
    }
  }
  all_reduce(comm_, all.data(), static_cast<int>(all.size()), MPI_DOUBLE, MPI_SUM);
  return all;
}

void Balance::update(std::int64_t step, const CellOrder& order, const NeighbourList& list, Slabs& slabs) {
  if (slabs.ranks() == 1 || step % interval != 0) return;
  const std::vector<Real> work = work_of_planes(order, list, slabs);
  const bool rows_are_cut = slabs.parts() > 1;
  const Real now = rows_are_cut ? slabs.imbalance_of_rows(work_of_rows(order, list, slabs)) : slabs.imbalance(work);
  ++history_.looks;
  history_.sum += now;
  history_.max = std::max(history_.max, now);
  Slabs even(work, slabs.slabs());
  Real then = even.imbalance(work);
  if (rows_are_cut) {
    const std::vector<Real> of_rows = work_of_rows(order, list, even);
    even.cut_rows(of_rows, slabs.parts());
    then = even.imbalance_of_rows(of_rows);
  }
  // Where there is little water a rank may get many empty planes, more than it can count the cells of.
  if (then > now - min_gain_ || !even.cells_fit(order.grid())) return;
  slabs = std::move(even);
  ++history_.moves;
}

}  // namespace trevi
