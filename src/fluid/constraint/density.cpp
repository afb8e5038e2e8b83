#include "fluid/constraint/density.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "fluid/pairs/for_each_sum.hpp"
#include "fluid/pairs/particle_loops.hpp"

namespace trevi {

Real water_mass(const FluidSettings& fluid) {
  return fluid.rest_density * fluid.spacing * fluid.spacing * fluid.spacing;
}

Real particle_mass(const FluidSettings& fluid) {
  if (fluid.mass == Mass::volume) return fluid.dimensions == 2 ? water_mass(fluid) / fluid.spacing : water_mass(fluid);
  return fluid.rest_density / lattice_density_sum(kernels_of(fluid).density, lattice_of(fluid), fluid.kernel_radius);
}

Real lambda(const DensityModel& model, Real least, Real rho, const Vec3& gradient, Real neighbours) {
  const Real c = rho / model.rest_density - 1;
  if (c <= least) return 0;
  // A particle without neighbours has no gradient; with epsilon = 0 that would be 0/0.
  return 0 - c / std::max(gradient.squaredNorm() + neighbours + model.epsilon, 1e-30);
}

// Prefetches, while the pair loop of these particles runs, what is needed after it.
template <class V>
void prefetch(std::span<const V> here) {
  const auto bytes = std::as_bytes(here);
  for (std::size_t at = 0; at < bytes.size(); at += 64) __builtin_prefetch(bytes.data() + at);
}

namespace {

std::span<const Vec3> part_of(std::span<const Vec3> field, Range range) {
  return field.subspan(static_cast<std::size_t>(range.begin), static_cast<std::size_t>(range.size()));
}

}  // namespace

constexpr auto all_of_them = [](std::size_t) { return true; };

// Calls visit(i, wall, contribution of obstacles) for those particles of the range, at most sums_chunk, that are near a
// wall or an obstacle and for which wants(i) holds.
template <class T>
template <class Wants, class Visit>
void DensityConstraint<T>::for_each_near_wall(Range range, std::span<const Vec3> p, const Wants& wants,
                                              const Visit& visit) const {
  static_assert(sums_chunk <= Obstacles::at_once);
  if (!walls_) return;
  const Box& interior = walls_->interior();
  if (!obstacles_) {
    std::array<LocalId, sums_chunk> near;
    const std::size_t count = find_outside(OpenSpace(interior), part_of(p, range), near.data());
    for (std::size_t k = 0; k < count; ++k) {
      const auto i = static_cast<std::size_t>(range.begin + near[k]);
      if (wants(i)) visit(i, Wall::box, {});
    }
    return;
  }
  const OpenSpace open = obstacles_->open_space(part_of(p, range), Extent::density, range.begin);
  std::array<OutsideOf, sums_chunk> near;
  const std::size_t count = find_outside(open, interior, part_of(p, range), near.data());
  std::array<std::size_t, sums_chunk> asked;
  std::array<Vec3, sums_chunk> there;
  std::array<Obstacles::NearDensity, sums_chunk> found;
  std::size_t outside = 0;
  for (std::size_t k = 0; k < count; ++k) {
    const std::size_t i = static_cast<std::size_t>(range.begin + near[k].which);
    if (!wants(i)) continue;
    if (near[k].space) {
      asked[outside] = i;
      there[outside++] = p[i];
    } else if (!interior.contains(p[i])) {
      visit(i, Wall::box, {});
    }
  }
  obstacles_->find_near(open, {there.data(), outside}, {found.data(), outside});
  for (std::size_t k = 0; k < outside; ++k) {
    if (found[k].is_near) {
      visit(asked[k], Wall::obstacle, found[k]);
    } else if (!interior.contains(there[k])) {
      visit(asked[k], Wall::box, {});
    }
  }
}

namespace {

BoundaryDensity together(const BoundaryDensity& box, Wall wall, const BoundaryDensity& obstacles) {
  return wall == Wall::obstacle ? Obstacles::together(box, obstacles) : box;
}

}  // namespace

// Uses what lambdas() wrote there: the gradient, where it is due to the box alone.
template <class T>
void DensityConstraint<T>::record_obstacles(Range range, const Packed<T>* records, std::span<const Vec3> p,
                                            const WallsOrShifts<T>& field) const {
  std::array<std::size_t, sums_chunk> near;
  std::array<Impulse, sums_chunk> by_box;
  std::size_t count = 0, impulses = 0;
  for (auto i = static_cast<std::size_t>(range.begin); i < static_cast<std::size_t>(range.end); ++i) {
    near[count] = i;  // without a branch
    count += static_cast<std::size_t>(field.has_wall(i));
  }
  for (std::size_t k = 0; k < count; ++k) {
    const std::size_t i = near[k];
    const auto factor = static_cast<Real>(records[i].w);
    if (field.wall(i) == Wall::obstacle) {
      obstacles_->record_gradient(walls_->at(p[i]), p[i], factor);
    } else if (factor != 0) {
      by_box[impulses++] = {factor * field.gradient(i), p[i]};
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
      is_tensile_(tensile.has_value()),
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
    for_each_near_wall(here, p, all_of_them, [&](std::size_t i, Wall wall, const BoundaryDensity& obstacles) {
      rho[i] += model_.rest_density * together(walls_->at(p[i]), wall, obstacles).density;
    });
  });
}

// First as if all particles were far from walls, without a branch; then once more for the few that are near them.
template <class T>
void DensityConstraint<T>::lambdas(const Pairs<T>& pairs, Range range, std::span<const Vec3> p,
                                   const Lambdas& out) const {
  const auto loop = [&](Range here, Vec4<T>* sums, T* squares) {
    prefetch(part_of(p, here));
    loops_.density(pairs, here, sums, squares);
  };
  const Real slope = gradient_factor_, slope2 = slope * slope;
  const MultiplierLaw law{model_.rest_density, density_factor_ / model_.rest_density, slope2, model_.epsilon,
                          model_.constraint == Constraint::inequality ? no_compression<T> : -INFINITY};
  for_each_sum<Vec4<T>, T>(range, loop, [&](Range here, const Vec4<T>* sums, const T* squares) {
    const auto first = static_cast<std::size_t>(here.begin), count = static_cast<std::size_t>(here.size());
    std::array<T, sums_chunk> multiplier;
    find_multipliers<T>(law, {{sums, count}, squares}, &out.rho[first], multiplier.data());
    out.field.clear(here);
    for_each_near_wall(here, p, all_of_them, [&](std::size_t i, Wall wall, const BoundaryDensity& obstacles) {
      const std::size_t k = i - first;
      const BoundaryDensity boundary_density = together(walls_->at(p[i]), wall, obstacles);
      out.rho[i] += model_.rest_density * boundary_density.density;
      const Vec3 gradient = boundary_density.gradient - slope * vector_of(sums[k]);
      multiplier[k] =
          static_cast<T>(lambda(model_, law.least, out.rho[i], gradient, slope2 * static_cast<Real>(squares[k])));
      out.field.set_wall(i, boundary_density.gradient, wall);
    });
    out.use(here, multiplier.data());
  });
}

// Where the projection alone moves the water, a multiplier also contains what was pressed together without any motion.
// A wall that returned this as velocity would throw particles. Because this function makes velocities, water behind the
// wall pushes, too.
template <class T>
void DensityConstraint<T>::deltas_in_flight(const Pairs<T>& pairs, Range range, std::span<const Vec3> p,
                                            std::span<const Vec3> velocity, Real dt, WallsOrShifts<T>& field) const {
  constexpr Real mirrored = WallSlope::of_velocities / WallSlope::of_positions;
  for_each_part(range, sums_chunk, [&](Range here) { field.clear(here); });
  sum_deltas(loops_.delta, pairs, range, p, field);
  const Packed<T>* const records = pairs.records.data() + pairs.low_ghosts;
  for_each_part(range, sums_chunk, [&](Range here) {
    const auto has_multiplier = [&](std::size_t i) { return records[i].w != 0; };
    for_each_near_wall(here, p, has_multiplier, [&](std::size_t i, Wall wall, const BoundaryDensity& obstacles) {
      const auto multiplier = static_cast<Real>(records[i].w);
      const BoundaryDensity box = walls_->at(p[i]), all = together(box, wall, obstacles);
      const Vec3 path = velocity[i] * dt;
      const Real nearer = wall == Wall::obstacle ? obstacles_->growth(box, p[i], path) : all.gradient.dot(path);
      const Real pushed = multiplier * all.gradient.squaredNorm();
      if (nearer * pushed >= 0) return;
      const Real factor = multiplier * std::min(-nearer / pushed, mirrored);
      field.add_to_shift(i, factor * all.gradient);
      if (!obstacles_ || !obstacles_->records_impulses()) return;
      if (wall == Wall::obstacle) {
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
                                      std::span<const Vec3> p, WallsOrShifts<T>& field) const {
  const Packed<T>* const records = pairs.records.data() + pairs.low_ghosts;
  const auto factor = static_cast<T>(-gradient_factor_);
  const auto loop = [&](Range here, Vec4<T>* sums) {
    prefetch(field.memory(here));
    if (obstacles_) prefetch(part_of(p, here));
    delta_loop(pairs, here, sums);
  };
  for_each_sum<Vec4<T>>(range, loop, [&](Range here, const Vec4<T>* sums) {
    if (obstacles_ && walls_ && obstacles_->records_impulses()) record_obstacles(here, records, p, field);
    for (auto i = static_cast<std::size_t>(here.begin); i < static_cast<std::size_t>(here.end); ++i, ++sums)
      field.make_shift(i, *sums, factor, records[i].w);
  });
}

template class DensityConstraint<float>;
template class DensityConstraint<double>;

}  // namespace trevi
