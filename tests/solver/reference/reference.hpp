// The method by brute force in double precision, O(n²), one rank, no cells: Algorithm 1 of the report with the exact
// definitions of inputs/README.md, the walls' share of density (reference_walls.hpp), the projection
// (reference_projection.hpp) with the sweeps that shift positions only, the Chebyshev weights and the cap on shifts.
// Written from those texts alone and shares no numerical code with the solver, except for the uniform random numbers of
// the fountain. Not collective.
#pragma once

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <cmath>
#include <limits>
#include <numbers>

#include "reference_projection.hpp"
#include "reference_walls.hpp"
#include "support/cloud.hpp"
#include "trevi/forcing.hpp"

namespace trevi::test {

class Reference {
 public:
  Reference(const Scene& scene, const Cloud& cloud)
      : s_(scene),
        cloud_(sorted_by_id(cloud)),
        density_kernel_{scene.fluid.density_kernel, scene.fluid.kernel_radius, scene.fluid.dimensions},
        gradient_kernel_{scene.fluid.gradient_kernel.value(), scene.fluid.kernel_radius, scene.fluid.dimensions},
        walls_(scene, is_projected() && s_.density.method == Method::chebyshev ? 1.25 : 2),
        projection_(scene) {
    const Real ratio = scene.fluid.spacing / 0.1;
    epsilon_ = scene.density.epsilon / (ratio * ratio);
    if (scene.tensile) k_ = scene.tensile->k * ratio * ratio;
    mass_ = scene.fluid.rest_density * std::pow(scene.fluid.spacing, scene.fluid.dimensions);
    if (scene.fluid.mass == Mass::calibrated) mass_ *= scene.fluid.rest_density / lattice_density();
  }

  const Cloud& cloud() const { return cloud_; }
  const std::vector<Real>& densities() const { return rho_; }  ///< at the last evaluation

  void step(int substeps = 1) {
    dt_ = s_.dt / substeps;
    for (int k = 0; k < substeps; ++k) substep({steps_, k, static_cast<Real>(steps_) * s_.dt + k * dt_, dt_});
    ++steps_;
    find_densities();
  }

 private:
  using Vectors = std::vector<Vec3>;

  std::size_t size() const { return cloud_.id.size(); }
  Real h() const { return s_.fluid.kernel_radius; }
  Real poly6(Real r) const { return reference_poly6(r, h(), s_.fluid.dimensions); }
  /// From j to i, or to the image of i nearest to j.
  Vec3 between(std::size_t i, std::size_t j) const {
    Vec3 way = p_[i] - p_[j];
    for (int a = 0; a < 3; ++a)
      if (repeats(a)) way[a] -= length(a) * std::round(way[a] / length(a));
    return way;
  }
  bool repeats(int a) const { return s_.periodic[static_cast<std::size_t>(a)]; }
  /// Without walls along the axis: where the box repeats, and across a layer.
  bool is_open(int a) const { return repeats(a) || (a == 1 && s_.fluid.dimensions == 2); }
  Real length(int a) const { return s_.domain.max[a] - s_.domain.min[a]; }
  /// Brings p* back into the box, and x along with it.
  void wrap(std::size_t i) {
    for (int a = 0; a < 3; ++a) {
      const Real back = repeats(a) ? -length(a) * std::floor((p_[i][a] - s_.domain.min[a]) / length(a)) : 0;
      p_[i][a] += back;
      cloud_.position[i][a] += back;
    }
  }
  bool has_walls() const { return s_.walls.density == WallDensity::analytic; }
  /// The projection serves without gravity, and where gravity is more downward than sideways.
  bool is_projected() const {
    const Vec3 g = s_.gravity.value_or(Vec3::Zero());
    if (!s_.density.coarse_grid) return false;
    return is_weightless() || (g.z() < 0 && -g.z() >= std::hypot(g.x(), g.y()));
  }
  bool is_weightless() const { return s_.gravity.value_or(Vec3::Zero()).isZero(); }
  /// ∇W of Spiky with respect to the first particle of the pair.
  Vec3 spiky(const Vec3& r) const {
    const Real d = r.norm();
    if (d == 0 || d >= h()) return Vec3::Zero();
    return ReferenceKernel{"spiky", h(), s_.fluid.dimensions}.slope(d) * (r / d);
  }

  /// That of the gradients of the constraint.
  Vec3 pull(const Vec3& r) const {
    const Real d = r.norm();
    return d > 0 ? Vec3(gradient_kernel_.slope(d) / d * r) : Vec3::Zero();
  }

  /// Density of the interior of the start lattice with the mass of "volume".
  Real lattice_density() const {
    const int reach = static_cast<int>(std::ceil(h() / s_.fluid.spacing));
    const int across = s_.fluid.dimensions == 2 ? 0 : reach;
    Real sum = 0;
    for (int x = -reach; x <= reach; ++x)
      for (int y = -across; y <= across; ++y)
        for (int z = -reach; z <= reach; ++z)
          sum += density_kernel_(s_.fluid.spacing * std::sqrt(x * x + y * y + z * z));
    return mass_ * sum;
  }

  void substep(const StepInfo& info) {
    apply_forces(info);
    p_.resize(size());
    lifted_.assign(size(), 0);
    for (std::size_t i = 0; i < size(); ++i) {
      p_[i] = fly(cloud_.position[i], cloud_.velocity[i], dt_);
      wrap(i);
    }
    find_neighbours();
    if (is_projected() && s_.density.method == Method::chebyshev) {
      project_and_shift();
    } else {
      int sweeps = s_.density.iterations;
      if (is_projected()) {
        project();
        sweeps = std::max(1, sweeps - 1);
      }
      step_.assign(size(), 0);
      for (int k = 0; k < sweeps; ++k) iterate(k);
      set_velocities();
    }
    if (s_.vorticity) confine_vorticity();
    if (s_.viscosity) smooth();
    for (std::size_t i = 0; i < size(); ++i) p_[i] = shifted(p_[i], lifted_[i] * lift());
    cloud_.position = p_;
    for (std::size_t i = 0; i < size(); ++i) wrap(i);
  }

  void set_velocities() {
    for (std::size_t i = 0; i < size(); ++i) cloud_.velocity[i] = (p_[i] - cloud_.position[i]) / dt_;
  }

  /// Moves p* by the projection.
  std::vector<ReferenceProjection::Displacement> project() {
    const auto found = projection_.displacements(cloud_.position, p_, dt_);
    for (std::size_t i = 0; i < size(); ++i) p_[i] = shifted(p_[i], found[i].u);
    return found;
  }

  /// From a path by the new velocity to one by the mean of both, where gravity is all that acts.
  Vec3 lift() const { return -s_.gravity.value_or(Vec3::Zero()) * dt_ * dt_ / 2; }
  /// Whether something may carry what is at p: a wall that gravity presses it to.
  bool may_rest(const Vec3& p) const {
    const Vec3 g = s_.gravity.value_or(Vec3::Zero());
    for (int a = 0; a < 3; ++a) {
      const Real gap = g[a] < 0 ? p[a] - s_.domain.min[a] : s_.domain.max[a] - p[a];
      if (g[a] != 0 && !is_open(a) && gap < h()) return true;
    }
    return false;
  }
  /// How much of the lift a particle gets: less by the square of what it was displaced over half of what gravity does.
  Real flies(const Vec3& displacement, const Vec3& p) const {
    return may_rest(p) ? 0 : std::max(0.0, 1 - std::pow(displacement.norm() / lift().norm(), 2));
  }

  /// Velocities from the projection; the sweeps after it shift positions, and the smooth part of that is taken off. The
  /// multipliers of these sweeps become velocity, too, where the projection does not act: at the final positions, and
  /// without the tensile term; a wall stops what comes nearer to it, and does no more. A shifted particle takes on the
  /// velocity of where it goes. What flies is lifted to the path by both velocities.
  void project_and_shift() {
    set_velocities();  // as if nothing acted
    const Vectors free_velocity = cloud_.velocity, free_place = p_;
    const std::vector<ReferenceProjection::Displacement> projected = project();
    const std::vector<std::vector<std::size_t>> pieces = projection_.pieces();
    set_velocities();
    const Vectors start = p_;
    std::vector<Real> in_flight(size(), 0), compression(size());
    step_.assign(size(), 0);
    for (int k = 0; k < std::max(1, s_.density.iterations - 1); ++k) {
      iterate(k);
      for (std::size_t i = 0; i < size(); ++i) {
        in_flight[i] += (1 - projected[i].act) * step_[i];
        compression[i] = rho_[i] / s_.fluid.rest_density - 1;  // that the last sweep saw
      }
    }
    for (std::size_t i = 0; i < size(); ++i) {
      const Vec3 wall = has_walls() ? walls_.at(p_[i]).gradient : Vec3(Vec3::Zero());
      const Real nearer = wall.dot(cloud_.velocity[i]) * dt_, pushed = in_flight[i] * wall.squaredNorm();
      if (nearer * pushed < 0) cloud_.velocity[i] += std::min(-nearer / pushed, 2 / 1.25) * in_flight[i] * wall / dt_;
      for (const std::size_t j : near_[i])
        cloud_.velocity[i] += mass_ / s_.fluid.rest_density * (in_flight[i] + in_flight[j]) * pull(between(i, j)) / dt_;
    }
    for (const std::vector<std::size_t>& piece : pieces)
      for (const std::size_t i : piece) lifted_[i] = momentum(piece, free_place, free_velocity).is_free() ? 1 : 0;
    const Vectors smooth = projection_.smooth_shifts(start, p_, compression);
    Vectors shifts(size()), motion(size());
    for (std::size_t i = 0; i < size(); ++i) {
      if (lifted_[i] == 0 && in_flight[i] == 0) lifted_[i] = flies(projected[i].u, free_place[i]);
      p_[i] = shifted(p_[i], -smooth[i]);
      shifts[i] = p_[i] - start[i];
      motion[i] = cloud_.velocity[i] * dt_;
    }
    const Vectors carried = projection_.carried(start, shifts, motion);
    for (std::size_t i = 0; i < size(); ++i) cloud_.velocity[i] += carried[i] / dt_;
    for (const std::vector<std::size_t>& piece : pieces) restore(piece, momentum(piece, free_place, free_velocity));
  }

  /// Of the particles of a piece of water, each of unit mass.
  struct Momentum {
    Vec3 linear = Vec3::Zero(), angular = Vec3::Zero();  // about the origin
    Vec3 centre = Vec3::Zero();
    std::array<bool, 3> touched{};  // whether a wall across the axis is near
    bool is_free() const { return !touched[0] && !touched[1] && !touched[2]; }
  };
  Momentum momentum(const std::vector<std::size_t>& piece, const Vectors& place, const Vectors& velocity) const {
    Momentum sum;
    for (const std::size_t i : piece) {
      sum.linear += velocity[i];
      sum.angular += place[i].cross(velocity[i]);
      sum.centre += place[i] / static_cast<Real>(piece.size());
      for (int a = 0; a < 3; ++a) {
        const Real gap = std::min(place[i][a] - s_.domain.min[a], s_.domain.max[a] - place[i][a]);
        if (!is_open(a) && gap <= 1.25 * h()) sum.touched[static_cast<std::size_t>(a)] = true;
      }
    }
    return sum;
  }
  /// Gives a piece back the momentum that it had along axes across which no wall is near, by a translation; and if none
  /// is near at all by a rotation about its centre, which goes where free flight takes it, but where the box repeats.
  void restore(const std::vector<std::size_t>& piece, const Momentum& before) {
    const Momentum after = momentum(piece, p_, cloud_.velocity);
    Vec3 turn = Vec3::Zero();
    const Vec3 centre = after.centre, off = after.centre - before.centre;
    Vec3 gained = after.linear - before.linear;
    for (std::size_t a = 0; a < 3; ++a)
      if (before.touched[a] || after.touched[a]) gained[static_cast<Eigen::Index>(a)] = 0;
    Eigen::Matrix3d inertia = Eigen::Matrix3d::Zero();
    for (const std::size_t i : piece) {
      const Vec3 r = p_[i] - centre;
      inertia += r.squaredNorm() * Eigen::Matrix3d::Identity() - r * r.transpose();
    }
    const bool turns = before.is_free() && after.is_free() && !repeats(0) && !repeats(1) && !repeats(2);
    if (turns && inertia.determinant() > 1e-9 * std::pow(inertia.trace(), 3))
      turn = inertia.fullPivLu().solve(after.angular - after.centre.cross(after.linear) - before.angular +
                                       before.centre.cross(before.linear));
    for (const std::size_t i : piece) {
      cloud_.velocity[i] -= gained / static_cast<Real>(piece.size()) + turn.cross(p_[i] - centre);
      if (turns) p_[i] -= off;
    }
  }

  void apply_forces(const StepInfo& info) {
    for (std::size_t i = 0; i < size(); ++i) {
      Vec3& v = cloud_.velocity[i];
      if (s_.gravity) v += dt_ * *s_.gravity;
      for (std::size_t f = 0; f < s_.fountains.size(); ++f) {
        const FountainSettings& fountain = s_.fountains[f];
        const Vec3 r = cloud_.position[i] - Vec3(fountain.center[0], fountain.center[1], s_.domain.min.z());
        const bool inside = std::hypot(r.x(), r.y()) <= fountain.diameter / 2 && r.z() <= fountain.height;
        if (!inside || info.time < fountain.start || info.time >= fountain.stop) continue;
        const Real u = uniform(s_.seed, cloud_.id[i], info, static_cast<int>(f));
        v = fountain.direction.normalized() * (fountain.speed + fountain.jitter * u);
      }
    }
  }

  /// Time until p + t v leaves the box and the axis along which it does; −1 if not before `t`.
  std::pair<Real, int> exit_time(const Vec3& p, const Vec3& v, Real t) const {
    int axis = -1;
    for (int a = 0; a < 3; ++a) {
      if (v[a] == 0 || is_open(a)) continue;
      const Real plane = v[a] > 0 ? s_.domain.max[a] : s_.domain.min[a];
      if ((plane - p[a]) / v[a] < t) {
        t = (plane - p[a]) / v[a];
        axis = a;
      }
    }
    return {t, axis};
  }

  /// Algorithm 3, velocity part.
  Vec3 fly(const Vec3& p, Vec3 v, Real t) const {
    const auto [t1, axis] = exit_time(p, v, t);
    if (axis < 0) return p + t * v;
    Vec3 at = p + t1 * v;
    at[axis] = v[axis] > 0 ? s_.domain.max[axis] : s_.domain.min[axis];
    v[axis] = -v[axis];
    if (s_.walls.reflection == Reflection::report) {
      v *= s_.walls.restitution;
    } else {
      v[axis] *= s_.walls.restitution;
    }
    return fly(at, v, t - t1);
  }

  /// Algorithm 3, Δp part.
  Vec3 shifted(const Vec3& p, const Vec3& d) const {
    if (s_.walls.reflection == Reflection::normal) {
      Vec3 at = p + d;
      for (int a = 0; a < 3; ++a)
        if (!is_open(a)) at[a] = std::clamp(at[a], s_.domain.min[a], s_.domain.max[a]);
      return at;
    }
    const auto [t1, axis] = exit_time(p, d, 1);
    Vec3 at = p + t1 * d;
    if (axis >= 0) at[axis] = d[axis] > 0 ? s_.domain.max[axis] - 1e-6 * h() : s_.domain.min[axis] + 1e-6 * h();
    return at;
  }

  void find_neighbours() {
    near_.assign(size(), {});
    for (std::size_t i = 0; i < size(); ++i)
      for (std::size_t j = 0; j < size(); ++j)
        if (j != i && between(i, j).norm() < h()) near_[i].push_back(j);
  }

  void find_densities() {
    rho_.assign(size(), 0);
    for (std::size_t i = 0; i < size(); ++i) {
      rho_[i] = mass_ * density_kernel_(0);
      for (const std::size_t j : near_[i]) rho_[i] += mass_ * density_kernel_(between(i, j).norm());
      if (has_walls()) rho_[i] += s_.fluid.rest_density * walls_.at(p_[i]).density;
    }
  }

  Real lambda_of(std::size_t i) const {
    const Real c = rho_[i] / s_.fluid.rest_density - 1;
    if (s_.density.constraint == Constraint::inequality && c <= 32 * std::numeric_limits<double>::epsilon()) return 0;
    Vec3 own = has_walls() ? walls_.at(p_[i]).gradient : Vec3::Zero();
    Real sum = 0;
    for (const std::size_t j : near_[i]) {
      const Vec3 gradient = mass_ / s_.fluid.rest_density * pull(between(i, j));
      own += gradient;
      sum += gradient.squaredNorm();
    }
    return -c / (own.squaredNorm() + sum + epsilon_);
  }

  /// What a sweep moves along: of Chebyshev the multipliers with a memory of the last step, which a particle drops
  /// whose multiplier opposes it.
  void find_steps(int sweep) {
    const bool chebyshev = s_.density.method == Method::chebyshev;
    const Real r2 = std::pow(s_.density.spectral_radius, 2);
    weight_ = sweep == 0 || !chebyshev ? 1 : sweep == 1 ? 1 / (1 - r2 / 2) : 1 / (1 - r2 * weight_ / 4);
    for (std::size_t i = 0; i < size(); ++i) {
      const Real lambda = lambda_of(i);
      const Real memory = lambda * step_[i] > 0 ? (weight_ - 1) * step_[i] : 0;
      step_[i] = weight_ * s_.density.relaxation * lambda + memory;
      // The cap: no pair is pushed apart by more than max_shift h, at the largest gradient there is.
      const Real steepest = mass_ / s_.fluid.rest_density * gradient_kernel_.steepest();
      if (s_.density.max_shift > 0) step_[i] = std::max(step_[i], -s_.density.max_shift * h() / (2 * steepest));
    }
  }

  /// One iteration: all from the old p*. The relaxation is in the steps, but not in s_corr, which jacobi relaxes too.
  void iterate(int sweep) {
    find_densities();
    find_steps(sweep);
    const Real share = s_.density.method == Method::chebyshev ? 1 : s_.density.relaxation.value();
    Vectors moved(size());
    for (std::size_t i = 0; i < size(); ++i) {
      Vec3 delta = Vec3::Zero();
      for (const std::size_t j : near_[i]) {
        const Vec3 r = between(i, j);
        const Real s_corr =
            s_.tensile ? -k_ * std::pow(poly6(r.norm()) / poly6(s_.tensile->dq * h()), s_.tensile->n) : 0;
        delta += mass_ / s_.fluid.rest_density * (step_[i] + step_[j] + share * s_corr) * pull(r);
      }
      if (has_walls()) delta += step_[i] * walls_.at(p_[i]).gradient;
      moved[i] = shifted(p_[i], delta);
    }
    p_ = moved;
  }

  void confine_vorticity() {
    Vectors omega(size(), Vec3::Zero()), v = cloud_.velocity;
    for (std::size_t i = 0; i < size(); ++i)
      for (const std::size_t j : near_[i]) omega[i] += mass_ * (v[j] - v[i]).cross(-spiky(between(i, j)));
    for (std::size_t i = 0; i < size(); ++i) {
      Vec3 eta = Vec3::Zero();
      for (const std::size_t j : near_[i])
        eta += mass_ / s_.fluid.rest_density * (omega[j].norm() - omega[i].norm()) * spiky(between(i, j));
      if (eta.norm() > 0) cloud_.velocity[i] += dt_ * *s_.vorticity * (eta / eta.norm()).cross(omega[i]);
    }
  }

  void smooth() {
    const Vectors v = cloud_.velocity;
    for (std::size_t i = 0; i < size(); ++i)
      for (const std::size_t j : near_[i])
        cloud_.velocity[i] += *s_.viscosity * mass_ * (v[j] - v[i]) * poly6(between(i, j).norm());
  }

  Scene s_;
  Cloud cloud_;
  ReferenceKernel density_kernel_, gradient_kernel_;
  ReferenceWalls walls_;
  ReferenceProjection projection_;
  Real mass_ = 0, epsilon_ = 0, k_ = 0, dt_ = 0, weight_ = 1;
  std::int64_t steps_ = 0;
  Vectors p_;
  std::vector<std::vector<std::size_t>> near_;
  std::vector<Real> rho_, step_, lifted_;
};

}  // namespace trevi::test
