#include "fluid/filters/vorticity_confinement.hpp"

#include <Eigen/Geometry>

#include "fluid/pairs/for_each_sum.hpp"
#include "kernels/spiky-inl.hpp"

namespace trevi {

// The loop sums g r̂ with r̂ from j to i, the direction of ∇_{p_j} W = +45/(π h⁶) (h − r)² r̂, so omega_factor_ is
// positive.
template <class T>
VorticityConfinement<T>::VorticityConfinement(const DensityModel& model, Real epsilon)
    : loops_(filter_loops<T>()),
      omega_factor_(model.mass * kernel_named(Spiky::name, model.kernels.density.dimensions).slope_factor(model.h)),
      epsilon_(epsilon) {}

template <class T>
Borrowed<Vec4<T>> VorticityConfinement<T>::compute_omega(Neighbourhood<T>& near, const std::vector<Vec3>& velocity) {
  const Borrowed<Vec4<T>> velocities = all_velocities(near, velocity);
  const LocalId owned = near.order().owned();
  Borrowed<Vec4<T>> omegas = near.scratch().template borrow<Vec4<T>>(static_cast<std::size_t>(owned));
  const Pairs<T> pairs = pairs_of(near);
  const auto factor = static_cast<T>(omega_factor_);
  const auto curls = [&](Range part, Vec4<T>* out) { loops_.curl(pairs, part, velocities.data(), out); };
  for_each_sum<Vec4<T>>(near.all(), curls, [&](Range here, const Vec4<T>* sum) {
    for (LocalId i = here.begin; i < here.end; ++i, ++sum) {
      Vec4<T>& omega = omegas[static_cast<std::size_t>(i)];
      omega = {sum->x * factor, sum->y * factor, sum->z * factor, T{0}};
    }
  });
  // Not in the loop above, where other threads load the whole of each record.
  for_each_index(near.all(), [&](std::size_t i) {
    near.record(static_cast<LocalId>(i)).w = static_cast<T>(vector_of(omegas[i]).norm());
  });
  return omegas;
}

template <class T>
void VorticityConfinement<T>::apply(Neighbourhood<T>& near, Particles& particles, Real dt) {
  const ScopedEvent timed(event_);
  const Borrowed<Vec4<T>> omegas = compute_omega(near, particles.velocity);
  near.start_scalars();
  near.finish_scalars();
  const Pairs<T> pairs = pairs_of(near);
  const auto gradients = [&](Range part, Vec4<T>* out) { loops_.gradient(pairs, part, out); };
  for_each_sum<Vec4<T>>(near.all(), gradients, [&](Range here, const Vec4<T>* sum) {
    for (auto i = static_cast<std::size_t>(here.begin); i < static_cast<std::size_t>(here.end); ++i, ++sum) {
      // Only the direction of eta matters: minus that of the sum, as ∇_{p_i}W points from i to j.
      const Vec3 eta = -vector_of(*sum);
      const Real length = eta.norm();
      if (length > 0) particles.velocity[i] += dt * epsilon_ * (eta / length).cross(vector_of(omegas[i]));
    }
  });
  log_work(event_, static_cast<double>(near.list().pairs()) * (34 + 25), bytes_of_passes(near, 2));
}

template class VorticityConfinement<float>;
template class VorticityConfinement<double>;

}  // namespace trevi
