#include "domain/balance.hpp"

#include <algorithm>
#include <numeric>
#include <utility>

#include "parallel/reductions.hpp"
#include "parallel/waiting.hpp"
#include "trevi/session.hpp"

namespace trevi {

namespace {

constexpr Real pairs_per_particle = 20;

// The work of the owned rows in each of the slabs of `next`, from number `first` to `last`, that contain owned planes.
std::vector<std::vector<Real>> work_of_own_rows(const CellOrder& order, const NeighbourList& list, const Slabs& next,
                                                int first, int last) {
  const std::vector<Real> none(static_cast<std::size_t>(order.rows()), 0.0);
  std::vector<std::vector<Real>> work(static_cast<std::size_t>(last - first) + 1, none);
  for (LocalId k = 0; k < order.planes(); ++k) {
    const int slab = next.slab_of(order.window().planes.begin + k);
    for (LocalId r = 0; r < order.rows(); ++r) {
      const Range row = order.row(k + 1, r);
      work[static_cast<std::size_t>(slab - first)][static_cast<std::size_t>(r)] +=
          work_of(list, {row.begin - order.low_ghosts(), row.end - order.low_ghosts()});
    }
  }
  return work;
}

}  // namespace

Real work_of(const NeighbourList& list, Range particles) {
  return static_cast<Real>(list.pairs(particles)) + pairs_per_particle * particles.size();
}

Real plane_work(const CellOrder& order, const NeighbourList& list, LocalId k, LocalId l) {
  return work_of(list, order.owned_range(k, l));
}

void cut_rows(MPI_Comm comm, std::span<const Real> weights, int parts, Slabs& slabs) {
  const std::vector<LocalId> mine = weights.empty() ? std::vector<LocalId>{} : even_cuts(weights, parts);
  std::vector<int> counts(static_cast<std::size_t>(size_of(comm)), 0), places(counts.size(), 0);
  for (int slab = 0; slab < slabs.slabs(); ++slab) {
    counts[static_cast<std::size_t>(slab * parts)] = parts + 1;
    places[static_cast<std::size_t>(slab * parts)] = slab * (parts + 1);
  }
  std::vector<LocalId> rows(static_cast<std::size_t>(slabs.slabs()) * (static_cast<std::size_t>(parts) + 1));
  MPI_Allgatherv(mine.data(), static_cast<int>(mine.size()), MPI_INT32_T, rows.data(), counts.data(), places.data(),
                 MPI_INT32_T, comm);
  slabs.set_rows(std::move(rows), parts);
}

// Whole numbers, so that sums do not depend on the order.
std::vector<Real> Balance::work_of_planes(const CellOrder& order, const NeighbourList& list, const Slabs& slabs) const {
  std::vector<Real> mine;
  for (LocalId k = 0; k < order.planes(); ++k) mine.push_back(plane_work(order, list, k, k + 1));
  if (slabs.parts() == 1) return gather_over_ranks(comm_, mine);
  std::vector<Real> all(static_cast<std::size_t>(order.grid().planes()), 0.0);
  std::copy(mine.begin(), mine.end(), all.begin() + order.window().planes.begin);
  all_reduce(comm_, all.data(), static_cast<int>(all.size()), MPI_DOUBLE, MPI_SUM);
  return all;
}

// On the first rank of each slab, the work of the rows of the slab of `next` with the same number, which is not yet cut
// inside; empty on other ranks. The particles are in the slabs of `now`, and each rank has its own rows of its own
// planes.
std::vector<Real> Balance::work_of_rows(const CellOrder& order, const NeighbourList& list, const Slabs& now,
                                        const Slabs& next) const {
  const int rank = rank_of(comm_), parts = now.parts();
  const CellWindow& own = order.window();
  const int first = next.slab_of(own.planes.begin), last = next.slab_of(own.planes.end - 1);
  std::vector<std::vector<Real>> given = work_of_own_rows(order, list, next, first, last);
  std::vector<MPI_Request> requests;
  for (int slab = first; slab <= last; ++slab) {
    std::vector<Real>& rows = given[static_cast<std::size_t>(slab - first)];
    MPI_Isend(rows.data(), static_cast<int>(rows.size()), MPI_DOUBLE, slab * parts, 0, comm_, &requests.emplace_back());
  }
  std::vector<std::pair<Range, std::vector<Real>>> received;  // each with its rows
  if (rank % parts == 0) {
    const int mine = rank / parts;
    for (int slab = now.slab_of(next.first_plane(mine)); slab <= now.slab_of(next.end_plane(mine) - 1); ++slab) {
      for (int from = slab * parts; from < (slab + 1) * parts; ++from) {
        const Range rows = now.window(from, order.grid().rows()).rows;
        auto& [of, work] = received.emplace_back(rows, std::vector<Real>(static_cast<std::size_t>(rows.size())));
        MPI_Irecv(work.data(), static_cast<int>(work.size()), MPI_DOUBLE, from, 0, comm_, &requests.emplace_back());
      }
    }
  }
  wait_all(requests);
  std::vector<Real> all(received.empty() ? 0 : static_cast<std::size_t>(order.grid().rows()), 0.0);
  for (const auto& [rows, work] : received)
    for (std::size_t r = 0; r < work.size(); ++r) all[static_cast<std::size_t>(rows.begin) + r] += work[r];
  return all;
}

// Cuts the slabs of `next` inside; returns their imbalance after that.
Real Balance::cut_rows(const CellOrder& order, const NeighbourList& list, const Slabs& now, Slabs& next) const {
  const int parts = now.parts();
  const std::vector<Real> work = work_of_rows(order, list, now, next);
  trevi::cut_rows(comm_, work, parts, next);
  Real most = 0;
  if (!work.empty()) {
    for (int rank = rank_of(comm_); rank < rank_of(comm_) + parts; ++rank) {
      const Range rows = next.window(rank, order.grid().rows()).rows;
      most = std::max(most, std::accumulate(work.begin() + rows.begin, work.begin() + rows.end, 0.0));
    }
  }
  return imbalance_of(most, std::accumulate(work.begin(), work.end(), 0.0), now.ranks());
}

// From the largest work of any rank that this rank knows of, and from the work for which it is responsible.
Real Balance::imbalance_of(Real most, Real sum, int ranks) const {
  all_reduce(comm_, &most, 1, MPI_DOUBLE, MPI_MAX);
  all_reduce(comm_, &sum, 1, MPI_DOUBLE, MPI_SUM);
  return sum > 0 ? most * ranks / sum : 1;
}

void Balance::update(std::int64_t step, const CellOrder& order, const NeighbourList& list, Slabs& slabs) {
  if (slabs.ranks() == 1 || step % interval != 0) return;
  const std::vector<Real> work = work_of_planes(order, list, slabs);
  const bool rows_are_cut = slabs.parts() > 1;
  const Real own = rows_are_cut ? plane_work(order, list, 0, order.planes()) : 0;
  const Real now = rows_are_cut ? imbalance_of(own, own, slabs.ranks()) : slabs.imbalance(work);
  ++history_.looks;
  history_.sum += now;
  history_.max = std::max(history_.max, now);
  Slabs even(work, slabs.slabs());
  const Real then = rows_are_cut ? cut_rows(order, list, slabs, even) : even.imbalance(work);
  // Where there is little water, a rank may get many empty planes, with more cells than it can count.
  if (then > now - min_gain_ || !even.cells_fit(order.grid())) return;
  slabs = std::move(even);
  ++history_.moves;
}

}  // namespace trevi
