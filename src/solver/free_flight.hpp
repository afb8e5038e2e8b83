// Water that flies free, without gravity and away from walls, keeps its angular momentum, and the density solve does
// not quite: a shift that pushes two particles apart acts along their predicted distance, but on velocities that carry
// them from where the step began. What torque that makes, some 1e-4 of the motion where jets meet, is taken back as a
// turn of all the water, which changes no density. Linear momentum is kept by the pairs themselves. Collective.
#pragma once

#include "solver/density_solver.hpp"
#include "trevi/box.hpp"

namespace trevi {

template <class T>
class FreeFlight : public DensitySolver<T> {
 public:
  FreeFlight(const DensitySolverContext& context, std::unique_ptr<DensitySolver<T>> solver);

  SolveResult solve(DensityProblem<T>& problem) override;
  std::size_t bytes() const override { return solver_->bytes(); }

 private:
  // Sums over all particles: how many, how many of them near a wall, and of positions x at the beginning of the step
  // and p now Σ x, Σ x xᵀ and Σ x × p.
  struct Sums {
    Real count = 0, near_walls = 0;
    Vec3 x = Vec3::Zero(), moment = Vec3::Zero();
    Eigen::Matrix3d xx = Eigen::Matrix3d::Zero();
  };
  Sums sums_of(DensityProblem<T>& problem) const;

  MPI_Comm comm_;
  Box interior_;  // m, out of reach of the walls
  std::unique_ptr<DensitySolver<T>> solver_;
};

}  // namespace trevi
