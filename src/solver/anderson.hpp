// Anderson mixing of the Jacobi iteration by PETSc: an SNES of type anderson on a Vec that holds a copy of the
// positions p*. One Jacobi iteration G is the fixed-point map, so F(p) = p − G(p) = −relaxation · delta(p). All -snes_*
// options apply. Collective.
#pragma once

#include "solver/density_solver.hpp"

namespace trevi {

template <class T>
class Anderson : public DensitySolver<T> {
 public:
  Anderson(MPI_Comm comm, const DensitySettings& settings, Real h)
      : comm_(comm), settings_(settings), longest_(settings.max_shift * h) {}
  SolveResult solve(DensityProblem<T>& problem) override;

 private:
  MPI_Comm comm_;
  DensitySettings settings_;
  Real longest_;
};

extern template class Anderson<float>;
extern template class Anderson<double>;

}  // namespace trevi
