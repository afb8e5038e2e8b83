#include "fluid/xsph_viscosity.hpp"

#include "fluid/for_each_sum.hpp"
#include "fluid/kernels/poly6-inl.hpp"

namespace trevi {

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
  const Vec4<T>* velocities = velocity_->refresh(near, particles.velocity);
  const Pairs<T> pairs = pairs_of(near);
  const auto smoothing = [&](Range part, Vec4<T>* out) { loops_.smoothing(pairs, part, velocities, out); };
  for_each_sum<Vec4<T>>(near.all(), smoothing, [&](Range here, const Vec4<T>* sum) {
    for (LocalId i = here.begin; i < here.end; ++i, ++sum)
      particles.velocity[static_cast<std::size_t>(i)] += factor * vector_of(*sum);
  });
  log_flops(static_cast<double>(near.list().pairs()) * 22);
}

template class XsphViscosity<float>;
template class XsphViscosity<double>;

}  // namespace trevi
