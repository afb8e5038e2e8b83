#include "multigrid/multigrid.hpp"

#include <algorithm>
#include <bit>

#include "parallel/waiting.hpp"
#include "trevi/session.hpp"

namespace trevi {

namespace {

// The damping of a sweep: less than 1 to damp what changes sign from column to column.
constexpr Real damping = 0.8;
// Sweeps before and after the correction by the coarser level, and on the coarsest. With these a cycle leaves a tenth
// to a fifth of an error; see tests/multigrid/test_multigrid.cpp.
constexpr int sweeps = 2, coarsest_sweeps = 4;

LocalId half(LocalId count) { return (count + 1) / 2; }

}  // namespace

void Multigrid::resize(LocalId planes, LocalId rows, LocalId columns, int depth) {
  const auto ranks = static_cast<std::size_t>(size_of(comm_)), rank = static_cast<std::size_t>(rank_of(comm_));
  cuts_.assign(ranks + 1, 0);
  MPI_Allgather(&planes, 1, MPI_INT32_T, &cuts_[1], 1, MPI_INT32_T, comm_);
  for (std::size_t r = 0; r < ranks; ++r) cuts_[r + 1] += cuts_[r];
  // Columns of the coarsest level are at least as wide as the water is deep.
  const LocalId widest = std::max(cuts_.back(), rows);
  const auto useful = 1 + std::bit_width(static_cast<unsigned>(std::max(depth, 1)));
  const auto possible = 1 + std::bit_width(static_cast<unsigned>(widest - 1));
  levels_.resize(static_cast<std::size_t>(std::min(useful, possible)));
  levels_[0].cells.resize({cuts_[rank], planes, rows, columns, cuts_.back(), repeats_});
  for (std::size_t l = 0; l < levels_.size(); ++l) place_level(l);
}

// Where this rank stands on a level.
void Multigrid::place_level(std::size_t l) {
  const auto rank = static_cast<std::size_t>(rank_of(comm_));
  const int number = static_cast<int>(l);
  Level& level = levels_[l];
  const LocalId first = first_on_level(cuts_[rank], number), end = first_on_level(cuts_[rank + 1], number);
  const LocalId all = first_on_level(cuts_.back(), number);
  level.gathered = false;
  if (l > 0) {
    const LevelShape& finer = levels_[l - 1].cells.shape();
    const LocalId rows = half(finer.rows);
    level.gathered = levels_[l - 1].gathered || GlobalId{all} * rows * finer.columns <= gathered_;
    LevelShape shape{
        level.gathered ? 0 : first, level.gathered ? all : end - first, rows, finer.columns, all, repeats_};
    shape.width = LocalId{1} << number;
    shape.last_width = {cuts_.back() - (all - 1) * shape.width,
                        levels_[0].cells.shape().rows - (rows - 1) * shape.width};
    level.cells.resize(shape);
  }
  level.peers = level.gathered ? PlanePeers{} : peers_on_level(cuts_, rank_of(comm_), number, repeats_[0]);
  const bool each = l > 0 && levels_[l - 1].gathered;
  level.made = each ? Range{1, all + 1} : level.gathered ? Range{first + 1, end + 1} : Range{1, end - first + 1};
}

// Of fields of a gathered level: the planes of all ranks, in their order. All fields go in one message.
void Multigrid::gather(std::size_t l, std::initializer_list<std::vector<Real>*> fields) {
  const Level& level = levels_[l];
  const std::size_t plane = level.cells.shape().step(0);
  const auto all = static_cast<std::size_t>(level.cells.shape().planes);
  std::vector<int> counts, places;
  for (std::size_t r = 0; r + 1 < cuts_.size(); ++r) {
    const LocalId first = first_on_level(cuts_[r], static_cast<int>(l));
    const LocalId end = first_on_level(cuts_[r + 1], static_cast<int>(l));
    counts.push_back(static_cast<int>(static_cast<std::size_t>(end - first) * plane * fields.size()));
    places.push_back(static_cast<int>(static_cast<std::size_t>(first) * plane * fields.size()));
  }
  packed_.resize(all * plane * fields.size());
  // Where plane k of the field, counted from 1, stands in the message.
  const auto place = [&](std::size_t k, std::size_t field) { return ((k - 1) * fields.size() + field) * plane; };
  for (auto k = static_cast<std::size_t>(level.made.begin); k < static_cast<std::size_t>(level.made.end); ++k) {
    std::size_t number = 0;
    for (const auto* field : fields) std::copy_n(field->data() + k * plane, plane, packed_.data() + place(k, number++));
  }
  MPI_Request request;
  MPI_Iallgatherv(MPI_IN_PLACE, 0, MPI_DOUBLE, packed_.data(), counts.data(), places.data(), MPI_DOUBLE, comm_,
                  &request);
  wait_all({&request, 1});
  std::size_t number = 0;
  for (auto* field : fields) {
    for (std::size_t k = 1; k <= all; ++k)
      std::copy_n(packed_.data() + place(k, number), plane, field->data() + k * plane);
    ++number;
  }
}

// Fields of the coarse levels from those of the finest; and what levels do not know of their ghost planes.
void Multigrid::join_levels(Halo& halo) {
  for (std::size_t l = 0; l < levels_.size(); ++l) {
    MultigridLevel& cells = levels_[l].cells;
    if (l > 0) {
      levels_[l - 1].cells.coarsen(cells, levels_[l].made);
      complete(l, {&cells.link[0], &cells.link[1], &cells.link[2], &cells.dirichlet}, halo);
    } else {
      complete(l, {&cells.dirichlet}, halo);
    }
    for (auto& field : cells.link) cells.repeat(field);
    cells.factor();
    halo.start_planes(cells.per_pivot, cells.shape().step(0), levels_[l].peers);
    halo.finish();
    cells.repeat(cells.per_pivot);
  }
}

// Finds the planes of fields that other ranks have made and this one needs.
void Multigrid::complete(std::size_t l, std::initializer_list<std::vector<Real>*> fields, Halo& halo) {
  if (is_gathered_here(l)) return gather(l, fields);
  for (auto* field : fields) halo.start_planes(*field, levels_[l].cells.shape().step(0), downwards(levels_[l].peers));
  halo.finish();
}

void Multigrid::solve(Halo& halo, int cycles) {
  join_levels(halo);
  finest().repeat(finest().phi);
  for (int k = 0; k < cycles; ++k) cycle(halo);
}

void Multigrid::cycle(Halo& halo) {
  for (std::size_t l = 0; l + 1 < levels_.size(); ++l) {
    Level& level = levels_[l];
    if (l > 0) sweep_from_zero(level, halo, damping);
    for (int s = l > 0 ? 1 : 0; s < sweeps; ++s) sweep(level, halo, damping);
    level.cells.find_residual();
    halo.start_planes(level.cells.next, level.cells.shape().step(0), downwards(level.peers));
    halo.finish();
    level.cells.restrict_residual(levels_[l + 1].cells, levels_[l + 1].made);
    if (is_gathered_here(l + 1)) gather(l + 1, {&levels_[l + 1].cells.rhs});
  }
  sweep_coarsest(halo);
  for (std::size_t l = levels_.size() - 1; l-- > 0;) {
    levels_[l].cells.add_correction(levels_[l + 1].cells);
    for (int s = 0; s < sweeps; ++s) sweep(levels_[l], halo, damping);
  }
}

// A single column is solved at once.
void Multigrid::sweep_coarsest(Halo& halo) {
  Level& level = levels_.back();
  const LocalId planes = first_on_level(cuts_.back(), static_cast<int>(levels_.size()) - 1);
  const bool single = planes == 1 && level.cells.shape().rows == 1;
  const int count = single ? 1 : coarsest_sweeps;
  const Real weight = single ? 1 : damping;
  if (levels_.size() > 1) sweep_from_zero(level, halo, weight);
  for (int s = levels_.size() > 1 ? 1 : 0; s < count; ++s) sweep(level, halo, weight);
}

// What the neighbours wait for goes first.
void Multigrid::sweep(Level& level, Halo& halo, Real weight) const {
  const LocalId planes = level.cells.shape().planes;
  const bool ahead = !level.gathered && planes > 1 && size_of(comm_) > 1;
  if (ahead) {
    level.cells.sweep({1, 2}, weight);
    level.cells.sweep({planes, planes + 1}, weight);
  } else {
    level.cells.sweep({1, planes + 1}, weight);
  }
  halo.start_planes(level.cells.next, level.cells.shape().step(0), level.peers);
  if (ahead) level.cells.sweep({2, planes}, weight);
  show_next(level, halo);
}

void Multigrid::sweep_from_zero(Level& level, Halo& halo, Real weight) const {
  level.cells.sweep_from_zero(weight);
  halo.start_planes(level.cells.next, level.cells.shape().step(0), level.peers);
  show_next(level, halo);
}

void Multigrid::show_next(Level& level, Halo& halo) const {
  halo.finish();
  level.cells.repeat(level.cells.next);
  level.cells.show_next();
}

std::size_t Multigrid::bytes() const {
  std::size_t sum = cuts_.capacity() * sizeof(LocalId) + packed_.capacity() * sizeof(Real);
  for (const Level& level : levels_) sum += level.cells.bytes();
  return sum;
}

}  // namespace trevi
