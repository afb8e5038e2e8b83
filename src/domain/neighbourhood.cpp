#include "domain/neighbourhood.hpp"

#include "base/growth.hpp"
#include "base/threads.hpp"
#include "trevi/session.hpp"

namespace trevi {

template <class T>
Neighbourhood<T>::Neighbourhood(MPI_Comm comm, const CellGrid& grid, const Vec3& origin, Real h,
                                std::shared_ptr<Scratch> scratch)
    : scratch_(std::move(scratch)),
      comm_(comm),
      order_(grid, scratch_),
      halo_(comm, grid.is_periodic(0)),
      encoding_(origin, h),
      list_(scratch_) {
  for (std::size_t a = 0; a < 3; ++a) {
    if (grid.is_periodic(a)) encoding_.count_cells(grid.axis(a), grid.length(a) / grid.count(a), grid.count(a));
  }
}

template <class T>
void Neighbourhood<T>::arrange(Particles& particles, const Slabs& slabs, Velocities velocities) {
  list_.give_back();
  scratch_->join();
  {
    const ScopedEvent timed(sort_event_);
    order_.sort(particles, slabs.window(rank_of(comm_), order_.grid().rows()), velocities);
  }
  {
    const ScopedEvent timed(halo_event_);
    halo_.rebuild(order_, slabs.cuts());
    resize_tightly(records_, static_cast<std::size_t>(order_.size()));
    constexpr LocalId part_size = 2048;
    for_each_part(all(), part_size, [&](Range part) { encode(particles.predicted, part); });
    start_positions();
    finish_positions();
  }
}

template <class T>
void Neighbourhood<T>::search() {
  const ScopedEvent timed(search_event_);
  list_.rebuild(order_, records_);
}

template <class T>
void Neighbourhood<T>::encode(const std::vector<Vec3>& position, Range range) {
  if (encoding_.counts_cells()) {
    for (LocalId i = range.begin; i < range.end; ++i)
      record(i) = encoding_.in_cells(position[static_cast<std::size_t>(i)], T{0});
    return;
  }
  for (LocalId i = range.begin; i < range.end; ++i) record(i) = encoding_(position[static_cast<std::size_t>(i)], T{0});
}

template <class T>
void Neighbourhood<T>::finish_positions() {
  halo_.template finish_part<Coordinates>(records_, 0);
  const CellGrid& grid = order_.grid();
  const LocalId low = order_.low_ghosts(), high = low + order_.owned();
  const LocalId end = high + order_.high_ghosts() + order_.row_ghosts()[0] + order_.row_ghosts()[1];
  for (const Range& ghosts : {Range{0, low}, Range{high, end}})
    for_each_index(ghosts, [this](std::size_t i) { records_[i].w = 0; });
  move_ghosts_from_beyond();
  const std::span<const CellOrder::Copy> copies = order_.copies();
  constexpr LocalId part_size = 64;
  for_each_part({0, static_cast<LocalId>(copies.size())}, part_size, [&](Range part) {
    for (LocalId n = part.begin; n < part.end; ++n) {
      const CellOrder::Copy& copy = copies[static_cast<std::size_t>(n)];
      for (LocalId i = 0; i < copy.count; ++i) {
        Packed<T>& record = records_[static_cast<std::size_t>(copy.to + i)];
        record = records_[static_cast<std::size_t>(copy.from + i)];
        for (const std::size_t a : {0U, 1U}) {
          if (copy.turns[a] != 0)
            move(record, grid.axis(a + 1), copy.turns[a] * grid.count(a + 1) * Packed<T>::units_per_h);
        }
      }
    }
  });
}

template <class T>
void Neighbourhood<T>::finish_scalars() {
  halo_.template finish_part<T>(records_, offsetof(Packed<T>, w));
  for (const CellOrder::Copy& copy : order_.copies()) {
    for (LocalId i = 0; i < copy.count; ++i)
      records_[static_cast<std::size_t>(copy.to + i)].w = records_[static_cast<std::size_t>(copy.from + i)].w;
  }
}

template <class T>
void Neighbourhood<T>::move_ghosts(std::size_t direction, Range range, Real turns) {
  const Real units = turns * order_.grid().count(direction) * Packed<T>::units_per_h;
  const int axis = order_.grid().axis(direction);
  for_each_index(range, [this, axis, units](std::size_t i) { move(records_[i], axis, units); });
}

// Moves ghosts that come from beyond an end of the box to the positions where they are neighbours.
template <class T>
void Neighbourhood<T>::move_ghosts_from_beyond() {
  const CellGrid& grid = order_.grid();
  const LocalId planes = order_.planes(), rows = order_.rows();
  const auto is_first = [&](const Range& own) { return own.begin == 0; };
  const auto is_last = [&](const Range& own, std::size_t a) { return own.end == grid.count(a); };
  const CellWindow& window = order_.window();
  for (const bool upper : {false, true}) {
    if (grid.is_periodic(0) && (upper ? is_last(window.planes, 0) : is_first(window.planes))) {
      const LocalId k = upper ? planes + 1 : 0;
      move_ghosts(0, {order_.row(k, 0).begin, order_.row(k, rows - 1).end}, upper ? 1 : -1);
      if (order_.rows_are_cut()) {
        for (const LocalId r : {-1, rows}) move_ghosts(0, order_.row(k, r), upper ? 1 : -1);
      }
    }
    if (grid.is_periodic(1) && order_.rows_are_cut() && (upper ? is_last(window.rows, 1) : is_first(window.rows))) {
      const LocalId r = upper ? rows : -1;
      move_ghosts(1, {order_.row(0, r).begin, order_.row(planes + 1, r).end}, upper ? 1 : -1);
    }
  }
}

template <class T>
std::vector<Range> Neighbourhood<T>::boundary(LocalId depth) const {
  std::vector<Range> ranges;
  LocalId begin = 0;
  for (const Range& inner : interior(depth)) {
    ranges.push_back({begin, inner.begin});
    begin = inner.end;
  }
  ranges.push_back({begin, order_.owned()});
  return ranges;
}

template <class T>
CellWindow Neighbourhood<T>::interior_window(LocalId depth) const {
  const LocalId planes = order_.planes(), rows = order_.rows();
  const LocalId first = order_.rows_beside(0).begin < 0 ? depth : 0;
  const LocalId last = order_.rows_beside(rows - 1).end > rows ? rows - depth : rows;
  if (planes <= 2 * depth || first >= last) return {};
  return {{depth, planes - depth}, {first, last}};
}

template <class T>
std::vector<Range> Neighbourhood<T>::interior(LocalId depth) const {
  const auto [planes, rows] = interior_window(depth);
  if (planes.size() == 0) return {};
  if (!order_.rows_are_cut()) return {order_.owned_range(planes.begin, planes.end)};
  std::vector<Range> ranges;
  const LocalId low = order_.low_ghosts();
  for (LocalId k = planes.begin + 1; k <= planes.end; ++k)
    ranges.push_back({order_.row(k, rows.begin).begin - low, order_.row(k, rows.end - 1).end - low});
  return ranges;
}

template class Neighbourhood<float>;
template class Neighbourhood<double>;

}  // namespace trevi
