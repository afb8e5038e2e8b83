#include "solver/anderson.hpp"

#include <petscsnes.h>

#include "trevi/error.hpp"

namespace trevi {

namespace {

void check(PetscErrorCode code) {
  require(code == 0, "PETSc's nonlinear solver failed with code " + std::to_string(code));
}

/// The shift, shortened to the length `longest` (m) where it is longer; 0 means no limit.
Vec3 capped(const Vec3& shift, Real longest) {
  const Real length = shift.norm();
  return longest > 0 && length > longest ? Vec3(shift * (longest / length)) : shift;
}

// Sets p* of all particles from an array with three coordinates per particle, clamped to the box.
template <class T>
void set_all_positions(DensityProblem<T>& problem, const PetscScalar* positions) {
  problem.with_halo(Phase::move, [&](Range part) {
    problem.set_positions(part,
                          [&](LocalId i) { return problem.walls().clamp(Eigen::Map<const Vec3>(positions + 3 * i)); });
  });
}

// What the residual function needs; SNES passes it on as a void pointer.
template <class T>
struct Residual {
  DensityProblem<T>& problem;
  Real relaxation, longest;
};

// Puts the particles at `x`, inside the walls, and evaluates −relaxation · delta there.
template <class T>
PetscErrorCode evaluate(SNES, Vec x, Vec f, void* context) {
  auto& residual = *static_cast<Residual<T>*>(context);
  const PetscScalar* positions = nullptr;
  PetscScalar* out = nullptr;
  PetscCall(VecGetArrayRead(x, &positions));
  set_all_positions(residual.problem, positions);
  PetscCall(VecRestoreArrayRead(x, &positions));
  residual.problem.with_halo(
      Phase::lambda, [&](Range part) { residual.problem.compute_lambda(part, [](T lambda, T) { return lambda; }); });
  residual.problem.compute_delta();
  PetscCall(VecGetArray(f, &out));
  for (LocalId i = 0; i < residual.problem.particles().size(); ++i)
    Eigen::Map<Vec3>(out + 3 * i) = -capped(residual.relaxation * residual.problem.delta(i), residual.longest);
  PetscCall(VecRestoreArray(f, &out));
  return 0;
}

// Ends the iteration on the compression that the user asked for; SNES itself would test the norm of the shift.
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
  const std::vector<Vec3>& positions = problem.particles().predicted;
  const auto size = static_cast<PetscInt>(3 * positions.size());  // no overflow: first_slabs() has checked it
  Residual<T> residual{problem, settings_.relaxation, longest_};
  std::pair<const DensitySettings*, DensityProblem<T>*> goal{&settings_, &problem};
  Vec start = nullptr, f = nullptr;
  SNES snes = nullptr;
  // The unknowns are a copy: SNES combines earlier iterates, while each evaluation moves the particles themselves.
  check(VecCreateMPI(comm_, size, PETSC_DETERMINE, &start));
  check(VecDuplicate(start, &f));
  PetscScalar* values = nullptr;
  check(VecGetArray(start, &values));
  PetscScalar* next = values;
  for (const Vec3& p : positions) next = std::copy(p.begin(), p.end(), next);
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
  set_all_positions(problem, values);
  check(VecRestoreArray(start, &values));
  check(SNESDestroy(&snes));
  check(VecDestroy(&f));
  check(VecDestroy(&start));
  return {static_cast<int>(iterations), !settings_.tolerance || reason > 0};
}

template class Anderson<float>;
template class Anderson<double>;

}  // namespace trevi
