#include "particles/cell_order.hpp"

#include <algorithm>
#include <cassert>
#include <numeric>
#include <type_traits>
#include <utility>

#include "base/growth.hpp"
#include "base/threads.hpp"

namespace trevi {

// What a thread needs to sort the particles of a row of cells.
struct CellOrder::RowScratch {
  struct Entry {
    GlobalId id;
    LocalId index;
  };
  std::vector<Entry> sorted;
  std::vector<LocalId> columns, next;  // of each particle; for each cell the place of its next particle
};

// Fills places.order with the particles row by row of cells, within a row in the order in which they are stored. Each
// part of the particles is counted and placed by one thread.
void CellOrder::sort_by_rows(const Particles& particles, const Places& places) {
  const LocalId own_rows = this->rows(), rows = planes() * own_rows;
  // At most as many counters as particles.
  const LocalId parts = std::clamp(owned_ / rows, 1, thread_count());
  std::vector<LocalId> next(static_cast<std::size_t>(parts) * static_cast<std::size_t>(rows), 0);
  const auto counters = [&](LocalId part) {
    return next.data() + static_cast<std::size_t>(part) * static_cast<std::size_t>(rows);
  };
  const LocalId size = std::max(1, (owned_ + parts - 1) / parts);
  for_each_part({0, owned_}, size, [&](Range part) {
    LocalId* count = counters(part.begin / size);
    for (auto i = static_cast<std::size_t>(part.begin); i < static_cast<std::size_t>(part.end); ++i) {
      const LocalId plane = grid_.plane_of(particles.predicted[i]) - window_.planes.begin;
      const LocalId row_in_plane = grid_.row_of(particles.predicted[i]) - window_.rows.begin;
      assert(plane >= 0 && plane < planes() && row_in_plane >= 0 && row_in_plane < own_rows);
      const LocalId row = plane * own_rows + row_in_plane;
      // 32 bits are enough for the cells of one rank, which Slabs::check_capacity and Balance ensure.
      places.cell[i] = row * grid_.columns() + grid_.column_of(particles.predicted[i]);
      ++count[row];
    }
  });
  row_start_.resize(static_cast<std::size_t>(rows) + 1);
  LocalId start = 0;
  for (LocalId row = 0; row < rows; ++row) {
    row_start_[static_cast<std::size_t>(row)] = start;
    for (LocalId part = 0; part < parts; ++part) start += std::exchange(counters(part)[row], start);
  }
  row_start_.back() = start;
  for_each_part({0, owned_}, size, [&](Range part) {
    LocalId* place = counters(part.begin / size);
    for (LocalId i = part.begin; i < part.end; ++i)
      places.order[static_cast<std::size_t>(place[row_of(places.cell[static_cast<std::size_t>(i)])]++)] = i;
  });
}

// Sorts the particles of a row by cell, and within a cell by id: the order of arrival depends on the ranks, ids do not.
void CellOrder::sort_row(const Particles& particles, LocalId row, const Places& places, RowScratch& scratch) {
  const auto columns = static_cast<std::size_t>(grid_.columns());
  LocalId* counts = counts_.data() + static_cast<std::size_t>(row) * columns;
  std::fill_n(counts, columns, 0);
  const LocalId begin = row_start_[static_cast<std::size_t>(row)], end = row_start_[static_cast<std::size_t>(row) + 1];
  const std::span<LocalId> order(places.order.data() + begin, static_cast<std::size_t>(end - begin));
  scratch.columns.resize(order.size());
  for (std::size_t k = 0; k < order.size(); ++k) {
    scratch.columns[k] = places.cell[static_cast<std::size_t>(order[k])] - row * grid_.columns();
    ++counts[scratch.columns[k]];
  }
  scratch.next.resize(columns);
  std::exclusive_scan(counts, counts + columns, scratch.next.begin(), 0);
  scratch.sorted.resize(order.size());
  for (std::size_t k = 0; k < order.size(); ++k) {
    LocalId& place = scratch.next[static_cast<std::size_t>(scratch.columns[k])];
    scratch.sorted[static_cast<std::size_t>(place++)] = {particles.id[static_cast<std::size_t>(order[k])], order[k]};
  }
  auto cell = scratch.sorted.begin();
  for (std::size_t c = 0; c < columns; cell += counts[c++]) {
    if (counts[c] > 1) std::sort(cell, cell + counts[c], [](const auto& a, const auto& b) { return a.id < b.id; });
  }
  std::transform(scratch.sorted.begin(), scratch.sorted.end(), order.begin(),
                 [](const auto& entry) { return entry.index; });
}

template <class T>
void CellOrder::apply(const Borrowed<LocalId>& order, std::vector<T>& field, std::vector<T>& sorted) const {
  resize_tightly(sorted, field.size());
  for_each_index({0, owned_}, [&](std::size_t i) { sorted[i] = field[static_cast<std::size_t>(order[i])]; });
  std::swap(sorted, field);
}

template <class T>
void CellOrder::apply(const Borrowed<LocalId>& order, std::vector<T>& field) const {
  const Borrowed<T> sorted = scratch_->borrow<T>(field.size());
  for_each_index({0, owned_}, [&](std::size_t i) { sorted[i] = field[static_cast<std::size_t>(order[i])]; });
  for_each_index({0, owned_}, [&](std::size_t i) { field[i] = sorted[i]; });
}

void CellOrder::sort(Particles& particles, const CellWindow& window, Velocities velocities) {
  window_ = window;
  owned_ = particles.size();
  const auto all = static_cast<std::size_t>(owned_);
  const Places places{scratch_->borrow<LocalId>(all), scratch_->borrow<LocalId>(all)};
  sort_by_rows(particles, places);
  counts_.resize(static_cast<std::size_t>(planes()) * cells());
  PerThread<RowScratch> scratch;
  for_each_part(planes() * rows(), [&](LocalId row) { sort_row(particles, row, places, scratch.mine()); });
  std::vector<Vec3> own;
  std::vector<Vec3>& vectors = velocities == Velocities::discard ? particles.velocity : own;
  particles.for_each_kept_field([&]<class T>(std::vector<T>& field) {
    if constexpr (std::is_same_v<T, Vec3>) {
      apply(places.order, field, vectors);
    } else {
      apply(places.order, field);
    }
  });
  if (velocities == Velocities::preserve) apply(places.order, particles.velocity, own);
}

void CellOrder::add_ghosts(const GhostCounts& counts) {
  low_ghosts_ = std::reduce(counts.low.begin(), counts.low.end(), 0);
  high_ghosts_ = std::reduce(counts.high.begin(), counts.high.end(), 0);
  start_.resize((static_cast<std::size_t>(planes()) + 2) * cells() + 1);
  for_each_part(planes() + 2, [&](LocalId k) {
    const std::size_t at = static_cast<std::size_t>(k) * cells();
    if (k == 0) return add_plane(counts.low, 0, at);
    if (k == planes() + 1) return add_plane(counts.high, low_ghosts_ + owned_, at);
    const auto row = (static_cast<std::size_t>(k) - 1) * static_cast<std::size_t>(rows());
    add_plane({counts_.data() + at - cells(), cells()}, low_ghosts_ + row_start_[row], at);
  });
  copied_ = 0;
  start_.back() = low_ghosts_ + owned_ + high_ghosts_;
  for (auto& starts : row_start_ghosts_) starts.clear();
  add_row_ghosts(counts.row_before, 0);
  add_row_ghosts(counts.row_after, 1);
  if (has_copies()) add_copies();
}

void CellOrder::add_row_ghosts(std::span<const LocalId> counts, std::size_t side) {
  if (counts.empty()) return;
  const LocalId first = size();
  std::vector<LocalId>& starts = row_start_ghosts_[side];
  starts.resize(counts.size() + 1);
  std::exclusive_scan(counts.begin(), counts.end(), starts.begin(), first);
  starts.back() = starts[counts.size() - 1] + counts.back();
}

void CellOrder::add_copies() {
  copies_.clear();
  const LocalId rows = this->rows(), columns = grid_.columns();
  around_.assign((static_cast<std::size_t>(planes()) + 2) * static_cast<std::size_t>((rows + 2) * (columns + 2)), {});
  for (LocalId k = 0; k < planes() + 2; ++k) {
    for (LocalId r = -1; r <= rows; ++r) {
      for (LocalId c = -1; c <= columns; ++c) add_copy(k, r, c);
    }
  }
}

// Enters cell (k, r, c), which may be outside of the plane, into around_.
void CellOrder::add_copy(LocalId k, LocalId r, LocalId c) {
  const LocalId rows = this->rows(), columns = grid_.columns();
  const bool beyond = r < 0 || r == rows;
  if ((beyond && !grid_.is_periodic(1) && !rows_are_cut()) || ((c < 0 || c == columns) && !grid_.is_periodic(2)))
    return;
  const int row_turn = !beyond || !rows_wrap() ? 0 : r < 0 ? -1 : 1, column_turn = c < 0 ? -1 : c == columns ? 1 : 0;
  const LocalId column = c - column_turn * columns;
  Range range = run(k, r - row_turn * rows, {column, column + 1});
  if (row_turn != 0 || column_turn != 0) {
    const LocalId to = size();
    if (range.size() > 0) copies_.push_back({range.begin, range.size(), to, {row_turn, column_turn}});
    copied_ += range.size();
    range = {to, size()};
  }
  around_[static_cast<std::size_t>((k * (rows + 2) + r + 1) * (columns + 2) + c + 1)] = range;
}

// The cells of a plane, the first of which is start_[at]; without counts there are no particles.
void CellOrder::add_plane(std::span<const LocalId> counts, LocalId first, std::size_t at) {
  const auto begin = start_.begin() + static_cast<std::ptrdiff_t>(at);
  if (counts.empty()) {
    std::fill_n(begin, cells(), first);
  } else {
    std::exclusive_scan(counts.begin(), counts.end(), begin, first);
  }
}

Range CellOrder::owned_range(LocalId k, LocalId l) const {
  return {start(k + 1, 0) - low_ghosts_, start(l + 1, 0) - low_ghosts_};
}

std::size_t CellOrder::bytes() const {
  std::size_t bytes = (counts_.capacity() + start_.capacity() + row_start_ghosts_[0].capacity() +
                       row_start_ghosts_[1].capacity() + row_start_.capacity()) *
                      sizeof(LocalId);
  bytes += copies_.capacity() * sizeof(Copy) + around_.capacity() * sizeof(Range);
  return bytes;
}

}  // namespace trevi
