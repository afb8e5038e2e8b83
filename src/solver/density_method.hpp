// How the density constraints of all particles are solved together. Each method is an iteration over DensityProblem's
// sweeps and leaves p* corrected, inside the walls, with fresh ghosts. Collective; the same bits on any rank count, but
// for anderson, whose dot products are PETSc's.
//   jacobi     p* += relaxation · delta (report, Algorithm 1; relaxation 1 there)
//   chebyshev  the same accelerated by Chebyshev weights (Wang 2015), kept on the multipliers
//   anderson   the same as a fixed-point map under PETSc's SNES (-snes_* options reach it)
// With `coarse_grid` the first iteration of any of them is the coarse-grid correction, where gravity makes pressure
// over longer ways: without it sweeps over pairs do as well, and keep momentum to rounding.
#pragma once

#include <memory>

#include "solver/density_problem.hpp"
#include "trevi/box.hpp"
#include "trevi/settings.hpp"

namespace trevi {

struct SolveResult {
  int iterations = 0;
  bool converged = true;  ///< always, when no tolerance was asked for
};

template <class T>
class DensityMethod {
 public:
  virtual ~DensityMethod() = default;
  virtual SolveResult solve(DensityProblem<T>& problem) = 0;
  virtual std::size_t bytes() const { return 0; }
};

/// What the methods need to know of the scene and the machine.
struct MethodContext {
  MPI_Comm comm;
  const CellGrid& grid;
  const Box& box;
  const DensityModel& model;
  Real spacing;
  Vec3 gravity;  ///< m/s²
};

/// Whether the coarse grid, whose columns stand upright, can serve: gravity down, and less of it sideways.
bool is_downward(const Vec3& gravity);

template <class T>
std::unique_ptr<DensityMethod<T>> make_density_method(const DensitySettings& settings, const MethodContext& context);

/// Whether the compression at the last densities meets the tolerance (mean; ten times it for the largest); never
/// without one.
template <class T>
bool within_tolerance(const DensitySettings& settings, const DensityProblem<T>& problem) {
  if (!settings.tolerance) return false;
  const Compression c = problem.compression();
  return c.mean <= *settings.tolerance && c.max <= 10 * *settings.tolerance;
}

/// The same of where the last sweep has left p*, for which the density is summed once more; true without a tolerance.
template <class T>
bool ends_within_tolerance(const DensitySettings& settings, DensityProblem<T>& problem) {
  if (!settings.tolerance) return true;
  problem.compute_density();
  return within_tolerance(settings, problem);
}

/// A shift shortened to `longest`, m; 0: as it is.
inline Vec3 capped(const Vec3& shift, Real longest) {
  const Real length = shift.norm();
  return longest > 0 && length > longest ? Vec3(shift * (longest / length)) : shift;
}

}  // namespace trevi
