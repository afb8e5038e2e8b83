#include "fluid/velocity_filter.hpp"

#include <Eigen/Geometry>

#include "base/growth.hpp"
#include "fluid/for_each_sum.hpp"
#include "fluid/kernels/poly6-inl.hpp"
#include "fluid/kernels/spiky-inl.hpp"

namespace trevi {

namespace {

template <class T>
Pairs<T> pairs_of(const Neighbourhood<T>& near) {
  return {near.records(), near.list(), near.order().low_ghosts()};
}

}  // namespace

template <class T>
const Quad<T>* VelocityField<T>::refresh(Neighbourhood<T>& near, const std::vector<Vec3>& velocity) {
  resize_tightly(quads_, near.records().size());
  Quad<T>* owned = quads_.data() + near.order().low_ghosts();
  for (std::size_t i = 0; i < velocity.size(); ++i) {
    const Vec3& v = velocity[i];
    owned[i] = {static_cast<T>(v.x()), static_cast<T>(v.y()), static_cast<T>(v.z()), T{0}};
  }
  near.halo().exchange(quads_);
  return quads_.data();
}

// ∇_{p_j} W = +45/(π h⁶) (h − r)² r̂ with r̂ from j to i, the sign of the sum in the loop.
template <class T>
VorticityConfinement<T>::VorticityConfinement(const DensityModel& model, Real epsilon,
                                              std::shared_ptr<VelocityField<T>> velocity)
    : loops_(filter_loops<T>()),
      omega_factor_(model.mass * Spiky::slope_factor(model.h)),
      epsilon_(epsilon),
      velocity_(std::move(velocity)) {}

template <class T>
void VorticityConfinement<T>::compute_omega(Neighbourhood<T>& near, const std::vector<Vec3>& velocity) {
  const Quad<T>* velocities = velocity_->refresh(near, velocity);
  const LocalId owned = near.order().owned();
  resize_tightly(omega_, static_cast<std::size_t>(owned));
  loops_.curl(pairs_of(near), {0, owned}, velocities, omega_.data());
  const auto factor = static_cast<T>(omega_factor_);
  for (LocalId i = 0; i < owned; ++i) {
    Quad<T>& omega = omega_[static_cast<std::size_t>(i)];
    omega = {omega.x * factor, omega.y * factor, omega.z * factor, T{0}};
    near.record(i).w = static_cast<T>(vector_of(omega).norm());
  }
}

template <class T>
void VorticityConfinement<T>::apply(Neighbourhood<T>& near, Particles& particles, Real dt) {
  const ScopedEvent timed(event_);
  compute_omega(near, particles.velocity);
  near.halo().exchange(near.records());
  const Pairs<T> pairs = pairs_of(near);
  const auto gradients = [&](Range part, Quad<T>* out) { loops_.gradient(pairs, part, out); };
  for_each_sum<Quad<T>>(near.all(), gradients, [&](std::size_t i, const Quad<T>& sum) {
    // Only the direction of eta matters: minus that of the sum, as ∇_{p_i}W points from i to j.
    const Vec3 eta = -vector_of(sum);
    const Real length = eta.norm();
    if (length > 0) particles.velocity[i] += dt * epsilon_ * (eta / length).cross(vector_of(omega_[i]));
  });
  log_flops(static_cast<double>(near.list().pairs()) * (34 + 25));
}

XsphFactor xsph_of_share(Real c, const DensityModel& model) { return {.each_step = c * model.mass}; }

XsphFactor xsph_of_viscosity(Real nu, Real spacing, Real h) {
  return {.per_second = nu / lattice_laplacian_moment(spacing, h)};
}

Real longest_viscous_step(Real nu, Real spacing, Real h) {
  return lattice_laplacian_moment(spacing, h) / (nu * lattice_density_sum(kernel_named(Poly6::name), spacing, h));
}

template <class T>
XsphViscosity<T>::XsphViscosity(const XsphFactor& factor, Real h, std::shared_ptr<VelocityField<T>> velocity)
    : loops_(filter_loops<T>()), factor_(factor), kernel_factor_(Poly6::factor(h)), velocity_(std::move(velocity)) {}

template <class T>
void XsphViscosity<T>::apply(Neighbourhood<T>& near, Particles& particles, Real dt) {
  const ScopedEvent timed(event_);
  const Real factor = factor_.of_step(dt) * kernel_factor_;
  const Quad<T>* velocities = velocity_->refresh(near, particles.velocity);
  const Pairs<T> pairs = pairs_of(near);
  const auto smoothing = [&](Range part, Quad<T>* out) { loops_.smoothing(pairs, part, velocities, out); };
  for_each_sum<Quad<T>>(near.all(), smoothing,
                        [&](std::size_t i, const Quad<T>& sum) { particles.velocity[i] += factor * vector_of(sum); });
  log_flops(static_cast<double>(near.list().pairs()) * 22);
}

template class VorticityConfinement<float>;
template class VorticityConfinement<double>;
template class XsphViscosity<float>;
template class XsphViscosity<double>;

}  // namespace trevi
