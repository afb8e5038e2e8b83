#include "fluid/filters/momentum_conserving.hpp"

#include "base/growth.hpp"
#include "base/threads.hpp"
#include "parallel/reductions.hpp"

namespace trevi {

template <class T>
void MomentumConserving<T>::apply(Neighbourhood<T>& near, Particles& particles, Real dt) {
  std::vector<Vec3>& velocity = particles.velocity;
  keep(velocity);
  filter_->apply(near, particles, dt);
  const ScopedEvent timed(event_);
  const Vec3 mean = mean_change(near.order(), velocity);
  for_each_index(near.all(), [&](std::size_t i) { velocity[i] -= mean; });
}

template <class T>
void MomentumConserving<T>::keep(const std::vector<Vec3>& velocity) {
  const ScopedEvent timed(event_);
  resize_tightly(before_, velocity.size());
  for_each_index({0, static_cast<LocalId>(velocity.size())}, [&](std::size_t i) { before_[i] = velocity[i]; });
}

template <class T>
Vec3 MomentumConserving<T>::mean_change(const CellOrder& order, const std::vector<Vec3>& velocity) const {
  constexpr std::size_t columns = 4;  // sum of the changes, count
  std::vector<Real> partial(columns * static_cast<std::size_t>(order.planes()));
  for_each_part(order.planes(), [&](LocalId plane) {
    const Range range = order.owned_range(plane, plane + 1);
    Vec3 sum = Vec3::Zero();
    for (auto i = static_cast<std::size_t>(range.begin); i < static_cast<std::size_t>(range.end); ++i)
      sum += velocity[i] - before_[i];
    Real* row = &partial[columns * static_cast<std::size_t>(plane)];
    for (Eigen::Index a = 0; a < 3; ++a) row[a] = sum[a];
    row[3] = range.size();
  });
  const std::vector<Real> total = sum_over_planes(comm_, partial, columns);
  return total[3] > 0 ? Vec3(Vec3(total[0], total[1], total[2]) / total[3]) : Vec3(Vec3::Zero());
}

template class MomentumConserving<float>;
template class MomentumConserving<double>;

}  // namespace trevi
