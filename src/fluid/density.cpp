#include "fluid/density.hpp"

#include <algorithm>
#include <array>
#include <limits>

#include "fluid/for_each_sum.hpp"
#include "fluid/particle_loops.hpp"

namespace trevi {

Real particle_mass(const FluidSettings& fluid) {
  if (fluid.mass == Mass::volume) return fluid.rest_density * fluid.spacing * fluid.spacing * fluid.spacing;
  return fluid.rest_density / lattice_density_sum(kernels_of(fluid).density, fluid.spacing, fluid.kernel_radius);
}

Real lambda(const DensityModel& model, Real rho, const Vec3& gradient, Real neighbours) {
  Real c = rho / model.rest_density - 1;
  if (model.constraint == Constraint::inequality) c = std::max(c, 0.0);
  // A particle without neighbours has no gradient; with epsilon = 0 that would be 0/0.
  return 0 - c / std::max(gradient.squaredNorm() + neighbours + model.epsilon, 1e-30);
}

// What is needed after the pair loop of these particles comes from memory while the loop works.
template <class V>
void prefetch(std::span<const V> field, Range here) {
  const auto* end = reinterpret_cast<const char*>(field.data() + here.end);
  for (const auto* at = reinterpret_cast<const char*>(field.data() + here.begin); at < end; at += 64)
    __builtin_prefetch(at);
}

// visit(i, share) for the particles of the range, at most sums_chunk, that are near a wall, or an obstacle.
template <class T>
template <class Visit>
void DensityConstraint<T>::for_each_near_wall(Range range, std::span<const Vec3> p, const Visit& visit) const {
  if (!walls_) return;
  if (obstacles_) return for_each_near_obstacle(range, p, visit);
  const auto first = static_cast<std::size_t>(range.begin);
  std::array<LocalId, sums_chunk> near;
  const std::size_t count =
      find_outside(walls_->interior(), p.subspan(first, static_cast<std::size_t>(range.size())), near.data());
  for (std::size_t k = 0; k < count; ++k) {
    const std::size_t i = first + static_cast<std::size_t>(near[k]);
    visit(i, walls_->at(p[i]));
  }
}

template <class T>
template <class Visit>
void DensityConstraint<T>::for_each_near_obstacle(Range range, std::span<const Vec3> p, const Visit& visit) const {
  for (auto i = static_cast<std::size_t>(range.begin); i < static_cast<std::size_t>(range.end); ++i) {
    const bool at_wall = !walls_->interior().contains(p[i]), at_obstacle = obstacles_->is_near(p[i]);
    if (!at_wall && !at_obstacle) continue;
    const BoundaryShare box = at_wall ? walls_->at(p[i]) : BoundaryShare{};
    visit(i, at_obstacle ? obstacles_->with(box, p[i]) : box);
  }
}

template <class T>
void DensityConstraint<T>::tell_obstacles(const Pairs<T>& pairs, Range range, std::span<const Vec3> p) const {
  if (!walls_ || !obstacles_) return;
  const Packed<T>* const records = pairs.records.data() + pairs.low_ghosts;
  for_each_index(range, [&](std::size_t i) {
    const bool at_wall = !walls_->interior().contains(p[i]), at_obstacle = obstacles_->is_near(p[i]);
    if (!at_wall && !at_obstacle) return;
    const BoundaryShare box = at_wall ? walls_->at(p[i]) : BoundaryShare{};
    obstacles_->take_gradient(box, p[i], static_cast<Real>(records[i].w));
  });
}

template <class T>
DensityConstraint<T>::DensityConstraint(const DensityModel& model, const std::optional<Tensile>& tensile,
                                        std::optional<AnalyticWallDensity> walls, std::shared_ptr<Obstacles> obstacles)
    : model_(model),
      density_factor_(model.mass * model.kernels.density.factor(model.h)),
      gradient_factor_(model.mass / model.rest_density * model.kernels.gradient.slope_factor(model.h)),
      loops_(constraint_loops<T>(model.kernels)),
      delta_loop_(loops_.delta),
      walls_(std::move(walls)),
      obstacles_(std::move(obstacles)) {
  if (tensile) {
    delta_loop_ = [loop = loops_.tensile_delta, t = *tensile](const Pairs<T>& pairs, Range range, Vec4<T>* out) {
      loop(pairs, range, t, out);
    };
  }
}

template <class T>
void DensityConstraint<T>::densities(const Pairs<T>& pairs, Range range, std::span<const Vec3> p,
                                     std::span<Real> rho) const {
  const auto loop = [&](Range here, T* sums) { loops_.value(pairs, here, sums); };
  for_each_sum<T>(range, loop, [&](Range here, const T* sum) {
    for (auto i = static_cast<std::size_t>(here.begin); i < static_cast<std::size_t>(here.end); ++i, ++sum)
      rho[i] = density_factor_ * (1 + static_cast<Real>(*sum));
    for_each_near_wall(
        here, p, [&](std::size_t i, const BoundaryShare& share) { rho[i] += model_.rest_density * share.density; });
  });
}

// First as if all particles were far from walls, without a branch; then those near them, a few, once more.
template <class T>
void DensityConstraint<T>::lambdas(const Pairs<T>& pairs, Range range, std::span<const Vec3> p,
                                   const Lambdas& out) const {
  const auto loop = [&](Range here, Vec4<T>* sums, T* squares) {
    prefetch(p, here);
    loops_.density(pairs, here, sums, squares);
  };
  const Real slope = gradient_factor_, slope2 = slope * slope;
  const MultiplierLaw law{model_.rest_density, density_factor_ / model_.rest_density, slope2, model_.epsilon,
                          model_.constraint == Constraint::inequality ? 0 : std::numeric_limits<Real>::lowest()};
  for_each_sum<Vec4<T>, T>(range, loop, [&](Range here, const Vec4<T>* sums, const T* squares) {
    const auto first = static_cast<std::size_t>(here.begin), count = static_cast<std::size_t>(here.size());
    std::array<T, sums_chunk> multiplier;
    find_multipliers<T>(law, {{sums, count}, squares}, &out.rho[first], multiplier.data());
    std::fill_n(&out.wall[first], count, Vec4<T>{});
    for_each_near_wall(here, p, [&](std::size_t i, const BoundaryShare& share) {
      const std::size_t k = i - first;
      out.rho[i] += model_.rest_density * share.density;
      const Vec3 gradient = share.gradient - slope * vector_of(sums[k]);
      multiplier[k] = static_cast<T>(lambda(model_, out.rho[i], gradient, slope2 * static_cast<Real>(squares[k])));
      out.wall[i] = {static_cast<T>(share.gradient.x()), static_cast<T>(share.gradient.y()),
                     static_cast<T>(share.gradient.z()), 0};
    });
    out.use(here, multiplier.data());
  });
}

template <class T>
void DensityConstraint<T>::deltas(const Pairs<T>& pairs, Range range, std::span<Vec4<T>> delta) const {
  const Packed<T>* const records = pairs.records.data() + pairs.low_ghosts;
  const auto factor = static_cast<T>(-gradient_factor_);
  const auto loop = [&](Range here, Vec4<T>* sums) {
    prefetch<Vec4<T>>(delta, here);
    delta_loop_(pairs, here, sums);
  };
  for_each_sum<Vec4<T>>(range, loop, [&](Range here, const Vec4<T>* sums) {
    for (auto i = static_cast<std::size_t>(here.begin); i < static_cast<std::size_t>(here.end); ++i, ++sums) {
      const T multiplier = records[i].w;
      Vec4<T>& out = delta[i];
      out = {sums->x * factor + multiplier * out.x, sums->y * factor + multiplier * out.y,
             sums->z * factor + multiplier * out.z, 0};
    }
  });
}

template class DensityConstraint<float>;
template class DensityConstraint<double>;

}  // namespace trevi
