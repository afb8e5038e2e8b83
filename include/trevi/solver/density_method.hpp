// How the density constraints of all particles are solved together. Each method is an iteration over DensityProblem's
// sweeps and leaves p* corrected, inside the walls, with fresh ghosts. Collective; the same bits on any rank count.
//   jacobi     p* += relaxation · delta (report, Algorithm 1; relaxation 1 there)
#pragma once

#include <memory>

#include "trevi/fluid/settings.hpp"
#include "trevi/solver/density_problem.hpp"

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

/// Builds the method a scene asks for. Throws InputError for one that is not built in.
template <class T>
std::unique_ptr<DensityMethod<T>> make_density_method(const DensitySettings& settings, Real h);

extern template std::unique_ptr<DensityMethod<float>> make_density_method(const DensitySettings&, Real);
extern template std::unique_ptr<DensityMethod<double>> make_density_method(const DensitySettings&, Real);

}  // namespace trevi
