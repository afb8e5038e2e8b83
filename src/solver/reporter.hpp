// The reports of a solver besides the step: rows and frames for the observers, the largest motion of a particle since
// the neighbour list was built (drift), and counters of work. It never changes the state of the solver, except for the
// density, which it computes again if an observer wants it. Collective: observe, save, finish.
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

/// The parts of a solver that are reported on; they must outlive the reporter.
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
  const ActiveAbsorption* absorption = nullptr;  ///< null without absorbing paddles
};

template <class T>
class Reporter {
 public:
  Reporter(const ReportedState<T>& state, std::vector<std::unique_ptr<Observer>> observers,
           const DiagnosticsSum& diagnostics, const SuppliedEnergy& supplied);

  void begin_step();
  /// Finds which observers are due after this step, and what they want of it. Throws what they throw, and what forcings
  /// throw that are asked for their state; to be called before all ranks agree on failures, once before observe().
  void ask_observers(std::int64_t step);
  /// To be called after the neighbour search and after the density solve of a substep. The drift is the distance by
  /// which p* moves in between.
  void note_search(int substep);
  void note_solution(const SolveResult& result);
  /// Adds the forces of the step just completed to those since the last row of each observer.
  void add_forces();
  /// Sets the sums of a restart; each observer continues with those that it wants.
  void set_force_sums(const ForceSums& sums);
  /// Calls `work`. The change of the energy of the water by it counts as supplied if an observer wants to know. `ago`:
  /// see SuppliedEnergy::measure().
  void measure_supply(const std::function<void()>& work, Real ago = 0);
  /// Adds the work of this rank's inflow against the pressure there, in SuppliedEnergy::unit.
  void note_work_of_inflow(std::int64_t units) {
    if (watches_energy()) supplied_.add_measured(units);
  }
  /// Adds the energy supplied in this step to that of previous steps, including the energy that bodies have lost.
  void add_supply();
  /// Notes the mean compression of the water at the end of a substep of this step, counted from 1; 0: at the start.
  void note_compression(Real mean, std::int64_t step);
  void count_migrated(GlobalId particles) { counters_.migrated += particles; }

  /// Calls the observers that are due, while the particles are still in the cell order of the step. Density and
  /// diagnostics are computed only if one of them wants them.
  void observe();
  void save();
  void finish();

  std::vector<FountainState> fountain_states(Real time) const;
  /// The counters of the parts that this class knows.
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
  bool is_supplied_ = false;  // whether anything was measured in this step
  DriftMeter drift_;
  Solver::Counters counters_;
  Stopwatch stopwatch_;
  std::int64_t iterations_before_step_ = 0;
  std::vector<FountainState> fountain_states_;  // the frames given to observers point to it
  std::vector<ForceSums> sums_, means_;         // for each observer: since its last row, and of the row that is due
  ForceSums sums_of_files_;
  std::vector<Real> offsets_;  // of obstacles (Body::paddle_offset()) at the start of the step
  std::vector<Real> probed_;
  std::vector<BodyState> body_states_;  // like fountain_states_
  Real bodies_had_ = 0;                 // energy of the bodies at the start of the step, J
  Event diagnostics_event_{"Diagnostics"};
};

extern template class Reporter<float>;
extern template class Reporter<double>;

}  // namespace trevi
