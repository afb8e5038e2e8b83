#include "solver/free_flight.hpp"

#include <Eigen/Geometry>
#include <Eigen/LU>

#include "base/threads.hpp"
#include "fluid/obstacles/obstacles.hpp"
#include "parallel/reductions.hpp"

namespace trevi {

namespace {

// How far from a wall its share of the density reaches, in units of h; this is the largest value, at h = 1.2 spacings.
constexpr Real wall_reach = 1.25;

}  // namespace

template <class T>
FreeFlight<T>::FreeFlight(const DensitySolverContext& context, std::unique_ptr<DensitySolver<T>> solver)
    : comm_(context.comm),
      interior_{context.box.min.array() + wall_reach * context.model.h,
                context.box.max.array() - wall_reach * context.model.h},
      obstacles_(context.obstacles),
      solver_(std::move(solver)) {}

template <class T>
typename FreeFlight<T>::Sums FreeFlight<T>::sums_of(DensityProblem<T>& problem) const {
  constexpr int columns = sizeof(Sums) / sizeof(Real);
  const Particles& particles = problem.particles();
  std::vector<Sums> partial(static_cast<std::size_t>(problem.order().planes()));
  for_each_part(problem.order().planes(), [&](LocalId plane) {
    Sums& sums = partial[static_cast<std::size_t>(plane)];
    const auto [begin, end] = problem.order().owned_range(plane, plane + 1);
    for (auto i = static_cast<std::size_t>(begin); i < static_cast<std::size_t>(end); ++i) {
      const Vec3 &x = particles.position[i], &p = particles.predicted[i];
      sums.count += 1;
      const bool free = (p.array() > interior_.min.array()).all() && (p.array() < interior_.max.array()).all();
      sums.near_walls += free && (obstacles_ == nullptr || !obstacles_->is_near(p)) ? 0 : 1;
      sums.x += x;
      sums.moment += x.cross(p);
      sums.xx += x * x.transpose();
    }
  });
  const auto* first = reinterpret_cast<const Real*>(partial.data());
  const std::vector<Real> total =
      sum_over_planes(comm_, std::vector<Real>(first, first + columns * partial.size()), columns);
  Sums sums;
  std::copy(total.begin(), total.end(), reinterpret_cast<Real*>(&sums));
  return sums;
}

template <class T>
SolveResult FreeFlight<T>::solve(DensityProblem<T>& problem) {
  const Sums before = sums_of(problem);
  const SolveResult result = solver_->solve(problem);
  const Sums after = sums_of(problem);
  if (before.near_walls + after.near_walls > 0 || before.count == 0) return result;
  const Vec3 centre = before.x / before.count;
  const Eigen::Matrix3d spread = before.xx - before.count * centre * centre.transpose();
  const Eigen::Matrix3d inertia = spread.trace() * Eigen::Matrix3d::Identity() - spread;
  // A single particle or a line of particles has no inertia about some axis, and no rotation about it to correct.
  const Real size = inertia.trace();
  if (inertia.determinant() <= 1e-9 * size * size * size) return result;
  const Vec3 turn = inertia.inverse() * (after.moment - before.moment);
  const std::vector<Vec3>& x = problem.particles().position;
  const std::vector<Vec3>& p = problem.particles().predicted;
  problem.with_halo(Phase::move, [&](Range part) {
    problem.set_positions(part, [&](LocalId i) {
      const auto k = static_cast<std::size_t>(i);
      return Vec3(p[k] - turn.cross(x[k] - centre));
    });
  });
  return result;
}

template class FreeFlight<float>;
template class FreeFlight<double>;

}  // namespace trevi
