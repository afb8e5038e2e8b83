// What a solver reports besides the step: rows and frames for the observers, the largest motion of a particle since the
// neighbour list was built (drift), and counts of work. It never changes the state of the solver, except for the
// density, which it computes again when an observer asks for it. Collective: observe, save, finish.
#pragma once

#include <functional>
#include <memory>
#include <vector>

#include "parallel/stopwatch.hpp"
#include "solver/active_absorption.hpp"
#include "solver/density_solver.hpp"
#include "solver/diagnostics.hpp"
#include "solver/supplied_energy.hpp"
#include "trevi/solver.hpp"

namespace trevi {

/// The parts of a solver that are reported on; they outlive the reporter.
template <class T>
struct ReportedState {
  MPI_Comm comm;
  const Clock& clock;
  const Particles& particles;
  const Neighbourhood<T>& near;
  DensityProblem<T>& problem;
  const std::vector<std::unique_ptr<Forcing>>& forcings;
  const FlowState* flow;  ///< null without inlets and drains
  std::array<LocalId, 3> first_cell;
  Real crush_limit;                              ///< DensitySettings::crush_limit
  const PressureProbes* probes = nullptr;        ///< null without gauges of pressure in the water
  const ActiveAbsorption* absorption = nullptr;  ///< null without paddles that absorb
};

template <class T>
class Reporter {
 public:
  Reporter(const ReportedState<T>& state, std::vector<std::unique_ptr<Observer>> observers,
           const DiagnosticsSum& diagnostics, const SuppliedEnergy& supplied);

  void begin_step();
  /// Which observers are due after that step, and what they want of it. Throws what they, and forcings that are asked
  /// for their state, throw: to be called before all ranks agree on failures. Once before observe().
  void ask_observers(std::int64_t step);
  /// To be called after the neighbour search and after the density solve of a substep: the drift is how far p* moves
  /// between.
  void note_search(int substep);
  void note_solution(const SolveResult& result);
  /// The forces of the step that has just been made are added to those since the last row of each observer.
  void add_forces();
  /// Of a restart; each observer goes on with what it wants of them.
  void set_force_sums(const ForceSums& sums);
  /// Does the work; what it changes of the energy of the water counts as supplied, where an observer wants to know.
  /// `ago`: see SuppliedEnergy::measure().
  void measure_supply(const std::function<void()>& work, Real ago = 0);
  /// The work of this rank's water that comes in, against the pressure there, in SuppliedEnergy::unit.
  void note_work_of_inflow(std::int64_t units) {
    if (watches_energy()) supplied_.add_measured(units);
  }
  /// What the step has been supplied with is added to what was before: what bodies have less of, too.
  void add_supply();
  /// The mean compression of the water at the end of a substep of a step, from 1; 0: at the start.
  void note_compression(Real mean, std::int64_t step);
  void count_migrated(GlobalId particles) { counters_.migrated += particles; }

  /// Calls the observers that are due, while the particles are still in the cell order of the step. Density and
  /// diagnostics are computed only when one of them asks.
  void observe();
  void save();
  void finish();

  std::vector<FountainState> fountain_states(Real time) const;
  /// The counters of the parts that this class sees.
  Solver::Counters counters() const;
  /// Measures the time of the simulation itself, without output.
  Stopwatch& stopwatch() { return stopwatch_; }

 private:
  void attempt(const std::function<void()>& work);
  Frame frame();
  void add_forces(const std::vector<TotalImpulse>& impulses, Real per, ForceSums& sums) const;
  static void add_pressures(const std::vector<Real>& pressed, Real per, ForceSums& sums);
  void take_means(std::size_t observer);
  ForceSums sums_of_files() const;
  std::vector<Real> probe_pressures() const;
  bool watches_energy() const;
  void add_work(const std::vector<TotalImpulse>& impulses, Real per);
  RigidBodies* bodies() const;

  struct Asked {
    std::vector<bool> due;  // of each observer
    bool diagnostics = false, density = false, pressures = false;
  };

  ReportedState<T> state_;
  std::vector<std::unique_ptr<Observer>> observers_;
  Asked asked_;
  DiagnosticsSum diagnostics_;
  SuppliedEnergy supplied_;
  bool is_supplied_ = false;  // something of this step was measured
  DriftMeter drift_;
  Solver::Counters counters_;
  Stopwatch stopwatch_;
  std::int64_t iterations_before_step_ = 0;
  std::vector<FountainState> fountain_states_;  // the frames given to observers point to it
  std::vector<ForceSums> sums_, means_;         // of each observer: since its last row, and of the row that is due
  ForceSums sums_of_files_;
  std::vector<Real> offsets_;  // of obstacles (Body::paddle_offset()) at the start of the step
  std::vector<Real> probed_;
  std::vector<BodyState> body_states_;  // as those of fountains
  Real bodies_had_ = 0;                 // J, at the start of the step
  Event diagnostics_event_{"Diagnostics"};
};

extern template class Reporter<float>;
extern template class Reporter<double>;

}  // namespace trevi
