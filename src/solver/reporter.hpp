// What a solver tells of itself beside the step: rows and frames for the observers, the largest drift on the frozen
// neighbour list, and counts of work. It reads the state of the solver and never changes it, but for the density, which
// it has summed anew where an observer asks. Collective: observe, save, finish.
#pragma once

#include <memory>
#include <vector>

#include "parallel/stopwatch.hpp"
#include "solver/density_solver.hpp"
#include "solver/diagnostics.hpp"
#include "trevi/solver.hpp"

namespace trevi {

/// The parts of a solver that are reported on; they outlive the reporter.
template <class T>
struct ReportedState {
  const Clock& clock;
  const Particles& particles;
  const Neighbourhood<T>& near;
  DensityProblem<T>& problem;
  const std::vector<std::unique_ptr<Forcing>>& forcings;
};

template <class T>
class Reporter {
 public:
  Reporter(const ReportedState<T>& state, std::vector<std::unique_ptr<Observer>> observers,
           const DiagnosticsSum& diagnostics);

  void begin_step() { iterations_before_step_ = counters_.iterations; }
  /// After the search and after the density solve of a substep: the drift is what p* moves in between.
  void note_search(int substep);
  void note_solution(const SolveResult& result);
  void count_migrated(GlobalId particles) { counters_.migrated += particles; }

  /// Observers see the particles in the order that sums were formed in; sums are made only when one of them asks.
  void observe();
  void save();
  void finish();

  std::vector<FountainState> fountains() const;
  /// Of the parts that this class sees.
  Solver::Counters counters() const;
  /// Time in its laps is that of the simulation proper.
  Stopwatch& stopwatch() { return stopwatch_; }

 private:
  bool wanted(bool (Observer::*what)() const, std::int64_t step) const;
  Frame frame();

  ReportedState<T> state_;
  std::vector<std::unique_ptr<Observer>> observers_;
  DiagnosticsSum diagnostics_;
  DriftMeter drift_;
  Solver::Counters counters_;
  Stopwatch stopwatch_;
  std::int64_t iterations_before_step_ = 0;
  std::vector<FountainState> fountain_states_;  // what the frames of observers point to
  Event diagnostics_event_{"Diagnostics"};
};

extern template class Reporter<float>;
extern template class Reporter<double>;

}  // namespace trevi
