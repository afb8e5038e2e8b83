#include "solver/free_momentum.hpp"

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <atomic>

#include "base/threads.hpp"
#include "boundary/obstacles/obstacles.hpp"
#include "domain/plane_sums.hpp"
#include "parallel/reductions.hpp"

namespace trevi {

namespace {

// How far from a wall its contribution to the density reaches, in units of h; this is the largest value, at h = 1.2
// spacings.
constexpr Real wall_reach = 1.25;

}  // namespace

template <class T>
FreeMomentum<T>::FreeMomentum(const DensitySolverContext& context, std::unique_ptr<DensitySolver<T>> solver)
    : comm_(context.comm),
      interior_(context.box),
      turns_(true),
      obstacles_(context.obstacles),
      solver_(std::move(solver)) {
  const CellGrid& grid = context.grid;
  for (std::size_t a = 0; a < 3; ++a) {
    const auto axis = a == 0 ? grid.slab_axis() : a == 1 ? 1 - grid.slab_axis() : 2;
    const bool repeats = grid.is_periodic(a), has_walls = !repeats && !(axis == 1 && grid.is_layer());
    const Real reach = !has_walls ? -INFINITY : wall_reach * context.model.h;
    interior_.min[axis] += reach;
    interior_.max[axis] -= reach;
    turns_ = turns_ && !repeats;
  }
}

// A body that moves freely has what the transfer leaves over, once it is touched.
template <class T>
bool FreeMomentum<T>::is_near_solid(const Vec3& p) const {
  return obstacles_->floating() != nullptr ? obstacles_->is_near_fixed(p) : obstacles_->is_near(p);
}

template <class T>
bool FreeMomentum<T>::is_free(const Vec3& p) const {
  const bool inside = (p.array() > interior_.min.array()).all() && (p.array() < interior_.max.array()).all();
  return inside && (obstacles_ == nullptr || !is_near_solid(p));
}

// Whether a particle is near a wall or a solid; most water has one among the first that are looked at.
template <class T>
bool FreeMomentum<T>::is_touched(const DensityProblem<T>& problem) const {
  const std::vector<Vec3>& p = problem.particles().predicted;
  std::atomic<bool> found = false;
  constexpr LocalId part_size = 512;
  for_each_part(problem.all(), part_size, [&](Range part) {
    for (LocalId i = part.begin; i < part.end && !found.load(std::memory_order_relaxed); ++i)
      if (!is_free(p[static_cast<std::size_t>(i)])) found.store(true, std::memory_order_relaxed);
  });
  return max_over_ranks(comm_, found.load() ? 1.0 : 0.0) > 0;
}

template <class T>
template <class Velocity>
typename FreeMomentum<T>::Sums FreeMomentum<T>::sums_of(DensityProblem<T>& problem, const Velocity& velocity) const {
  const Particles& particles = problem.particles();
  return sum_over_planes<Sums>(comm_, problem.order(), [&](Sums& sums, Range range) {
    for (auto i = static_cast<std::size_t>(range.begin); i < static_cast<std::size_t>(range.end); ++i) {
      const Vec3 &p = particles.predicted[i], v = velocity(i);
      sums.count += 1;
      sums.near_walls += is_free(p) ? 0 : 1;
      sums.p += p;
      sums.v += v;
      sums.spin += p.cross(v);
      sums.pp += p * p.transpose();
    }
  });
}

template <class T>
SolveResult FreeMomentum<T>::solve(DensityProblem<T>& problem) {
  if (is_touched(problem)) return solver_->solve(problem);
  Particles& particles = problem.particles();
  // A free path does not change p × v.
  const Sums before = sums_of(problem, [&, dt = problem.dt()](std::size_t i) {
    return Vec3((particles.predicted[i] - particles.position[i]) / dt);
  });
  const SolveResult result = solver_->solve(problem);
  const Sums after = sums_of(problem, [&](std::size_t i) { return particles.velocity[i]; });
  if (after.near_walls > 0 || before.count == 0) return result;
  if (obstacles_ != nullptr && obstacles_->floating() != nullptr && obstacles_->is_touched(comm_)) return result;
  const Vec3 drift = (after.v - before.v) / after.count, centre = after.p / after.count;
  Vec3 turn = Vec3::Zero();
  const Eigen::Matrix3d spread = after.pp - after.count * centre * centre.transpose();
  const Eigen::Matrix3d inertia = spread.trace() * Eigen::Matrix3d::Identity() - spread;
  // About the centre of all, which goes back to where free flight takes it.
  const auto about_centre = [](const Sums& sums) -> Vec3 { return sums.spin - (sums.p / sums.count).cross(sums.v); };
  // A single particle or a line of particles has no inertia about some axis, and no rotation about it to correct.
  const Real size = inertia.trace();
  if (turns_ && inertia.determinant() > 1e-9 * size * size * size)
    turn = inertia.inverse() * (about_centre(after) - about_centre(before));
  const Vec3 off = turns_ ? Vec3((after.p - before.p) / after.count) : Vec3(Vec3::Zero());
  for_each_index(problem.all(), [&](std::size_t i) {
    particles.velocity[i] -= drift + turn.cross(particles.predicted[i] - centre);
    particles.predicted[i] -= off;
  });
  return result;
}

template class FreeMomentum<float>;
template class FreeMomentum<double>;

}  // namespace trevi
