// Keeps the angular momentum of water in free flight, without gravity and away from walls and obstacles. The density
// solve changes it slightly: the shifts of a pair are along its predicted distance p_ij, but change velocities, which
// count from the positions x at the start of the step, so that each pair adds a torque, some 1e-4 of the motion where
// jets meet. It is undone by a rotation of all the water, which changes no density. Linear momentum is kept by the
// pairs themselves. Collective.
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
  // Sums over all particles: their number, the number near a wall or an obstacle, and Σ x, Σ x xᵀ and Σ x × p, with x
  // the positions at the start of the step and p the present ones.
  struct Sums {
    Real count = 0, near_walls = 0;
    Vec3 x = Vec3::Zero(), moment = Vec3::Zero();
    Eigen::Matrix3d xx = Eigen::Matrix3d::Zero();
  };
  Sums sums_of(DensityProblem<T>& problem) const;

  MPI_Comm comm_;
  Box interior_;  // m, where no wall acts
  const Obstacles* obstacles_;
  std::unique_ptr<DensitySolver<T>> solver_;
};

}  // namespace trevi
