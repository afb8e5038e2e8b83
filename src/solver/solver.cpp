#include "trevi/solver.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "parallel/reductions.hpp"
#include "trevi/error.hpp"
#include "trevi/session.hpp"

namespace trevi {

template <class T>
PbfSolver<T>::PbfSolver(SolverParts<T> parts)
    : parts_(std::move(parts)),
      guard_(parts_.comm, parts_.particles, std::move(parts_.requests)),
      near_(parts_.comm, *parts_.grid, parts_.box.min, parts_.constraint->model().h),
      problem_(parts_.comm, near_, *parts_.constraint, *parts_.walls) {}

template <class T>
void PbfSolver<T>::start() {
  Particles& particles = parts_.particles;
  particles.predicted = particles.position;
  last_substep_ = false;
  // Sorting costs the velocities, which nothing has used up yet: they take the place of the positions meanwhile.
  std::swap(particles.position, particles.velocity);
  find_neighbours(parts_.clock.dt);
  std::swap(particles.position, particles.velocity);
  particles.position = particles.predicted;
  guard_.agree(particles, 0);
  observe();
}

template <class T>
void PbfSolver<T>::step() {
  Clock& clock = parts_.clock;
  {
    const Stopwatch::Lap lap(stopwatch_);
    iterations_before_step_ = counters_.iterations;
    for (const auto& forcing : parts_.forcings) forcing->prepare({clock.step, 0, clock.time(), clock.dt});
    clock.substeps = choose_substeps();
    const Real dt = clock.dt / clock.substeps;
    for (int k = 0; k < clock.substeps; ++k) {
      if (k > 0) follow(&Particles::position);
      last_substep_ = k + 1 == clock.substeps;
      advance({clock.step, k, clock.time() + k * dt, dt});
    }
    ++clock.step;
  }
  observe();
  const Stopwatch::Lap lap(stopwatch_);
  parts_.balance->update(clock.step, near_.order(), near_.list(), *parts_.slabs);
  follow(&Particles::position);
}

// The body of Algorithm 1.
template <class T>
void PbfSolver<T>::advance(const StepInfo& info) {
  for (const auto& forcing : parts_.forcings) forcing->apply(parts_.particles, info);
  predict(info.dt);
  follow(&Particles::predicted);
  find_neighbours(info.dt);
  last_solve_ = parts_.method->solve(problem_);
  update_velocities(info.dt);
  for (const auto& filter : parts_.filters) filter->apply(near_, parts_.particles, info.dt);
  guard_.check(parts_.particles, *parts_.walls, info.step + 1);
  guard_.agree(parts_.particles, info.step + 1);
  parts_.particles.position = parts_.particles.predicted;
  count_work();
}

template <class T>
void PbfSolver<T>::predict(Real dt) {
  const ScopedEvent timed(predict_event_);
  Particles& particles = parts_.particles;
  for (std::size_t i = 0; i < particles.id.size(); ++i) {
    particles.predicted[i] = parts_.walls->predict(particles.position[i], particles.velocity[i], dt);
    // Here, as an infinite p* would be moved to a wall by the next collision and look sound again.
    if (!parts_.walls->inside(particles.predicted[i])) guard_.note_particle(particles, i, parts_.clock.step + 1);
  }
}

template <class T>
void PbfSolver<T>::follow(std::vector<Vec3> Particles::*place) {
  const ScopedEvent timed(migrate_event_);
  counters_.migrated += migrate(parts_.comm, parts_.particles, place, *parts_.grid, *parts_.slabs);
}

template <class T>
void PbfSolver<T>::find_neighbours(Real dt) {
  const int rank = rank_of(parts_.comm);
  near_.rebuild(parts_.particles, parts_.slabs->first_plane(rank), parts_.slabs->last_plane(rank));
  if (const LocalId i = near_.list().crowded(); i >= 0) {  // on this rank alone: told when all agree
    guard_.note(
        parts_.clock.step + 1,
        fmt::format("particle {} has more than {} neighbours: the water has collapsed into a point; use a smaller dt, "
                    "time.cfl, or under-relaxation",
                    parts_.particles.id[static_cast<std::size_t>(i)], NeighbourList::most_neighbours));
  }
  problem_.start(parts_.particles, dt);
  measure_drift_ = last_substep_ && wanted(&Observer::wants_diagnostics, parts_.clock.step + 1);
  if (measure_drift_) parts_.particles.velocity = parts_.particles.predicted;  // until the update, free to be used
}

template <class T>
void PbfSolver<T>::update_velocities(Real dt) {
  const ScopedEvent timed(update_event_);
  Particles& particles = parts_.particles;
  drift_ = 0;
  for (std::size_t i = 0; i < particles.id.size(); ++i) {
    if (measure_drift_) drift_ = std::max(drift_, (particles.predicted[i] - particles.velocity[i]).norm());
    particles.velocity[i] = (particles.predicted[i] - particles.position[i]) / dt;
  }
}

template <class T>
int PbfSolver<T>::choose_substeps() const {
  if (parts_.substeps.cfl <= 0) return 1;
  const Real dt = parts_.clock.dt, h = parts_.constraint->model().h, g = parts_.substeps.gravity.norm();
  Real v2 = 0;
  for (const Vec3& v : parts_.particles.velocity) v2 = std::max(v2, v.squaredNorm());
  Real v = std::sqrt(max_over_ranks(parts_.comm, v2));
  Clock next = parts_.clock;  // a pump that starts within the step counts
  ++next.step;
  for (const auto& forcing : parts_.forcings) v = std::max(v, forcing->fastest({parts_.clock.time(), next.time()}));
  const Real by_speed = dt * v / (parts_.substeps.cfl * h);
  const Real by_gravity = g > 0 ? dt / (0.25 * std::sqrt(h / g)) : 0;
  const Real parts = std::max({by_speed, by_gravity, dt / parts_.substeps.longest});
  if (!(parts < 1e6)) {  // the same numbers on all ranks
    throw BlowUp("step " + std::to_string(parts_.clock.step + 1) + ": " + std::to_string(v) +
                 " m/s would need more than a million substeps: the run has become unstable; use a smaller dt");
  }
  return std::max(1, static_cast<int>(std::ceil(parts * (1 - 1e-9))));
}

template <class T>
bool PbfSolver<T>::wanted(bool (Observer::*what)() const, std::int64_t step) const {
  Clock clock = parts_.clock;
  clock.step = step;
  return std::any_of(parts_.observers.begin(), parts_.observers.end(),
                     [&](const auto& observer) { return observer->due(clock) && (observer.get()->*what)(); });
}

// Observers see the particles in the order that sums were formed in; the sums are made only when one of them asks.
template <class T>
void PbfSolver<T>::observe() {
  const Clock& clock = parts_.clock;
  const bool diagnose = wanted(&Observer::wants_diagnostics, clock.step);
  std::span<const Real> density;  // else that of the last iteration, before its shift
  if (diagnose || wanted(&Observer::wants_density, clock.step)) {
    problem_.compute_density();
    density = problem_.density();
  }
  Diagnostics row;
  if (diagnose) {
    const ScopedEvent timed(diagnostics_event_);
    row = (*parts_.diagnostics)({parts_.particles, density, drift_, near_.order(), near_.list()});
    row.iterations = counters_.iterations - iterations_before_step_;
    row.wall_seconds = stopwatch_.seconds();
  }
  fountain_states_ = fountains();
  const Frame frame{clock, parts_.particles, density, diagnose ? &row : nullptr, fountain_states_};
  for (const auto& observer : parts_.observers) {
    if (observer->due(clock)) observer->observe(frame);
  }
}

template <class T>
Frame PbfSolver<T>::plain_frame() {
  fountain_states_ = fountains();
  return {parts_.clock, parts_.particles, {}, nullptr, fountain_states_};
}

template <class T>
void PbfSolver<T>::save() {
  for (const auto& observer : parts_.observers) observer->save(plain_frame());
}

template <class T>
void PbfSolver<T>::finish() {
  for (const auto& observer : parts_.observers) observer->finish(plain_frame());
}

template <class T>
std::vector<FountainState> PbfSolver<T>::fountains() const {
  std::vector<FountainState> states;
  for (const auto& forcing : parts_.forcings) {
    if (const auto state = forcing->state(parts_.clock.time())) states.push_back(*state);
  }
  return states;
}

template <class T>
void PbfSolver<T>::count_work() {
  counters_.iterations += last_solve_.iterations;
  counters_.unconverged += last_solve_.converged ? 0 : 1;
  ++counters_.substeps;
}

template <class T>
Solver::Counters PbfSolver<T>::counters() const {
  Counters counters = counters_;
  counters.pair_passes = problem_.pair_passes();
  counters.halo_bytes = near_.halo().bytes();
  counters.halo_messages = near_.halo().messages();
  counters.balance = parts_.balance->history();
  counters.seconds = stopwatch_.seconds();
  counters.bytes = near_.bytes() + problem_.bytes() + parts_.method->bytes();
  for (const auto& filter : parts_.filters) counters.bytes += filter->bytes();
  parts_.particles.for_each_field([&](const auto& field) { counters.bytes += field.capacity() * sizeof(field[0]); });
  return counters;
}

template class PbfSolver<float>;
template class PbfSolver<double>;

}  // namespace trevi
