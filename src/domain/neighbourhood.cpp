#include "domain/neighbourhood.hpp"

#include "base/growth.hpp"
#include "base/threads.hpp"

namespace trevi {

template <class T>
Neighbourhood<T>::Neighbourhood(MPI_Comm comm, const CellGrid& grid, const Vec3& origin, Real h)
    : order_(grid), halo_(comm, grid.is_periodic(0)), encoding_(origin, h) {
  for (std::size_t a = 0; a < 3; ++a) {
    if (grid.is_periodic(a)) encoding_.count_cells(grid.axis(a), grid.length(a) / grid.count(a), grid.count(a));
  }
}

template <class T>
void Neighbourhood<T>::rebuild(Particles& particles, const Planes& planes, Velocities velocities) {
  {
    const ScopedEvent timed(sort_event_);
    order_.sort(particles, planes, velocities);
  }
  {
    const ScopedEvent timed(halo_event_);
    halo_.rebuild(order_);
    resize_tightly(records_, static_cast<std::size_t>(order_.size()));
    constexpr LocalId part_size = 2048;
    for_each_part(all(), part_size, [&](Range part) { encode(particles.predicted, part); });
    const CellGrid& grid = order_.grid();
    first_ = grid.is_periodic(0) && planes.first == 0;
    last_ = grid.is_periodic(0) && planes.last == grid.planes();
    start_positions();
    finish_positions();
  }
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
  const LocalId low = order_.low_ghosts(), high = low + order_.owned(), end = high + order_.high_ghosts();
  for (const Range& ghosts : {Range{0, low}, Range{high, end}})
    for_each_index(ghosts, [this](std::size_t i) { records_[i].w = 0; });
  if (first_) move_ghosts({0, low}, -1);
  if (last_) move_ghosts({high, end}, 1);
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
void Neighbourhood<T>::move_ghosts(Range range, Real turns) {
  const Real units = turns * order_.grid().count(0) * Packed<T>::units_per_h;
  for_each_index(range, [this, units](std::size_t i) { move(records_[i], order_.grid().axis(0), units); });
}

template <class T>
std::vector<Range> Neighbourhood<T>::boundary() const {
  const Range first = order_.owned_range(0, 1), last = order_.owned_range(order_.planes() - 1, order_.planes());
  if (order_.planes() == 1) return {first};
  return {first, last};
}

template <class T>
Range Neighbourhood<T>::interior() const {
  if (order_.planes() <= 2) return {};
  return order_.owned_range(1, order_.planes() - 1);
}

template class Neighbourhood<float>;
template class Neighbourhood<double>;

}  // namespace trevi
