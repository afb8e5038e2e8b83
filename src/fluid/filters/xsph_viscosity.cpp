#include "fluid/filters/xsph_viscosity.hpp"

#include <algorithm>
#include <numbers>

#include "fluid/pairs/for_each_sum.hpp"
#include "kernels/poly6-inl.hpp"

namespace trevi {

namespace {

// velocity_i += factor Σ, the sums being those of a pair loop.
template <class T, class Loop>
void add_sums(const Neighbourhood<T>& near, const Loop& loop, Real factor, std::vector<Vec3>& velocity) {
  for_each_sum<Vec4<T>>(near.all(), loop, [&](Range here, const Vec4<T>* sum) {
    for (LocalId i = here.begin; i < here.end; ++i, ++sum)
      velocity[static_cast<std::size_t>(i)] += factor * vector_of(*sum);
  });
}

const Kernel& poly6_in(int dimensions) { return kernel_named(Poly6::name, dimensions); }

// ½ ∫ F x² over the volume of a particle: the second moment of neighbours that lie anywhere, m².
Real moment_without_order(const PointLattice& lattice, Real h) {
  constexpr Real pi = std::numbers::pi;
  const Real u = h / lattice.spacing;
  return h * h * u * u * (lattice.dimensions == 2 ? pi / 48 : pi * pi * u / 128);
}

}  // namespace

template <class T>
XsphViscosity<T>::XsphViscosity(Real c, const DensityModel& model)
    : loops_(filter_loops<T>()), factor_(c * model.mass * poly6_in(model.kernels.density.dimensions).factor(model.h)) {}

template <class T>
void XsphViscosity<T>::apply(Neighbourhood<T>& near, Particles& particles, Real) {
  const ScopedEvent timed(event_);
  const Borrowed<Vec4<T>> velocities = all_velocities(near, particles.velocity);
  const Pairs<T> pairs = pairs_of(near);
  const auto smoothing = [&](Range part, Vec4<T>* out) { loops_.smoothing(pairs, part, velocities.data(), out); };
  add_sums(near, smoothing, factor_, particles.velocity);
  log_work(event_, static_cast<double>(near.list().pairs()) * 22, bytes_of_passes(near, 1));
}

Real longest_viscous_step(Real nu, const PointLattice& lattice, Real h) {
  const Real least = min_second_moment(lattice, h) * lattice_laplacian_moment(lattice, h);
  return least / (nu * (lattice_friction_sum(lattice, h) - 1));
}

Real min_second_moment(const PointLattice& lattice, Real h) {
  const Real scatter = lattice.dimensions;  // neighbours
  return std::min(1.0, moment_without_order(lattice, h) / lattice_laplacian_moment(lattice, h)) *
         (1 - scatter / lattice_neighbours(lattice, h));
}

template <class T>
KinematicViscosity<T>::KinematicViscosity(Real nu, const PointLattice& lattice, Real h)
    : loops_(friction_loops<T>(lattice.dimensions)) {
  const Real moment = lattice_laplacian_moment(lattice, h);
  per_second_ = nu / moment / 2;
  moment_factor_ = static_cast<T>(h * h / (2 * lattice.dimensions * moment));
  least_ = static_cast<T>(min_second_moment(lattice, h));
}

// M_lattice/M_i to the scalar of each velocity.
template <class T>
void KinematicViscosity<T>::weigh(const Pairs<T>& pairs, Range all, Vec4<T>* velocities) const {
  const auto moments = [&](Range part, T* out) { loops_.second_moment(pairs, part, out); };
  for_each_sum<T>(all, moments, [&](Range here, const T* sum) {
    for (LocalId i = here.begin; i < here.end; ++i, ++sum) {
      const T moment = moment_factor_ * *sum;
      velocities[i].w = moment < least_ ? 1 : 1 / moment;
    }
  });
}

template <class T>
void KinematicViscosity<T>::apply(Neighbourhood<T>& near, Particles& particles, Real dt) {
  const ScopedEvent timed(event_);
  const Pairs<T> pairs = pairs_of(near);
  Borrowed<Vec4<T>> velocities = own_velocities(near, particles.velocity);
  weigh(pairs, near.all(), velocities.data() + near.order().low_ghosts());
  near.exchange(velocities);
  const auto friction = [&](Range part, Vec4<T>* out) { loops_.friction(pairs, part, velocities.data(), out); };
  add_sums(near, friction, per_second_ * dt, particles.velocity);
  log_work(event_, static_cast<double>(near.list().pairs()) * (14 + 24), bytes_of_passes(near, 2));
}

template class XsphViscosity<float>;
template class XsphViscosity<double>;
template class KinematicViscosity<float>;
template class KinematicViscosity<double>;

}  // namespace trevi
