#include "trevi/solver/density_problem.hpp"

#include <algorithm>

#include "trevi/base/growth.hpp"
#include "trevi/parallel/reductions.hpp"

namespace trevi {

template <class T>
DensityProblem<T>::DensityProblem(MPI_Comm comm, Neighbourhood<T>& near, const DensityConstraint<T>& constraint,
                                  const Walls& walls)
    : comm_(comm), near_(near), constraint_(constraint), walls_(walls) {}

template <class T>
void DensityProblem<T>::start(Particles& particles) {
  particles_ = &particles;
  resize_tightly(rho_, particles.id.size());
  resize_tightly(delta_, particles.id.size());
}

template <class T>
void DensityProblem<T>::lambda_of(PlaneRun run) {
  constraint_.lambdas(pairs(), {run.begin, run.end}, particles_->predicted, rho_, near_.records());
  const auto run_pairs = static_cast<double>(near_.list().first(run.end) - near_.list().first(run.begin));
  log_flops(run_pairs * DensityConstraint<T>::density_flops);
}

template <class T>
void DensityProblem<T>::compute_delta() {
  const ScopedEvent timed(delta_event_);
  constraint_.deltas(pairs(), {0, near_.order().owned()}, particles_->predicted, delta_);
  log_flops(static_cast<double>(near_.list().pairs()) * DensityConstraint<T>::delta_flops);
}

template <class T>
void DensityProblem<T>::compute_coarse_delta(CoarseCorrection& coarse) {
  compute_density();
  coarse.displacements<T>(near_.order(), rho_, particles_->predicted, delta_);
}

template <class T>
void DensityProblem<T>::compute_density() {
  const ScopedEvent timed(lambda_event_);
  constraint_.densities(pairs(), {0, near_.order().owned()}, particles_->predicted, rho_);
  log_flops(static_cast<double>(near_.list().pairs()) * DensityConstraint<T>::density_flops);
}

template <class T>
Compression DensityProblem<T>::compression() const {
  std::vector<Real> partial;
  Real largest = 0;
  for (LocalId plane = 0; plane < near_.order().planes(); ++plane) {
    const auto [begin, end] = near_.order().owned_range(plane, plane + 1);
    Real sum = 0;
    for (LocalId i = begin; i < end; ++i) {
      const Real c = std::max(rho_[static_cast<std::size_t>(i)] / constraint_.model().rest_density - 1, 0.0);
      sum += c;
      largest = std::max(largest, c);
    }
    partial.push_back(sum);
    partial.push_back(static_cast<Real>(end - begin));
  }
  const std::vector<Real> total = sum_over_planes(comm_, partial, 2);
  return {total[1] > 0 ? total[0] / total[1] : 0, max_over_ranks(comm_, largest)};
}

template class DensityProblem<float>;
template class DensityProblem<double>;

}  // namespace trevi
