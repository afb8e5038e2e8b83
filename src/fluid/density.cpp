#include "fluid/density.hpp"

#include <algorithm>

#include "fluid/for_each_sum.hpp"

namespace trevi {

Real particle_mass(const FluidSettings& fluid) {
  if (fluid.mass == Mass::volume) return fluid.rest_density * fluid.spacing * fluid.spacing * fluid.spacing;
  return fluid.rest_density / lattice_density_sum(kernels_of(fluid).density, fluid.spacing, fluid.kernel_radius);
}

Real lambda(const DensityModel& model, Real rho, const Vec3& gradient, Real neighbours) {
  Real c = rho / model.rest_density - 1;
  if (model.constraint == Constraint::inequality) c = std::max(c, 0.0);
  if (c == 0) return 0;
  // A particle without neighbours has no gradient; with epsilon = 0 that would be 0/0.
  return -c / std::max(gradient.squaredNorm() + neighbours + model.epsilon, 1e-30);
}

template <class T>
DensityConstraint<T>::DensityConstraint(const DensityModel& model, const std::optional<Tensile>& tensile,
                                        std::optional<AnalyticWallDensity> walls)
    : model_(model),
      density_factor_(model.mass * model.kernels.density.factor(model.h)),
      gradient_factor_(model.mass / model.rest_density * model.kernels.gradient.slope_factor(model.h)),
      loops_(constraint_loops<T>(model.kernels)),
      delta_loop_(loops_.delta),
      walls_(std::move(walls)) {
  if (tensile) {
    delta_loop_ = [loop = loops_.tensile_delta, t = *tensile](const Pairs<T>& pairs, Range range, Vec4<T>* out) {
      loop(pairs, range, t, out);
    };
  }
}

template <class T>
void DensityConstraint<T>::densities(const Pairs<T>& pairs, Range range, std::span<const Vec3> p,
                                     std::span<Real> rho) const {
  const auto loop = [&](Range part, Vec4<T>* sums, T* squares) { loops_.density(pairs, part, sums, squares); };
  for_each_sum<Vec4<T>, T>(range, loop, [&](std::size_t k, const Vec4<T>& sum, T) {
    rho[k] = density_factor_ * (1 + static_cast<Real>(sum.w));
    if (walls_) rho[k] += model_.rest_density * walls_->at(p[k]).density;
  });
}

template <class T>
void DensityConstraint<T>::lambdas(const Pairs<T>& pairs, Range range, std::span<const Vec3> p, std::span<Real> rho,
                                   std::span<T> lambda) const {
  const auto loop = [&](Range part, Vec4<T>* sums, T* squares) { loops_.density(pairs, part, sums, squares); };
  for_each_sum<Vec4<T>, T>(range, loop, [&](std::size_t k, const Vec4<T>& sum, T squares) {
    rho[k] = density_factor_ * (1 + static_cast<Real>(sum.w));
    Vec3 gradient = -gradient_factor_ * vector_of(sum);
    if (walls_) {
      const BoundaryShare share = walls_->at(p[k]);
      rho[k] += model_.rest_density * share.density;
      gradient += share.gradient;
    }
    const Real neighbours = gradient_factor_ * gradient_factor_ * static_cast<Real>(squares);
    lambda[k] = static_cast<T>(trevi::lambda(model_, rho[k], gradient, neighbours));
  });
}

template <class T>
void DensityConstraint<T>::deltas(const Pairs<T>& pairs, Range range, std::span<const Vec3> p,
                                  std::span<Vec4<T>> delta) const {
  constexpr LocalId part_size = 512;
  for_each_part(range, part_size, [&](Range part) {
    delta_loop_(pairs, part, delta.data() + part.begin);
    const auto factor = static_cast<T>(-gradient_factor_);
    for (auto i = static_cast<std::size_t>(part.begin); i < static_cast<std::size_t>(part.end); ++i) {
      Vec4<T>& out = delta[i];
      out = {out.x * factor, out.y * factor, out.z * factor, 0};
      if (!walls_) continue;
      const Real lambda_i = pairs.records[static_cast<std::size_t>(pairs.low_ghosts) + i].w;
      if (lambda_i == 0) continue;  // most particles, where there is no pressure
      const Vec3 shift = lambda_i * walls_->at(p[i]).gradient;
      out.x += static_cast<T>(shift.x());
      out.y += static_cast<T>(shift.y());
      out.z += static_cast<T>(shift.z());
    }
  });
}

template class DensityConstraint<float>;
template class DensityConstraint<double>;

}  // namespace trevi
