#include "solver/pbf_solver.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <exception>

#include "base/threads.hpp"
#include "domain/migrate.hpp"
#include "parallel/collective.hpp"
#include "trevi/error.hpp"

namespace trevi {

// MPI_Comm_free is collective: while an error propagates on this rank alone, the other ranks would not call it.
OwnCommunicator::~OwnCommunicator() {
  if (std::uncaught_exceptions() == 0) MPI_Comm_free(&comm_);
}

template <class T>
PbfSolver<T>::PbfSolver(SolverParts<T> parts)
    : parts_(std::move(parts)),
      guard_(*parts_.comm, parts_.particles, std::move(parts_.requests)),
      near_(*parts_.comm, *parts_.grid, parts_.box.min, parts_.constraint->model().h, parts_.scratch),
      problem_(*parts_.comm, near_, *parts_.constraint, *parts_.boundary,
               parts_.density_solver->sets_velocities() ? parts_.gravity : Vec3::Zero()),
      reporter_({*parts_.comm, parts_.clock, parts_.particles, near_, problem_, parts_.forcings, flow(),
                 parts_.first_cell, parts_.crush_limit, parts_.probes.get(), parts_.absorption.get()},
                std::move(parts_.observers), *parts_.diagnostics,
                {*parts_.comm, parts_.water_mass, parts_.gravity, parts_.corner, parts_.supplied_energy}) {
  reporter_.set_force_sums(parts_.force_sums);
}

template <class T>
void PbfSolver<T>::save() {
  const ThreadLimit limit(threads_);
  reporter_.save();
}

template <class T>
void PbfSolver<T>::finish() {
  const ThreadLimit limit(threads_);
  reporter_.finish();
}

template <class T>
void PbfSolver<T>::start() {
  const ThreadLimit limit(threads_);
  const Boundary& boundary = *parts_.boundary;
  boundary.wrap_positions(parts_.particles);
  parts_.particles.predicted = parts_.particles.position;
  boundary.wrap_predicted(parts_.particles);
  arrange_particles(Velocities::preserve);
  find_neighbours();
  boundary.wrap_positions(parts_.particles);
  problem_.start(parts_.particles, parts_.clock.dt);
  problem_.prepare();
  problem_.look_at_density();
  guard_.note_compression(problem_.density(), problem_.model().rest_density);
  ask_observers(0);
  guard_.agree(parts_.particles, 0);
  reporter_.note_compression(guard_.compression(), 0);
  reporter_.observe();
}

template <class T>
void PbfSolver<T>::step() {
  const ThreadLimit limit(threads_);
  Clock& clock = parts_.clock;
  {
    const Stopwatch::Lap lap(reporter_.stopwatch());
    reporter_.begin_step();
    prepare_step();
    ask_observers(clock.step + 1);
    clock.substeps = parts_.substep_rule.substeps(*parts_.comm, clock, parts_.particles, push());
    const Real dt = clock.dt / clock.substeps;
    for (int k = 0; k < clock.substeps; ++k) {
      if (k > 0) migrate_particles(&Particles::position);
      substep({clock.step, k, clock.time() + k * dt, dt});
    }
    ++clock.step;
    reporter_.add_forces();
    reporter_.add_supply();
  }
  reporter_.observe();
  const Stopwatch::Lap lap(reporter_.stopwatch());
  parts_.balance->update(clock.step, near_.order(), near_.list(), *parts_.slabs);
  migrate_particles(&Particles::position);
}

// Algorithm 1 of Macklin & Müller 2013, with its line numbers, for one of the equal parts of a step.
template <class T>
void PbfSolver<T>::substep(const StepInfo& info) {
  exchange_water(info);  //     what drains take and inlets bring
  apply_forcings(info);  //  2
  if (parts_.absorption) parts_.absorption->move(*parts_.comm, parts_.particles, info, *parts_.boundary->obstacles());
  parts_.boundary->move(info.time, info.time + info.dt);
  parts_.boundary->settle_bodies(*parts_.comm, parts_.particles, info.dt);
  predict_positions(info.dt);  //  3
  parts_.boundary->give_to_bodies(*parts_.comm);
  migrate_particles(&Particles::predicted);  //     ownership follows p*
  arrange_particles(Velocities::discard);    //     order and ghosts, unchanged until 22
  problem_.start(parts_.particles, info.dt, held(info));
  parts_.density_solver->begin(problem_);
  find_neighbours();  //  5 to 7: lists, unchanged until 22, of p* as predicted
  problem_.prepare();
  reporter_.note_search(info.substep);
  const SolveResult result = parts_.density_solver->solve(problem_);  //  8 to 19
  reporter_.note_solution(result);
  if (parts_.flow) reporter_.note_work_of_inflow(parts_.flow->openings()->take_work());
  if (!parts_.density_solver->sets_velocities()) update_velocities(info.dt);  // 21
  apply_velocity_filters(info.dt);                                            // 22
  parts_.boundary->finish_bodies(*parts_.comm);
  guard_.note_compression(problem_.density(), problem_.model().rest_density);
  agree_on_failures();  //     all ranks throw, or none
  reporter_.note_compression(guard_.compression(), info.step + 1);
  guard_.end_if_crushed(info.step + 1);
  accept_positions();  // 23
}

template <class T>
void PbfSolver<T>::prepare_step() {
  const Clock& clock = parts_.clock;
  parts_.boundary->begin_step();
  if (parts_.probes) parts_.probes->clear();
  for (const auto& forcing : parts_.forcings) {
    guard_.attempt(clock.step + 1, "a forcing", [&] { forcing->prepare({clock.step, 0, clock.time(), clock.dt}); });
  }
}

template <class T>
void PbfSolver<T>::ask_observers(std::int64_t step) {
  guard_.attempt(step, "an observer", [&] { reporter_.ask_observers(step); });
}

// What forcings and moving obstacles will do to the water in the step that now begins.
template <class T>
SubstepRule::Push PbfSolver<T>::push() {
  Clock next = parts_.clock;
  ++next.step;
  const TimeSpan span{parts_.clock.time(), next.time()};
  const Boundary& boundary = *parts_.boundary;
  SubstepRule::Push push{boundary.fastest(span.begin, span.end),
                         boundary.acceleration(span.begin, span.end, parts_.substep_rule.h)};
  for (const auto& forcing : parts_.forcings) {
    guard_.attempt(next.step, "a forcing", [&] { push.speed = std::max(push.speed, forcing->fastest(span)); });
  }
  return push;
}

template <class T>
void PbfSolver<T>::exchange_water(const StepInfo& info) {
  if (!parts_.flow) return;
  reporter_.measure_supply(
      [&] { guard_.expect(parts_.flow->exchange(parts_.particles, info, *parts_.grid, *parts_.slabs)); });
}

template <class T>
void PbfSolver<T>::apply_forcings(const StepInfo& info) {
  const auto& forcings = parts_.forcings;
  for (std::size_t k = 0; k < parts_.first_own_forcing; ++k) apply_forcing(*forcings[k], info);
  if (parts_.first_own_forcing == forcings.size()) return;
  const auto apply = [&] {
    for (std::size_t k = parts_.first_own_forcing; k < forcings.size(); ++k) apply_forcing(*forcings[k], info);
  };
  reporter_.measure_supply(apply, info.dt / 2);  // what holds water on its path acts against gravity all the time
  const Particles& particles = parts_.particles;
  const LocalId lost = first_index(
      {0, particles.size()}, [&](std::size_t i) { return !parts_.boundary->walls().inside(particles.position[i]); });
  if (lost < particles.size()) {
    const auto i = static_cast<std::size_t>(lost);
    parts_.particles.predicted[i] = particles.position[i];
    guard_.note_particle(particles, i, info.step + 1);
  }
}

// The time in the substep, s, for which a pump, or a forcing of the caller, determines the motion. Of several the last
// one counts.
template <class T>
std::function<Real(std::size_t)> PbfSolver<T>::held(const StepInfo& info) const {
  if (parts_.first_own_forcing == parts_.forcings.size()) return {};
  return [this, info](std::size_t i) {
    const Particles& particles = parts_.particles;
    Real held = 0;
    for (std::size_t k = parts_.forcings.size(); held == 0 && k > parts_.first_own_forcing; --k)
      held = parts_.forcings[k - 1]->holds_for(particles.id[i], particles.position[i], info);
    return held;
  };
}

template <class T>
void PbfSolver<T>::apply_forcing(Forcing& forcing, const StepInfo& info) {
  Particles& particles = parts_.particles;
  guard_.attempt(info.step + 1, "a forcing", [&] {
    forcing.apply(particles, info);
    particles.for_each_field([&](const auto& field) {
      require(field.size() == particles.id.size(), "it left fields of different lengths");
    });
  });
  particles.resize(particles.id.size());
}

// Tested here, because the next collision would move an infinite p* onto a wall, where it would look valid.
template <class T>
void PbfSolver<T>::predict_positions(Real dt) {
  const ScopedEvent timed(predict_event_);
  Particles& particles = parts_.particles;
  Boundary& boundary = *parts_.boundary;
  boundary.round_positions(particles);  // new particles may lie between the multiples of the quantum
  const LocalId lost = boundary.predict(particles, dt);
  if (lost < particles.size()) guard_.note_particle(particles, static_cast<std::size_t>(lost), parts_.clock.step + 1);
  boundary.wrap_predicted(particles);
}

template <class T>
void PbfSolver<T>::migrate_particles(std::vector<Vec3> Particles::*position) {
  const ScopedEvent timed(migrate_event_);
  reporter_.count_migrated(migrate(*parts_.comm, parts_.particles, position, *parts_.grid, *parts_.slabs));
}

template <class T>
void PbfSolver<T>::arrange_particles(Velocities velocities) {
  problem_.give_back();
  near_.arrange(parts_.particles, *parts_.slabs, velocities);
}

template <class T>
void PbfSolver<T>::find_neighbours() {
  near_.search();
  if (const LocalId i = near_.list().first_overfull_particle();
      i >= 0) {  // on this rank alone: thrown when all ranks agree on failures
    guard_.note(
        parts_.clock.step + 1,
        fmt::format("particle {} has more than {} neighbours: the water has collapsed into a point; use a smaller dt, "
                    "time.cfl, or under-relaxation",
                    parts_.particles.id[static_cast<std::size_t>(i)], NeighbourList::max_neighbours));
  }
}

template <class T>
void PbfSolver<T>::update_velocities(Real dt) {
  const ScopedEvent timed(update_event_);
  Particles& particles = parts_.particles;
  for_each_index({0, particles.size()},
                 [&](std::size_t i) { particles.velocity[i] = (particles.predicted[i] - particles.position[i]) / dt; });
}

template <class T>
void PbfSolver<T>::apply_velocity_filters(Real dt) {
  for (const auto& filter : parts_.filters) filter->apply(near_, parts_.particles, dt);
}

template <class T>
void PbfSolver<T>::agree_on_failures() {
  const std::int64_t step = parts_.clock.step + 1;
  guard_.check(parts_.particles, parts_.boundary->walls(), step);
  guard_.check(bodies(), step);
  guard_.agree(parts_.particles, step);
}

template <class T>
void PbfSolver<T>::accept_positions() {
  Particles& particles = parts_.particles;
  for_each_index({0, particles.size()}, [&](std::size_t i) { particles.position[i] = particles.predicted[i]; });
  parts_.boundary->wrap_positions(particles);
}

template <class T>
void PbfSolver<T>::change_particles(const std::function<void(Particles&)>& change) {
  const ThreadLimit limit(threads_);
  Particles& particles = parts_.particles;
  all_or_none(*parts_.comm, [&] {
    change(particles);
    particles.predicted = particles.position;
    particles.for_each_field([&](const auto& field) {
      require(field.size() == particles.id.size(), "after change_particles() the fields have different lengths");
    });
  });
  guard_.recount(particles);
  guard_.note_compression({}, 1);  // not known before the next solve
  if (parts_.flow) parts_.flow->begin(*parts_.comm, *parts_.boundary, particles);
  agree_on_failures();
  migrate_particles(&Particles::position);
}

template <class T>
Solver::Counters PbfSolver<T>::counters() const {
  Counters counters = reporter_.counters();
  const Balance::History& balance = parts_.balance->history();
  counters.balance = {balance.looks, balance.moves, balance.sum, balance.max};
  counters.bytes += parts_.density_solver->bytes();
  return counters;
}

template class PbfSolver<float>;
template class PbfSolver<double>;

}  // namespace trevi
