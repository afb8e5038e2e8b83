#include "fluid/filters/no_slip.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "kernels/kernels.hpp"

namespace trevi {

template <class T>
NoSlip<T>::NoSlip(Real nu, const FluidSettings& fluid, const Box& walls, std::shared_ptr<Obstacles> obstacles)
    : h_(fluid.kernel_radius), walls_(walls), obstacles_(std::move(obstacles)) {
  const Real s = fluid.spacing;
  const Real u = h_ / s;
  const Real per_volume = u * u * (fluid.dimensions == 2 ? 16.0 / 105 : u * 2 * std::numbers::pi / 35);
  factor_ = nu / lattice_laplacian_moment(lattice_of(fluid), h_) * per_volume;
  least_ = s / 8;  // a particle that is pushed against the wall is not there for ever
}

// 1/s.
template <class T>
Real NoSlip<T>::rate(Real distance) const {
  const Real u = std::max(distance, least_) / h_, rest = 1 - u * u;
  if (!(rest > 0)) return 0;
  return factor_ * rest * rest * rest * std::sqrt(rest) / u;
}

// visit(account, distance, displacement of the surface in the substep).
template <class T>
template <class Visit>
void NoSlip<T>::for_each_wall(const Vec3& p, Visit&& visit) const {
  for (int a = 0; a < 3; ++a) {
    for (const Real distance : {p[a] - walls_.min[a], walls_.max[a] - p[a]})
      if (distance < h_) visit(obstacles_ ? obstacles_->box_account() : 0, distance, Vec3(Vec3::Zero()));
  }
  if (obstacles_) obstacles_->for_each_near(p, visit);
}

template <class T>
Vec3 NoSlip<T>::held(const Vec3& p, const Vec3& v, Real dt) const {
  Real total_pull = 1;
  Vec3 sum = v;
  for_each_wall(p, [&](std::size_t, Real distance, const Vec3& displacement) {
    const Real pull = rate(distance);
    total_pull += pull * dt;
    sum += pull * displacement;
  });
  return sum / total_pull;
}

// What each of them gave to a particle that has the velocity v now.
template <class T>
void NoSlip<T>::record(const Vec3& p, const Vec3& v, Real dt) {
  for_each_wall(p, [&](std::size_t account, Real distance, const Vec3& displacement) {
    obstacles_->record(account, rate(distance) * dt * (displacement - v * dt), p);
  });
}

template <class T>
void NoSlip<T>::apply(Neighbourhood<T>&, Particles& particles, Real dt) {
  const ScopedEvent timed(event_);
  const Vec3 gap = Vec3::Constant(h_);
  const Box inner{walls_.min + gap, walls_.max - gap};
  constexpr LocalId part_size = 512;
  for_each_part({0, static_cast<LocalId>(particles.size())}, part_size, [&](Range part) {
    for (auto i = static_cast<std::size_t>(part.begin); i < static_cast<std::size_t>(part.end); ++i) {
      const Vec3& p = particles.predicted[i];
      if (!obstacles_ && inner.contains(p)) continue;
      particles.velocity[i] = held(p, particles.velocity[i], dt);
      if (obstacles_) record(p, particles.velocity[i], dt);
    }
  });
}

template class NoSlip<float>;
template class NoSlip<double>;

}  // namespace trevi
