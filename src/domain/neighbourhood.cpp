#include "domain/neighbourhood.hpp"

#include "base/growth.hpp"
#include "base/threads.hpp"

namespace trevi {

template <class T>
Neighbourhood<T>::Neighbourhood(MPI_Comm comm, const CellGrid& grid, const Vec3& origin, Real h)
    : order_(grid), halo_(comm), encoding_(origin, h) {}

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
    halo_.exchange(records_);
  }
  const ScopedEvent timed(search_event_);
  list_.rebuild(order_, records_);
}

template <class T>
void Neighbourhood<T>::encode(const std::vector<Vec3>& position, Range range) {
  for (LocalId i = range.begin; i < range.end; ++i) record(i) = encoding_(position[static_cast<std::size_t>(i)], T{0});
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
