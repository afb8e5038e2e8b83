// One density solve of a step: positions p* to be moved until rho_i = rho0, on a frozen neighbour list.
// The methods (density_method.hpp) are written in terms of the three operations here; each leaves the ghosts up to
// date, with the messages under way while interior planes are worked on. Collective.
#pragma once

#include "domain/neighbourhood.hpp"
#include "fluid/density.hpp"
#include "fluid/walls.hpp"
#include "solver/coarse_correction.hpp"

namespace trevi {

/// Compression max(0, rho/rho0 − 1) over all particles of all ranks.
struct Compression {
  Real mean = 0, max = 0;
};

template <class T>
class DensityProblem {
 public:
  DensityProblem(MPI_Comm comm, Neighbourhood<T>& near, const DensityConstraint<T>& constraint, const Walls& walls);

  /// Starts a solve for the particles just sorted into `near`, which were predicted over the time dt, s.
  void start(Particles& particles, Real dt);

  /// rho and lambda of all particles from the present p*; ghosts receive lambda.
  void compute_lambda() {
    compute_lambda([](std::size_t, Real lambda) { return lambda; });
  }
  /// The same with lambda_i replaced by use(i, lambda_i).
  template <class Use>
  void compute_lambda(Use&& use);
  /// Compression at the last compute_lambda() or compute_density(), the same bits on any rank count.
  Compression compression() const;
  /// delta of all owned particles from the present lambda, m.
  void compute_delta();
  /// The same array from the coarse grid: displacements that keep the volume over longer ways.
  void compute_coarse_delta(CoarseCorrection& coarse);
  /// Adds to delta a small shift of particles in one place, which no gradient would ever part; opposite for the two.
  void separate_coincident();
  template <class Visit>
  void for_each_delta(Visit&& visit) const {
    for (std::size_t i = 0; i < delta_.size(); ++i) visit(i, vector_of(delta_[i]));
  }
  /// p*_i = place(i, p*_i, delta_i) for all owned particles; ghosts receive the new positions.
  template <class Place>
  void move(Place&& place);

  /// rho at the present p*, without touching lambda; for observers.
  void compute_density();

  const CellOrder& order() const { return near_.order(); }
  const DensityModel& model() const { return constraint_.model(); }
  const Walls& walls() const { return walls_; }
  Particles& particles() { return *particles_; }
  std::span<const Real> density() const { return rho_; }
  /// Pairs times passes over them so far, those for observers among them: what the phases Lambda and Delta consist of.
  double pair_passes() const { return pair_passes_; }
  std::size_t bytes() const { return rho_.capacity() * sizeof(Real) + delta_.capacity() * sizeof(Quad<T>); }

 private:
  Pairs<T> pairs() const { return {near_.records(), near_.list(), near_.order().low_ghosts()}; }
  void lambda_of(Range run);
  void count_pass(Range run, double flops_per_pair);

  MPI_Comm comm_;
  Neighbourhood<T>& near_;
  const DensityConstraint<T>& constraint_;
  const Walls& walls_;
  Particles* particles_ = nullptr;
  Real dt_ = 0;
  std::vector<Real> rho_;
  std::vector<Quad<T>> delta_;
  double pair_passes_ = 0;
  Event lambda_event_{"Lambda"}, delta_event_{"Delta"}, move_event_{"Move"};
};

template <class T>
template <class Place>
void DensityProblem<T>::move(Place&& place) {
  const ScopedEvent timed(move_event_);
  std::vector<Vec3>& p = particles_->predicted;
  const auto update = [&](Range run) {
    for (LocalId i = run.begin; i < run.end; ++i) {
      const auto k = static_cast<std::size_t>(i);
      p[k] = place(k, p[k], vector_of(delta_[k]));
    }
    near_.encode(p, run);
  };
  for (const Range& run : near_.boundary()) update(run);
  near_.halo().start(near_.records());
  update(near_.interior());
  near_.halo().finish();
}

template <class T>
template <class Use>
void DensityProblem<T>::compute_lambda(Use&& use) {
  const ScopedEvent timed(lambda_event_);
  const auto update = [&](Range run) {
    lambda_of(run);
    for (LocalId i = run.begin; i < run.end; ++i) {
      T& w = near_.record(i).w;
      w = static_cast<T>(use(static_cast<std::size_t>(i), static_cast<Real>(w)));
    }
  };
  for (const Range& run : near_.boundary()) update(run);
  near_.halo().start(near_.records());
  update(near_.interior());
  near_.halo().finish();
}

extern template class DensityProblem<float>;
extern template class DensityProblem<double>;

}  // namespace trevi
