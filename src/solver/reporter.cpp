#include "solver/reporter.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <exception>
#include <string>
#include <utility>

#include "parallel/collective.hpp"
#include "trevi/error.hpp"

namespace trevi {

template <class T>
Reporter<T>::Reporter(const ReportedState<T>& state, std::vector<std::unique_ptr<Observer>> observers,
                      const DiagnosticsSum& diagnostics, const SuppliedEnergy& supplied)
    : state_(state),
      observers_(std::move(observers)),
      diagnostics_(diagnostics),
      supplied_(supplied),
      sums_(observers_.size()),
      means_(observers_.size()) {}

template <class T>
void Reporter<T>::set_force_sums(const ForceSums& sums) {
  for (std::size_t k = 0; k < observers_.size(); ++k) {
    if (observers_[k]->wants_forces()) {
      sums_[k].steps = sums.steps;
      sums_[k].forces = sums.forces;
    }
    if (observers_[k]->wants_pressures()) {
      sums_[k].pressure_steps = sums.pressure_steps;
      sums_[k].pressures = sums.pressures;
    }
  }
}

// The sums that a checkpoint keeps: those of the first observer that wants them, because the observers that write files
// come first, and the sums of bodies.csv are those of obstacles.csv.
template <class T>
ForceSums Reporter<T>::sums_of_files() const {
  ForceSums sums;
  const auto first = [&](const auto& wants) {
    return static_cast<std::size_t>(std::find_if(observers_.begin(), observers_.end(), wants) - observers_.begin());
  };
  const std::size_t forces = first([](const auto& one) { return one->wants_forces(); });
  const std::size_t pressures = first([](const auto& one) { return one->wants_pressures(); });
  if (forces < observers_.size()) {
    sums.steps = sums_[forces].steps;
    sums.forces = sums_[forces].forces;
  }
  if (pressures < observers_.size()) {
    sums.pressure_steps = sums_[pressures].pressure_steps;
    sums.pressures = sums_[pressures].pressures;
  }
  return sums;
}

template <class T>
RigidBodies* Reporter<T>::bodies() const {
  Obstacles* const solids = state_.problem.obstacles();
  return solids != nullptr ? solids->floating() : nullptr;
}

template <class T>
void Reporter<T>::begin_step() {
  iterations_before_step_ = counters_.iterations;
  if (const RigidBodies* const floating = bodies()) bodies_had_ = floating->energy();
  offsets_.clear();
  const Obstacles* const obstacles = state_.problem.obstacles();
  for (std::size_t k = 0; obstacles != nullptr && k < obstacles->count(); ++k)
    offsets_.push_back(obstacles->body(k).paddle_offset());
}

template <class T>
void Reporter<T>::ask_observers(std::int64_t step) {
  Clock clock = state_.clock;
  clock.step = step;
  asked_ = {};
  for (const auto& observer : observers_) {
    const bool due = observer->due(clock);
    asked_.due.push_back(due);
    asked_.diagnostics = asked_.diagnostics || (due && observer->wants_diagnostics());
    asked_.density = asked_.density || (due && observer->wants_density());
    asked_.pressures = asked_.pressures || (due && observer->wants_pressures());
  }
  fountain_states_ = fountain_states(clock.time());
}

template <class T>
void Reporter<T>::note_search(int substep) {
  const bool last = substep + 1 == state_.clock.substeps;
  if (last && asked_.diagnostics) drift_.begin(state_.near.scratch(), state_.particles.predicted);
}

template <class T>
void Reporter<T>::note_solution(const SolveResult& result) {
  drift_.end(state_.particles.predicted);
  counters_.iterations += result.iterations;
  counters_.unconverged += result.converged ? 0 : 1;
  ++counters_.substeps;
}

template <class T>
void Reporter<T>::note_compression(Real mean, std::int64_t step) {
  Solver::Counters::Compression& seen = counters_.compression;
  seen.largest = std::max(seen.largest, mean);
  if (mean > state_.crush_limit && seen.first_crushed < 0) seen.first_crushed = step;
}

template <class T>
void Reporter<T>::observe() {
  if (asked_.pressures) probed_ = probe_pressures();
  for (std::size_t k = 0; k < observers_.size(); ++k)
    if (asked_.due[k]) take_means(k);
  Frame seen = frame();
  if (asked_.diagnostics || asked_.density) {
    state_.problem.compute_density();
    seen.density = state_.problem.density();
  }
  Diagnostics row;
  if (asked_.diagnostics) {
    const ScopedEvent timed(diagnostics_event_);
    row = diagnostics_({seen.particles, seen.density, drift_.largest(), state_.near.order(), state_.near.list()});
    row.iterations = counters_.iterations - iterations_before_step_;
    row.wall_seconds = stopwatch_.seconds();
    seen.diagnostics = &row;
  }
  for (std::size_t k = 0; k < observers_.size(); ++k) {
    if (!asked_.due[k]) continue;
    seen.forces = means_[k].forces;
    seen.pressures = means_[k].pressures;
    seen.probes = observers_[k]->wants_pressures() ? std::span<const Real>(probed_) : std::span<const Real>();
    attempt([&] { observers_[k]->observe(seen); });
  }
}

// Our own observers throw on all ranks alike, or cannot communicate any more; those of a caller may throw on one rank
// alone.
template <class T>
void Reporter<T>::attempt(const std::function<void()>& work) {
  std::exception_ptr own;
  std::string failure;
  try {
    work();
  } catch (const Error& error) {
    if (error.reach() == Reach::one_rank) throw;
    own = std::current_exception();
    failure = error.what();
  } catch (const std::exception& error) {
    failure = std::string("an observer failed: ") + error.what();
  } catch (...) {
    failure = "an observer failed";
  }
  const std::string first = first_text(state_.comm, failure);
  if (own) std::rethrow_exception(own);
  if (!first.empty()) throw RunError(first, Reach::all_ranks);
}

template <class T>
Frame Reporter<T>::frame() {
  if (const RigidBodies* const floating = bodies()) body_states_ = floating->states();
  sums_of_files_ = sums_of_files();
  return {state_.clock,
          state_.particles,
          {},
          nullptr,
          fountain_states_,
          state_.flow,
          {},
          {},
          state_.first_cell,
          state_.problem.obstacles() != nullptr ? &sums_of_files_ : nullptr,
          supplied_.joules(),
          state_.absorption != nullptr ? std::span<const Real>(state_.absorption->state()) : std::span<const Real>(),
          {},
          body_states_};
}

// A displacement d in a substep is a change of momentum of m d/dt.
template <class T>
void Reporter<T>::add_forces() {
  const Obstacles* const obstacles = state_.problem.obstacles();
  const auto wants = [](const auto& observer) { return observer->wants_forces() || observer->wants_pressures(); };
  if (obstacles == nullptr || std::none_of(observers_.begin(), observers_.end(), wants)) return;
  const Clock& clock = state_.clock;
  const Real per = obstacles->water_mass() * clock.substeps / (clock.dt * clock.dt);
  const Real per_pressure = state_.problem.model().rest_density * clock.substeps / (clock.dt * clock.dt);
  const std::vector<TotalImpulse> impulses = state_.problem.taken();
  const std::vector<Real> pressed = state_.problem.pressed();
  for (std::size_t n = 0; n < observers_.size(); ++n) {
    if (observers_[n]->wants_forces()) add_forces(impulses, per, sums_[n]);
    if (observers_[n]->wants_pressures()) add_pressures(pressed, per_pressure, sums_[n]);
  }
  if (obstacles->moves()) add_work(impulses, per);
}

template <class T>
void Reporter<T>::add_forces(const std::vector<TotalImpulse>& impulses, Real per, ForceSums& sums) const {
  const Obstacles& obstacles = *state_.problem.obstacles();
  sums.forces.resize(impulses.size());
  for (std::size_t k = 0; k < impulses.size(); ++k) {
    sums.forces[k].force -= per * impulses[k].shift;
    Vec3 moment = impulses[k].moment;
    if (k < obstacles.count()) moment += obstacles.lever(k).cross(impulses[k].shift);
    sums.forces[k].torque -= per * moment;
  }
  ++sums.steps;
}

template <class T>
void Reporter<T>::add_pressures(const std::vector<Real>& pressed, Real per, ForceSums& sums) {
  sums.pressures.resize(pressed.size());
  for (std::size_t k = 0; k < pressed.size(); ++k) sums.pressures[k] += per * pressed[k];
  ++sums.pressure_steps;
}

// The work that obstacles do by their motion in the step: force times shift of the pivot, plus torque about it times
// rotation.
template <class T>
void Reporter<T>::add_work(const std::vector<TotalImpulse>& impulses, Real per) {
  const Obstacles& obstacles = *state_.problem.obstacles();
  const Real end = state_.clock.time(), begin = end - state_.clock.dt;
  const RigidBodies* const floating = obstacles.floating();
  for (std::size_t k = 0; k < (floating != nullptr ? floating->first() : obstacles.count()); ++k) {
    const Body& body = obstacles.body(k);
    if (!body.moves()) continue;
    const Pose from = body.motion().at(begin, offsets_[k]), to = body.motion().at(end, body.paddle_offset());
    const Eigen::AngleAxisd rotation(to.turn * from.turn.transpose());
    const Vec3 pivot = body.midway().into_body(body.pivot()), shift = to.into_world(pivot) - from.into_world(pivot);
    supplied_.add(per * (impulses[k].shift.dot(shift) + impulses[k].moment.dot(rotation.angle() * rotation.axis())));
  }
}

template <class T>
bool Reporter<T>::watches_energy() const {
  return std::any_of(observers_.begin(), observers_.end(), [](const auto& one) { return one->wants_diagnostics(); });
}

template <class T>
void Reporter<T>::measure_supply(const std::function<void()>& work, Real ago) {
  if (!watches_energy()) return work();
  supplied_.measure(state_.particles, work, ago);
  is_supplied_ = true;
}

template <class T>
void Reporter<T>::add_supply() {
  if (std::exchange(is_supplied_, false)) supplied_.end_step();
  if (RigidBodies* const floating = bodies())
    supplied_.add(bodies_had_ - floating->energy() + floating->take_driven_work());
}

// Forces and pressures are each averaged over the steps since this observer was last due.
template <class T>
void Reporter<T>::take_means(std::size_t observer) {
  const Obstacles* const obstacles = state_.problem.obstacles();
  const auto per = [](std::int64_t& steps) {
    return static_cast<Real>(std::max<std::int64_t>(std::exchange(steps, 0), 1));
  };
  ForceSums &sums = sums_[observer], &means = means_[observer];
  means = {};
  if (observers_[observer]->wants_forces()) {
    require(obstacles != nullptr, "forces without obstacles");
    sums.forces.resize(obstacles->count() + 1);
    means.forces = std::exchange(sums.forces, {});
    const Real steps = per(sums.steps);
    for (BodyForce& one : means.forces) one = {one.force / steps, one.torque / steps};
  }
  if (obstacles == nullptr || !observers_[observer]->wants_pressures()) return;
  sums.pressures.resize(state_.problem.gauges());
  means.pressures = std::exchange(sums.pressures, {});
  const Real steps = per(sums.pressure_steps);
  for (Real& one : means.pressures) one /= steps;
}

// phi is the pressure divided by the density, times the square of the length of the substep.
template <class T>
std::vector<Real> Reporter<T>::probe_pressures() const {
  if (state_.probes == nullptr) return {};
  const Real dt = state_.clock.dt / state_.clock.substeps;
  std::vector<Real> pressures = state_.probes->means(state_.comm);
  for (Real& one : pressures) one *= state_.problem.model().rest_density / (dt * dt);
  return pressures;
}

template <class T>
void Reporter<T>::save() {
  for (const auto& observer : observers_) attempt([&] { observer->save(frame()); });
}

template <class T>
void Reporter<T>::finish() {
  for (const auto& observer : observers_) attempt([&] { observer->finish(frame()); });
}

template <class T>
std::vector<FountainState> Reporter<T>::fountain_states(Real time) const {
  std::vector<FountainState> states;
  for (const auto& forcing : state_.forcings) {
    if (const auto state = forcing->state(time)) states.push_back(*state);
  }
  return states;
}

template <class T>
Solver::Counters Reporter<T>::counters() const {
  Solver::Counters counters = counters_;
  counters.pair_passes = state_.problem.pair_passes();
  counters.halo_bytes = state_.near.halo().bytes();
  counters.halo_messages = state_.near.halo().messages();
  counters.seconds = stopwatch_.seconds();
  counters.waiting_seconds = stopwatch_.total().waiting;
  counters.reduction_seconds = stopwatch_.total().reductions;
  counters.bytes = state_.near.bytes();
  if (const Obstacles* const obstacles = state_.problem.obstacles()) counters.bytes += obstacles->bytes();
  state_.particles.for_each_field([&](const auto& field) { counters.bytes += field.capacity() * sizeof(field[0]); });
  return counters;
}

template class Reporter<float>;
template class Reporter<double>;

}  // namespace trevi
