#include "solver/anderson.hpp"

#include <petscsnes.h>

#include "trevi/error.hpp"

namespace trevi {

namespace {

void check(PetscErrorCode code) {
  require(code == 0, "PETSc's nonlinear solver failed with code " + std::to_string(code));
}

// What the residual needs; SNES hands it back as a void pointer.
template <class T>
struct Residual {
  DensityProblem<T>& problem;
  Real relaxation, longest;
  bool stop = false;  // the tolerance was met
};

// Puts the particles at `x`, inside the walls, and evaluates −relaxation · delta there.
template <class T>
PetscErrorCode evaluate(SNES, Vec x, Vec f, void* context) {
  auto& residual = *static_cast<Residual<T>*>(context);
  const PetscScalar* place = nullptr;
  PetscScalar* out = nullptr;
  PetscCall(VecGetArrayRead(x, &place));
  residual.problem.move([&](std::size_t i, const Vec3&, const Vec3&) {
    return residual.problem.walls().clamp(Eigen::Map<const Vec3>(place + 3 * i));
  });
  PetscCall(VecRestoreArrayRead(x, &place));
  residual.problem.compute_lambda();
  residual.problem.compute_delta();
  PetscCall(VecGetArray(f, &out));
  residual.problem.for_each_delta([&](std::size_t i, const Vec3& delta) {
    Eigen::Map<Vec3>(out + 3 * i) = -capped(residual.relaxation * delta, residual.longest);
  });
  PetscCall(VecRestoreArray(f, &out));
  return 0;
}

// Stops on the compression that the user asked for, not on the norm of a displacement.
template <class T>  // PETSc gives the parameters. NOLINTNEXTLINE(readability-function-size)
PetscErrorCode test(SNES, PetscInt it, PetscReal, PetscReal, PetscReal, SNESConvergedReason* reason, void* context) {
  const auto& settings_and_problem = *static_cast<std::pair<const DensitySettings*, DensityProblem<T>*>*>(context);
  const bool met = within_tolerance(*settings_and_problem.first, *settings_and_problem.second);
  *reason = met                                            ? SNES_CONVERGED_FNORM_ABS
            : it >= settings_and_problem.first->iterations ? SNES_DIVERGED_MAX_IT
                                                           : SNES_CONVERGED_ITERATING;
  return 0;
}

}  // namespace

template <class T>
SolveResult Anderson<T>::solve(DensityProblem<T>& problem) {
  std::vector<Vec3>& places = problem.particles().predicted;
  const auto size = static_cast<PetscInt>(3 * places.size());  // fits: initial_particles() has seen to it
  Residual<T> residual{problem, settings_.relaxation, longest_};
  std::pair<const DensitySettings*, DensityProblem<T>*> goal{&settings_, &problem};
  Vec start = nullptr, f = nullptr;
  SNES snes = nullptr;
  // The unknowns start as a copy: SNES combines old iterates while the sweep moves the particles themselves.
  check(VecCreateMPI(comm_, size, PETSC_DETERMINE, &start));
  check(VecDuplicate(start, &f));
  PetscScalar* values = nullptr;
  check(VecGetArray(start, &values));
  std::copy(places.begin(), places.end(), reinterpret_cast<Vec3*>(values));
  check(VecRestoreArray(start, &values));
  check(SNESCreate(comm_, &snes));
  check(SNESSetType(snes, SNESANDERSON));
  check(SNESSetFunction(snes, f, evaluate<T>, &residual));
  check(SNESSetConvergenceTest(snes, test<T>, &goal, nullptr));
  check(SNESSetTolerances(snes, 0, 0, 0, settings_.iterations, 100000));
  check(SNESSetFromOptions(snes));
  check(SNESSolve(snes, nullptr, start));
  PetscInt iterations = 0;
  SNESConvergedReason reason = SNES_CONVERGED_ITERATING;
  check(SNESGetIterationNumber(snes, &iterations));
  check(SNESGetConvergedReason(snes, &reason));
  check(VecGetArray(start, &values));
  problem.move([&](std::size_t i, const Vec3&, const Vec3&) {
    return problem.walls().clamp(Eigen::Map<const Vec3>(values + 3 * i));
  });
  check(VecRestoreArray(start, &values));
  check(SNESDestroy(&snes));
  check(VecDestroy(&f));
  check(VecDestroy(&start));
  return {static_cast<int>(iterations), !settings_.tolerance || reason > 0};
}

template class Anderson<float>;
template class Anderson<double>;

}  // namespace trevi
