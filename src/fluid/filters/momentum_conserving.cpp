#include "fluid/filters/momentum_conserving.hpp"

#include "base/threads.hpp"
#include "domain/plane_sums.hpp"

namespace trevi {

namespace {

struct Changes {
  Vec3 sum = Vec3::Zero();
  Real count = 0;
  template <class Visit>
  void for_each(const Visit& visit) {
    for (Real& one : sum) visit(one);
    visit(count);
  }
};

}  // namespace

template <class T>
void MomentumConserving<T>::apply(Neighbourhood<T>& near, Particles& particles, Real dt) {
  std::vector<Vec3>& velocity = particles.velocity;
  const Borrowed<Vec3> before = copy_of(velocity, near.scratch());
  filter_->apply(near, particles, dt);
  const ScopedEvent timed(event_);
  const Vec3 mean = mean_change(near.order(), before, velocity);
  for_each_index(near.all(), [&](std::size_t i) { velocity[i] -= mean; });
}

template <class T>
Borrowed<Vec3> MomentumConserving<T>::copy_of(const std::vector<Vec3>& velocity, Scratch& scratch) const {
  const ScopedEvent timed(event_);
  Borrowed<Vec3> copy = scratch.borrow<Vec3>(velocity.size());
  for_each_index({0, static_cast<LocalId>(velocity.size())}, [&](std::size_t i) { copy[i] = velocity[i]; });
  return copy;
}

template <class T>
Vec3 MomentumConserving<T>::mean_change(const CellOrder& order, const Borrowed<Vec3>& before,
                                        const std::vector<Vec3>& velocity) const {
  const auto total = sum_over_planes<Changes>(comm_, order, [&](Changes& changes, Range range) {
    for (auto i = static_cast<std::size_t>(range.begin); i < static_cast<std::size_t>(range.end); ++i)
      changes.sum += velocity[i] - before[i];
    changes.count += range.size();
  });
  return total.count > 0 ? Vec3(total.sum / total.count) : Vec3(Vec3::Zero());
}

template class MomentumConserving<float>;
template class MomentumConserving<double>;

}  // namespace trevi
