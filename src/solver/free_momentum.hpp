// Keeps the linear and angular momentum of water that touches nothing, beside what gravity gives. The projection hands
// its pressure to the particles of a face as if they were as many as full water has there, and sweeps shift positions
// without velocity: both are right in the mean, but not to rounding. What the substep has changed of the two momenta is
// undone by a translation and a rotation of all velocities, where the box repeats along an axis by a translation alone;
// and their centre goes back to where free flight takes it.
// Collective.
#pragma once

#include "solver/density_solver.hpp"
#include "trevi/box.hpp"

namespace trevi {

template <class T>
class FreeMomentum : public DensitySolver<T> {
 public:
  /// `solver` sets velocities.
  FreeMomentum(const DensitySolverContext& context, std::unique_ptr<DensitySolver<T>> solver);

  void begin(DensityProblem<T>& problem) override { solver_->begin(problem); }
  SolveResult solve(DensityProblem<T>& problem) override;
  bool sets_velocities() const override { return true; }
  std::size_t bytes() const override { return solver_->bytes(); }

 private:
  // Over all particles: their number, how many are near a wall or an obstacle, Σ p, Σ v, Σ p × v and Σ p pᵀ.
  struct Sums {
    Real count = 0, near_walls = 0;
    Vec3 p = Vec3::Zero(), v = Vec3::Zero(), spin = Vec3::Zero();
    Eigen::Matrix3d pp = Eigen::Matrix3d::Zero();

    template <class Visit>
    void for_each(const Visit& visit) {
      visit(count);
      visit(near_walls);
      for (Vec3* sum : {&p, &v, &spin})
        for (Real& number : *sum) visit(number);
      for (Real& number : pp.reshaped()) visit(number);
    }
  };
  template <class Velocity>
  Sums sums_of(DensityProblem<T>& problem, const Velocity& velocity) const;

  bool is_near_solid(const Vec3& p) const;
  bool is_free(const Vec3& p) const;
  bool is_touched(const DensityProblem<T>& problem) const;

  MPI_Comm comm_;
  Box interior_;  // m, where no wall acts
  bool turns_;    // whether there is an angular momentum to keep
  Obstacles* obstacles_;
  std::unique_ptr<DensitySolver<T>> solver_;
};

}  // namespace trevi
