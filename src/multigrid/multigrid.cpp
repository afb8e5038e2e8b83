#include "multigrid/multigrid.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <cstdint>

#include "parallel/waiting.hpp"
#include "trevi/session.hpp"

namespace trevi {

namespace {

// The damping of a sweep: less than 1 to damp what changes sign from column to column.
constexpr Real damping = 0.8;
// Sweeps before and after the correction by the coarser level, and on the coarsest. With these a cycle reduces an error
// to between a tenth and a fifth; see tests/multigrid/test_multigrid.cpp.
constexpr int sweeps = 2, coarsest_sweeps = 4;

}  // namespace

void Multigrid::resize(const CellCuts& cuts, LocalId rows, LocalId columns, int depth) {
  const LocalId all_planes = cuts.planes.back();
  // Columns of the coarsest level are at least as wide as the water is deep.
  const LocalId widest = std::max(all_planes, rows);
  const auto useful = 1 + std::bit_width(static_cast<unsigned>(std::max(depth, 1)));
  const auto possible = 1 + std::bit_width(static_cast<unsigned>(widest - 1));
  const auto count = static_cast<std::size_t>(std::min(useful, possible));
  const bool same_cuts = cuts == cuts_ && rows == all_rows_ && count == levels_.size();
  if (!same_cuts) cuts_ = cuts;
  all_rows_ = rows;
  levels_.resize(count);
  const CellWindow own = own_window(0);
  levels_[0].cells.resize({.first = own.planes.begin,
                           .planes = own.planes.size(),
                           .rows = own.rows.size(),
                           .columns = columns,
                           .all_planes = all_planes,
                           .repeats = repeats_,
                           .first_row = own.rows.begin,
                           .all_rows = rows});
  levels_[0].cells.borrow_equation(*scratch_);
  for (std::size_t l = 0; l < levels_.size(); ++l) place_level(l, same_cuts);
}

// The cells of a level that begin in the window of this rank.
CellWindow Multigrid::own_window(std::size_t l) const {
  return window_on_level(cuts_.window(rank_of(comm_), all_rows_), static_cast<int>(l));
}

// The position of this rank on a level.
void Multigrid::place_level(std::size_t l, bool same_cuts) {
  const int number = static_cast<int>(l);
  Level& level = levels_[l];
  const CellWindow own = own_window(l);
  const LocalId planes = first_on_level(cuts_.planes.back(), number), rows = first_on_level(all_rows_, number);
  const bool was_gathered = level.gathered;
  const LocalId columns = levels_[0].cells.shape().columns;
  level.gathered = l > 0 && (levels_[l - 1].gathered || GlobalId{planes} * rows * columns <= gathered_);
  if (l > 0) {
    const CellWindow held = level.gathered ? CellWindow{{0, planes}, {0, rows}} : own;
    LevelShape shape{.first = held.planes.begin,
                     .planes = held.planes.size(),
                     .rows = held.rows.size(),
                     .columns = columns,
                     .all_planes = planes,
                     .repeats = repeats_,
                     .first_row = held.rows.begin,
                     .all_rows = rows};
    shape.width = LocalId{1} << number;
    shape.last_width = {cuts_.planes.back() - (planes - 1) * shape.width, all_rows_ - (rows - 1) * shape.width};
    level.cells.resize(shape);
  }
  if (!same_cuts || level.gathered != was_gathered) {
    level.peers = level.gathered ? CellPeers{} : cell_peers(cuts_, rank_of(comm_), number, {repeats_[0], repeats_[1]});
  }
  level.made = level.cells.shape().own_rows();
  if (is_gathered_here(l))
    level.made = {{own.planes.begin + 1, own.planes.end + 1}, own.rows.size(), columns, own.rows.begin};
}

// For fields of a gathered level: obtains the cells of all ranks. All fields are in one reduction, in which each cell
// has the bits from its owner and zeros from all others: the number of rounds is the logarithm of the number of ranks,
// and no count per rank is needed.
void Multigrid::gather(std::size_t l, std::initializer_list<Borrowed<Real>*> fields) {
  const LevelShape& shape = levels_[l].cells.shape();
  const std::size_t row = shape.step(1), rows = static_cast<std::size_t>(shape.rows);
  const std::size_t of_field = static_cast<std::size_t>(shape.planes) * rows * row, all = of_field * fields.size();
  Borrowed<Real> cells = scratch_->borrow<Real>(all);
  cells.fill(0);
  // Calls visit(index of a row of a field in the field, and in the reduction) for the rows of a window.
  const auto for_each_row_of = [&](const CellWindow& window, const auto& visit) {
    Real* packed = cells.data();
    for (auto* field : fields) {
      for (LocalId k = window.planes.begin; k < window.planes.end; ++k) {
        for (LocalId r = window.rows.begin; r < window.rows.end; ++r) {
          const std::size_t place = static_cast<std::size_t>(k) * rows + static_cast<std::size_t>(r);
          visit(field->data() + shape.index(k + 1, r, -1), packed + place * row);
        }
      }
      packed += of_field;
    }
  };
  for_each_row_of(own_window(l), [&](Real* in_field, Real* packed) { std::copy_n(in_field, row, packed); });
  static_assert(sizeof(Real) == sizeof(std::uint64_t));
  all_reduce(comm_, cells.data(), static_cast<int>(all), MPI_UINT64_T, MPI_BOR);
  for_each_row_of({{0, shape.planes}, {0, shape.rows}},
                  [&](Real* in_field, Real* packed) { std::copy_n(packed, row, in_field); });
}

// Fields of the coarse levels from those of the finest, and the values that levels lack in their ghost planes.
void Multigrid::join_levels(Halo& halo, bool among_solids) {
  for (std::size_t l = 0; l < levels_.size(); ++l) {
    MultigridLevel& cells = levels_[l].cells;
    if (l > 0) {
      levels_[l - 1].cells.coarsen(cells, levels_[l].made, among_solids);
      complete(l, {&cells.link[0], &cells.link[1], &cells.link[2], &cells.dirichlet}, halo);
    } else {
      complete(l, {&cells.dirichlet}, halo);
      // Links are known in the plane above; in the row after the own rows, only those across their lower faces.
      if (cells.shape().rows_are_cut()) complete(l, {&cells.link[0], &cells.link[1], &cells.link[2]}, halo);
    }
    for (auto& field : cells.link) cells.repeat(field);
    if (among_solids && !levels_[l].gathered && l + 1 < levels_.size()) {  // also of the cells before the own ones
      exchange(levels_[l], halo, cells.link[0]);
      if (cuts_.parts > 1) exchange(levels_[l], halo, cells.link[1]);
    }
    cells.factor();
    exchange(levels_[l], halo, cells.per_pivot);
  }
}

void Multigrid::exchange(Level& level, Halo& halo, Borrowed<Real>& field) const {
  halo.start_cells(field, level.cells.shape().step(0), level.peers);
  halo.finish();
  level.cells.repeat(field);
}

// Obtains the cells of fields that other ranks have made and this one needs.
void Multigrid::complete(std::size_t l, std::initializer_list<Borrowed<Real>*> fields, Halo& halo) {
  if (is_gathered_here(l)) return gather(l, fields);
  const CellPeers upper = upper_zones(levels_[l].peers);
  for (auto* field : fields) halo.start_cells(*field, levels_[l].cells.shape().step(0), upper);
  halo.finish();
}

void Multigrid::solve(Halo& halo, int cycles, bool among_solids) {
  finest().borrow_for_cycles(*scratch_);
  for (std::size_t l = 1; l < levels_.size(); ++l) {
    levels_[l].cells.borrow_equation(*scratch_);
    levels_[l].cells.borrow_for_cycles(*scratch_);
  }
  join_levels(halo, among_solids);
  finest().repeat(finest().phi);
  if (finest().shape().rows_are_cut()) exchange(levels_[0], halo, finest().phi);
  improve(halo, cycles);
}

void Multigrid::improve(Halo& halo, int cycles) {
  for (int k = 0; k < cycles; ++k) cycle(halo);
}

void Multigrid::give_back_all_but_phi() {
  for (std::size_t l = 1; l < levels_.size(); ++l) levels_[l].cells.give_back();
  finest().give_back_all_but_phi();
}

void Multigrid::cycle(Halo& halo) {
  for (std::size_t l = 0; l + 1 < levels_.size(); ++l) {
    Level& level = levels_[l];
    if (l > 0) sweep_from_zero(level, halo, damping);
    for (int s = l > 0 ? 1 : 0; s < sweeps; ++s) sweep(level, halo, damping);
    level.cells.find_residual();
    halo.start_cells(level.cells.next, level.cells.shape().step(0), upper_zones(level.peers));
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

// A single column is solved exactly by one sweep.
void Multigrid::sweep_coarsest(Halo& halo) {
  Level& level = levels_.back();
  const bool single = level.cells.shape().all_planes == 1 && level.cells.shape().all_rows == 1;
  const int count = single ? 1 : coarsest_sweeps;
  const Real weight = single ? 1 : damping;
  if (levels_.size() > 1) sweep_from_zero(level, halo, weight);
  for (int s = levels_.size() > 1 ? 1 : 0; s < count; ++s) sweep(level, halo, weight);
}

// What the neighbours wait for is sent first.
void Multigrid::sweep(Level& level, Halo& halo, Real weight) const {
  const LocalId planes = level.cells.shape().planes, rows = level.cells.shape().rows;
  // The rows of a plane at either end; even if a rank has all rows of a level, others access them.
  const LocalId beside = cuts_.parts > 1 ? 1 : 0;
  const Range inner{beside, rows - beside};
  const bool ahead = !level.gathered && planes > 1 && inner.size() > 0 && size_of(comm_) > 1;
  if (ahead) {
    level.cells.sweep({1, 2}, {0, rows}, weight);
    level.cells.sweep({planes, planes + 1}, {0, rows}, weight);
    for (const Range& of_plane : {Range{0, inner.begin}, Range{inner.end, rows}})
      if (of_plane.size() > 0) level.cells.sweep({2, planes}, of_plane, weight);
  } else {
    level.cells.sweep({1, planes + 1}, {0, rows}, weight);
  }
  halo.start_cells(level.cells.next, level.cells.shape().step(0), level.peers);
  if (ahead) level.cells.sweep({2, planes}, inner, weight);
  show_next(level, halo);
}

void Multigrid::sweep_from_zero(Level& level, Halo& halo, Real weight) const {
  level.cells.sweep_from_zero(weight);
  halo.start_cells(level.cells.next, level.cells.shape().step(0), level.peers);
  show_next(level, halo);
}

void Multigrid::show_next(Level& level, Halo& halo) const {
  halo.finish();
  level.cells.repeat(level.cells.next);
  level.cells.show_next();
}

std::size_t Multigrid::bytes() const {
  std::size_t sum = (cuts_.planes.capacity() + cuts_.rows.capacity()) * sizeof(LocalId);
  for (const Level& level : levels_) sum += level.cells.bytes();
  return sum;
}

}  // namespace trevi
