// The density solve of a substep (Macklin & Müller 2013, Algorithm 1, lines 8 to 19): an iteration over the operations
// of DensityProblem, with the halo exchanges between them. Afterwards p* is corrected and inside the walls, and the
// ghosts are up to date. Collective; the same bits on any rank count, except for anderson, which uses PETSc's dot
// products.
//   jacobi     p* += relaxation · delta (relaxation 1 in the paper)
//   chebyshev  the same, accelerated by Chebyshev weights (Wang 2015) on the multipliers
//   anderson   the same as a fixed-point map under PETSc's SNES (-snes_* options apply)
// With `coarse_grid` the first iteration of any of them is the projection (projection/projection.hpp). With chebyshev
// the velocities are then the projection's, and the sweeps after it shift positions only.
#pragma once

#include <memory>

#include "solver/density_problem.hpp"
#include "trevi/settings.hpp"

namespace trevi {

struct SolveResult {
  int iterations = 0;
  bool converged = true;  ///< always if no tolerance was requested
};

template <class T>
class DensitySolver {
 public:
  virtual ~DensitySolver() = default;
  /// The part of the solve that precedes the neighbour search, because it needs no neighbours and uses memory that
  /// their list takes afterwards.
  virtual void begin(DensityProblem<T>&) {}
  virtual SolveResult solve(DensityProblem<T>& problem) = 0;
  /// Whether solve() also sets the velocities; otherwise they are (p* − x)/dt.
  virtual bool sets_velocities() const { return false; }
  virtual std::size_t bytes() const { return 0; }
};

/// The data of the scene and the machine that a density solver needs.
struct DensitySolverContext {
  MPI_Comm comm;
  const CellGrid& grid;
  const Box& box;
  const DensityModel& model;
  Real spacing;
  Vec3 gravity;                      ///< m/s²
  Obstacles* obstacles = nullptr;    ///< null if there are none
  PressureProbes* probes = nullptr;  ///< may be null; a projection shows its pressure to them
  Openings* openings = nullptr;      ///< may be null; those of a projection
  std::shared_ptr<Scratch> scratch = std::make_shared<Scratch>();  ///< for a projection
};

/// Whether the coarse grid can be used: its columns are vertical, so gravity must act more downwards than sideways.
bool is_downward(const Vec3& gravity);
/// Whether velocities are those of the projection, and sweeps shift positions only.
bool shifts_positions_only(const DensitySettings& settings, const Vec3& gravity);

/// `settings` are those of resolved().
template <class T>
std::unique_ptr<DensitySolver<T>> make_density_solver(const DensitySettings& settings,
                                                      const DensitySolverContext& context);

/// Whether the compression at the last computed densities meets the tolerance: the mean is at most the tolerance, and
/// the largest at most ten times the tolerance. Always false without a tolerance.
template <class T>
bool within_tolerance(const DensitySettings& settings, const DensityProblem<T>& problem) {
  if (!settings.tolerance) return false;
  const Compression c = problem.compression();
  return c.mean <= *settings.tolerance && c.max <= 10 * *settings.tolerance;
}

/// The same for the p* of the last iteration, at which the density is computed once more. True without a tolerance.
template <class T>
bool ends_within_tolerance(const DensitySettings& settings, DensityProblem<T>& problem) {
  if (!settings.tolerance) return true;
  problem.compute_density();
  return within_tolerance(settings, problem);
}

}  // namespace trevi
