// The time step of position based fluids (report, Algorithm 1) on slabs, and the state it advances.
// Collective throughout: all ranks make the same calls. Between steps each rank owns the particles in its slab; during
// a step the neighbour list, the ghosts and the order are frozen from the prediction to the end of the filters.
#pragma once

#include <memory>
#include <vector>

#include "domain/balance.hpp"
#include "domain/migrate.hpp"
#include "fluid/velocity_filter.hpp"
#include "parallel/stopwatch.hpp"
#include "solver/density_method.hpp"
#include "solver/diagnostics.hpp"
#include "solver/guard.hpp"
#include "trevi/box.hpp"
#include "trevi/forcing.hpp"
#include "trevi/observer.hpp"

namespace trevi {

/// How a step is split: into n equal parts with dt v_max ≤ cfl h, dt ≤ 0.25 √(h/|g|) and dt ≤ longest; never, where cfl
/// is 0.
struct SubstepRule {
  Real cfl = 0;
  Vec3 gravity = Vec3::Zero();  ///< m/s²
  Real longest = INFINITY;      ///< s, what viscosity allows
};

/// What the program sees of a solver, whatever its precision.
class Solver {
 public:
  virtual ~Solver() = default;

  /// Sorts the start, notifies the observers of step 0. Once, before the first step of a run that is not a restart.
  virtual void start() = 0;
  /// One step of length clock.dt, observers included. Throws BlowUp on all ranks alike.
  virtual void step() = 0;
  /// Makes the observers save what a restart needs, between two steps.
  virtual void save() = 0;
  /// What is asked of the run from outside, agreed at the end of the last step.
  virtual const RequestCounts& requests() const = 0;
  /// Tells the observers that the run is over, whatever its reason.
  virtual void finish() = 0;

  virtual const Clock& clock() const = 0;
  virtual const Particles& particles() const = 0;

  /// Work and traffic of this rank so far, for run.json.
  struct Counters {
    double pair_passes = 0;       ///< as DensityProblem::pair_passes()
    std::int64_t iterations = 0;  ///< density iterations, summed over substeps
    std::int64_t substeps = 0;
    std::int64_t unconverged = 0;  ///< solves that missed their tolerance
    std::int64_t halo_bytes = 0, halo_messages = 0, migrated = 0;
    Balance::History balance;
    std::size_t bytes = 0;  ///< memory of particles, ghosts, lists and everything else the solver holds
    double seconds = 0;     ///< in step(), observers not counted
  };
  virtual Counters counters() const = 0;
  /// What the fountains do at the clock's time, in the order of the scene.
  virtual std::vector<FountainState> fountains() const = 0;
};

/// Everything a solver is made of; filled by the scene builder.
template <class T>
struct SolverParts {
  MPI_Comm comm = MPI_COMM_NULL;
  Box box;
  std::unique_ptr<CellGrid> grid;
  std::unique_ptr<Slabs> slabs;
  std::unique_ptr<Balance> balance;
  std::unique_ptr<Walls> walls;
  std::unique_ptr<DensityConstraint<T>> constraint;
  std::unique_ptr<DensityMethod<T>> method;
  std::vector<std::unique_ptr<Forcing>> forcings;
  std::vector<std::unique_ptr<VelocityFilter<T>>> filters;
  std::vector<std::unique_ptr<Observer>> observers;
  std::unique_ptr<DiagnosticsSum> diagnostics;
  SubstepRule substeps;
  Clock clock;
  std::function<RequestCounts()> requests;  ///< of this rank, from outside; may be empty
  Particles particles;                      ///< those in this rank's slab by position
};

template <class T>
class PbfSolver : public Solver {
 public:
  explicit PbfSolver(SolverParts<T> parts);

  void start() override;
  void step() override;
  void save() override;
  const RequestCounts& requests() const override { return guard_.requests(); }
  void finish() override;

  const Clock& clock() const override { return parts_.clock; }
  const Particles& particles() const override { return parts_.particles; }
  Counters counters() const override;
  std::vector<FountainState> fountains() const override;

 private:
  void advance(const StepInfo& info);
  void predict(Real dt);
  void follow(std::vector<Vec3> Particles::*place);
  void find_neighbours(Real dt);
  void update_velocities(Real dt);
  int choose_substeps() const;
  bool wanted(bool (Observer::*what)() const, std::int64_t step) const;
  void observe();
  void count_work();
  Frame plain_frame();

  SolverParts<T> parts_;
  Guard guard_;
  Neighbourhood<T> near_;
  DensityProblem<T> problem_;
  bool last_substep_ = false, measure_drift_ = false;
  Real drift_ = 0;  // farthest a particle went since the search, m; measured only on steps that report it
  Counters counters_;
  Stopwatch stopwatch_;
  SolveResult last_solve_;
  std::int64_t iterations_before_step_ = 0;
  std::vector<FountainState> fountain_states_;  // what the frames of observers point to
  Event predict_event_{"Predict"}, migrate_event_{"Migrate"}, update_event_{"UpdateVelocity"};
  Event diagnostics_event_{"Diagnostics"};
};

extern template class PbfSolver<float>;
extern template class PbfSolver<double>;

}  // namespace trevi
