#include "fluid/constraint/density.hpp"

#include <algorithm>
#include <array>
#include <limits>

#include "fluid/pairs/for_each_sum.hpp"
#include "fluid/pairs/particle_loops.hpp"

namespace trevi {

Real water_mass(const FluidSettings& fluid) {
  return fluid.rest_density * fluid.spacing * fluid.spacing * fluid.spacing;
}

Real particle_mass(const FluidSettings& fluid) {
  if (fluid.mass == Mass::volume) return water_mass(fluid);
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

namespace {

// What contributes to a particle's density; kept beside the gradient of that, for record_obstacles().
enum Boundary { none = 0, box_alone, obstacle };
template <class T>
Boundary boundary_of(const Vec4<T>& wall) {
  return static_cast<Boundary>(static_cast<int>(wall.w));
}

template <class T>
Vec4<T> wall_of(const Vec3& gradient, Boundary boundary) {
  return {static_cast<T>(gradient.x()), static_cast<T>(gradient.y()), static_cast<T>(gradient.z()),
          static_cast<T>(boundary)};
}

Box common(const Box& a, const Box& b) { return {a.min.cwiseMax(b.min), a.max.cwiseMin(b.max)}; }

}  // namespace

// visit(i, boundary) for the particles of the range, at most sums_chunk, that are near a wall, or an obstacle.
template <class T>
template <class Visit>
void DensityConstraint<T>::for_each_near_wall(Range range, std::span<const Vec3> p, const Visit& visit) const {
  if (!walls_) return;
  const auto first = static_cast<std::size_t>(range.begin);
  const std::span<const Vec3> here = p.subspan(first, static_cast<std::size_t>(range.size()));
  const Box& interior = walls_->interior();
  std::array<LocalId, sums_chunk> near;
  if (!obstacles_) {
    const std::size_t count = find_outside(interior, here, near.data());
    for (std::size_t k = 0; k < count; ++k) visit(first + static_cast<std::size_t>(near[k]), box_alone);
    return;
  }
  const Box open = obstacles_->open_box(here);
  const std::size_t count = find_outside(common(open, interior), here, near.data());
  for (std::size_t k = 0; k < count; ++k) {
    const std::size_t i = first + static_cast<std::size_t>(near[k]);
    if (open.contains(p[i]) || !obstacles_->is_near(p[i])) {
      if (!interior.contains(p[i])) visit(i, box_alone);
    } else {
      visit(i, obstacle);
    }
  }
}

template <class T>
BoundaryDensity DensityConstraint<T>::boundary_at(const Vec3& p, bool at_obstacle) const {
  const BoundaryDensity box = walls_->at(p);
  return at_obstacle ? obstacles_->with(box, p) : box;
}

// By what lambdas() wrote there: the gradient where it is the box's own.
template <class T>
void DensityConstraint<T>::record_obstacles(Range range, const Packed<T>* records, std::span<const Vec3> p,
                                            std::span<const Vec4<T>> wall) const {
  std::array<std::size_t, sums_chunk> near;
  std::array<Impulse, sums_chunk> by_box;
  std::size_t count = 0, impulses = 0;
  for (auto i = static_cast<std::size_t>(range.begin); i < static_cast<std::size_t>(range.end); ++i) {
    near[count] = i;  // without a branch
    count += wall[i].w != 0 ? 1 : 0;
  }
  for (std::size_t k = 0; k < count; ++k) {
    const std::size_t i = near[k];
    const auto factor = static_cast<Real>(records[i].w);
    if (boundary_of(wall[i]) == obstacle) {
      obstacles_->record_gradient(walls_->at(p[i]), p[i], factor);
    } else if (factor != 0) {
      by_box[impulses++] = {factor * vector_of(wall[i]), p[i]};
    }
  }
  obstacles_->record_box({by_box.data(), impulses});
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
    for_each_near_wall(here, p, [&](std::size_t i, Boundary boundary) {
      rho[i] += model_.rest_density * boundary_at(p[i], boundary == obstacle).density;
    });
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
    for_each_near_wall(here, p, [&](std::size_t i, Boundary boundary) {
      const std::size_t k = i - first;
      const BoundaryDensity boundary_density = boundary_at(p[i], boundary == obstacle);
      out.rho[i] += model_.rest_density * boundary_density.density;
      const Vec3 gradient = boundary_density.gradient - slope * vector_of(sums[k]);
      multiplier[k] = static_cast<T>(lambda(model_, out.rho[i], gradient, slope2 * static_cast<Real>(squares[k])));
      out.wall[i] = wall_of<T>(boundary_density.gradient, boundary);
    });
    out.use(here, multiplier.data());
  });
}

// A multiplier also holds what was pressed together without any motion, where the projection alone moves the water: a
// wall that gave it back as velocity would throw.
template <class T>
void DensityConstraint<T>::deltas_in_flight(const Pairs<T>& pairs, Range range, std::span<const Vec3> p,
                                            const std::function<Vec3(std::size_t)>& path,
                                            std::span<Vec4<T>> delta) const {
  for_each_part(range, sums_chunk,
                [&](Range here) { std::fill_n(&delta[static_cast<std::size_t>(here.begin)], here.size(), Vec4<T>{}); });
  sum_deltas(loops_.delta, pairs, range, p, delta);
  const Packed<T>* const records = pairs.records.data() + pairs.low_ghosts;
  for_each_part(range, sums_chunk, [&](Range here) {
    for_each_near_wall(here, p, [&](std::size_t i, Boundary boundary) {
      const auto multiplier = static_cast<Real>(records[i].w);
      if (multiplier == 0) return;
      const BoundaryDensity box = walls_->at(p[i]), all = boundary_at(p[i], boundary == obstacle);
      const Real nearer = boundary == obstacle ? obstacles_->growth(box, p[i], path(i)) : all.gradient.dot(path(i));
      const Real pushed = multiplier * all.gradient.squaredNorm();
      if (nearer * pushed >= 0) return;
      const Real factor = multiplier * std::min(-nearer / pushed, 1.0);
      delta[i].x += static_cast<T>(factor * all.gradient.x());
      delta[i].y += static_cast<T>(factor * all.gradient.y());
      delta[i].z += static_cast<T>(factor * all.gradient.z());
      if (!obstacles_ || !obstacles_->records_impulses()) return;
      if (boundary == obstacle) {
        obstacles_->record_gradient(box, p[i], factor);
      } else {
        Impulse by_box{factor * all.gradient, p[i]};
        obstacles_->record_box({&by_box, 1});
      }
    });
  });
}

template <class T>
void DensityConstraint<T>::sum_deltas(const DeltaLoop& delta_loop, const Pairs<T>& pairs, Range range,
                                      std::span<const Vec3> p, std::span<Vec4<T>> delta) const {
  const Packed<T>* const records = pairs.records.data() + pairs.low_ghosts;
  const auto factor = static_cast<T>(-gradient_factor_);
  const auto loop = [&](Range here, Vec4<T>* sums) {
    prefetch<Vec4<T>>(delta, here);
    if (obstacles_) prefetch(p, here);
    delta_loop(pairs, here, sums);
  };
  for_each_sum<Vec4<T>>(range, loop, [&](Range here, const Vec4<T>* sums) {
    if (obstacles_ && walls_ && obstacles_->records_impulses()) record_obstacles(here, records, p, delta);
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
