// The density solve of a substep (report, Algorithm 1, lines 8 to 19): an iteration over the four parts of
// DensityProblem, lambda, delta, collide and move, with the halos between them. It leaves p* corrected, inside the
// walls and with fresh ghosts. Collective; the same bits on any rank count, but for anderson, whose dot products are
// PETSc's.
//   jacobi     p* += relaxation · delta (relaxation 1 in the report)
//   chebyshev  the same accelerated by Chebyshev weights (Wang 2015), kept on the multipliers
//   anderson   the same as a fixed-point map under PETSc's SNES (-snes_* options reach it)
// With `coarse_grid` the first iteration of any of them is the coarse-grid correction, where gravity makes pressure
// over longer ways. Without gravity the iterations do as well, and keep momentum to rounding.
#pragma once

#include <memory>

#include "solver/density_problem.hpp"
#include "trevi/settings.hpp"

namespace trevi {

struct SolveResult {
  int iterations = 0;
  bool converged = true;  ///< always, when no tolerance was asked for
};

template <class T>
class DensitySolver {
 public:
  virtual ~DensitySolver() = default;
  virtual SolveResult solve(DensityProblem<T>& problem) = 0;
  virtual std::size_t bytes() const { return 0; }
};

/// What a density solver needs to know of the scene and the machine.
struct DensitySolverContext {
  MPI_Comm comm;
  const CellGrid& grid;
  const Box& box;
  const DensityModel& model;
  Real spacing;
  Vec3 gravity;  ///< m/s²
};

/// Whether the coarse grid, whose columns stand upright, can serve: gravity down, and less of it sideways.
bool is_downward(const Vec3& gravity);

/// `settings` are resolved.
template <class T>
std::unique_ptr<DensitySolver<T>> make_density_solver(const DensitySettings& settings,
                                                      const DensitySolverContext& context);

/// Whether the compression at the last densities meets the tolerance (mean; ten times it for the largest); never
/// without one.
template <class T>
bool within_tolerance(const DensitySettings& settings, const DensityProblem<T>& problem) {
  if (!settings.tolerance) return false;
  const Compression c = problem.compression();
  return c.mean <= *settings.tolerance && c.max <= 10 * *settings.tolerance;
}

/// The same of where the last iteration has left p*, for which the density is summed once more; true without a
/// tolerance.
template <class T>
bool ends_within_tolerance(const DensitySettings& settings, DensityProblem<T>& problem) {
  if (!settings.tolerance) return true;
  problem.compute_density();
  return within_tolerance(settings, problem);
}

}  // namespace trevi
