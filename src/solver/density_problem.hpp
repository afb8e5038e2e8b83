// The density solve of a substep as the density solvers (density_solver.hpp) see it: they move the positions p* until
// C_i = 0, on a neighbour list that stays as it is, by the operations below. Line numbers are those of Algorithm 1 of
// Macklin & Müller 2013. An operation for a range changes the records of owned particles only; with_halo() brings the
// ghosts up to date, and sends the messages while interior planes are worked on. Collective: with_halo, compression,
// project, release_in_flight, filter_shifts.
//
// With a projection, velocities are what it makes of them, set_velocities(), and the sweeps after it shift positions
// only: a lattice that is sheared is denser by its kernel sums than one that is not, and a sweep that became velocity
// would resist. Where the grid does not act, in sheets, thin jets and spray, the sweeps are all there is: there their
// multipliers become velocity, too, each with its own fraction 1 − act_i, so that the two of a pair keep their
// momentum.
//
// Rows of cells in which a pass would find what is known, densities where nothing has moved and no shift where there is
// no multiplier, are left out of it (swept_rows.hpp).
#pragma once

#include <array>
#include <functional>

#include "base/threads.hpp"
#include "boundary/boundary.hpp"
#include "domain/neighbourhood.hpp"
#include "fluid/constraint/density.hpp"
#include "projection/projection.hpp"
#include "solver/free_flight.hpp"
#include "solver/swept_rows.hpp"

namespace trevi {

/// The part of an iteration that is timed under one event of the log.
enum class Phase : std::size_t { lambda, move };

/// Compression max(0, rho/rho0 − 1) over all particles of all ranks.
struct Compression {
  Real mean = 0, max = 0;
};

template <class T>
class DensityProblem {
 public:
  /// `gravity` in m/s², under which water flies; 0 where velocities are not the projection's.
  DensityProblem(MPI_Comm comm, Neighbourhood<T>& near, const DensityConstraint<T>& constraint, Boundary& boundary,
                 const Vec3& gravity);

  /// Starts a solve for the particles just sorted into `near`, which were predicted over the time dt, s. Their
  /// neighbours need not be known before prepare(), which project() precedes. `held`: for how long not gravity but
  /// something else decides how a particle moves, s; may be empty.
  void start(Particles& particles, Real dt, std::function<Real(std::size_t)> held = {});
  void prepare();
  /// Forgets densities and all else: to be called before particles are sorted anew.
  void give_back();

  /// Calls work(part) for the boundary, sends the scalars of their records, or with Phase::move their positions,
  /// calls work(interior) and receives those of the ghosts.
  template <class Work>
  void with_halo(Phase phase, Work&& work);

  /// rho_i and lambda_i of the owned particles of a range from the present p* (lines 9 to 11). The records, which
  /// neighbours read, get chosen(lambda_i, last), m², where last is what was chosen before in this solve, at first 0.
  template <class Chosen>
  void compute_lambda(Range part, const Chosen& chosen);
  /// Compression of all particles at the last compute_lambda() or compute_density(); the same bits on any rank count.
  Compression compression() const;
  /// delta_i, m, of all owned particles from the present lambda (lines 12 and 13).
  void compute_delta();
  /// The same and separate_coincident(), if that is asked for, and collide_and_move(): the boundary first, whose
  /// positions travel meanwhile. Collective.
  void compute_delta_and_move(bool separate);
  /// Sets delta from the projection instead: displacements that keep the volume over long distances. Velocities lose
  /// their values, as sorting does it.
  void project(Projection& projection);
  /// Velocities from the motion up to now; positions shift alone from here on. `looks_later`: whether densities are
  /// computed once more when the sweeps are done, as a tolerance asks for.
  void set_velocities(bool looks_later);
  /// Gives the water in flight the velocity that the sweeps have found for its pairs, and at walls.
  void release_in_flight();
  /// These particles are of pieces of water that touch nothing (free_flight.hpp). After prepare().
  void let_fly(std::span<const Range> parts) { free_flight_.let_fly(near_.all(), parts, near_.scratch()); }
  /// Where particle i ends if the pressure does not move it further. Between let_fly() and set_velocities().
  Vec3 end_of_flight(std::size_t i) const { return particles_->predicted[i] + free_flight_.lift_of(i); }
  /// Takes off the shifts since set_velocities() what moves the water as a whole, and lifts what flies to its path:
  /// places p* alone, neither records nor ghosts.
  void filter_shifts(Projection& projection);
  /// Adds small, opposite shifts to delta for coincident particles: their kernel gradient is zero and would never part
  /// them.
  void separate_coincident() { separate_coincident({}, false); }
  Vec3 delta(LocalId i) const { return field_.shift(static_cast<std::size_t>(i)); }
  /// p*_i += relaxation · delta_i as far as walls allow (lines 14 to 18).
  void collide_and_move(Range part, Real relaxation = 1);
  /// p*_i = position(i) for the range.
  template <class Position>
  void set_positions(Range part, Position&& position);

  /// rho_i of all owned particles at the present p*, without touching lambda.
  void compute_density();
  /// The same before the first step: no pass that is counted.
  void look_at_density();

  const CellOrder& order() const { return near_.order(); }
  /// Brings numbers of all particles, ghosts included, from those that own them. Collective.
  void exchange(Borrowed<std::int64_t>& numbers) { near_.exchange(numbers); }
  /// Memory of the substep.
  Scratch& scratch() const { return near_.scratch(); }
  /// All owned particles.
  Range all() const { return near_.all(); }
  /// Of the substep, s.
  Real dt() const { return dt_; }
  /// Null where there are none.
  Obstacles* obstacles() const { return boundary_.obstacles(); }
  /// What obstacles and the box took of the water in this step; only where there are obstacles. Collective.
  std::vector<TotalImpulse> taken() const { return boundary_.obstacles()->total(comm_); }
  /// What pressed on the gauges of pressure in this step, m² (PressureGauges); as taken().
  std::vector<Real> pressed() const { return boundary_.obstacles()->gauges().total(comm_); }
  std::size_t gauges() const { return boundary_.obstacles()->gauges().count(); }
  const DensityModel& model() const { return constraint_.model(); }
  const Walls& walls() const { return boundary_.walls(); }
  Particles& particles() { return *particles_; }
  const Particles& particles() const { return *particles_; }
  std::span<const Real> density() const { return {rho_.data(), rho_.size()}; }
  /// Number of pairs summed over all passes of the pair loops so far (events Lambda and Delta), those for observers
  /// included.
  double pair_passes() const { return pair_passes_; }

 private:
  Pairs<T> pairs() const { return {near_.records(), near_.list(), near_.order().low_ghosts()}; }
  using UseLambda = std::function<void(Range here, const T* multipliers)>;
  void find_lambda(Range part, const UseLambda& use);
  void set_multipliers(Range part);
  void find_swept_rows();
  void find_delta(Range part);
  void finish_moves();
  // After find_delta() and separate_coincident(), which mark them.
  std::vector<Range> rows_to_move() const;
  void move_rows(Range part, const std::vector<Range>& moving);
  static constexpr LocalId moved_at_once = Obstacles::at_once;
  // Moves a few particles, most of them in that box, in which they meet nothing.
  void move_in(const OpenSpace& open, Range few, Real relaxation);
  void note_collision(std::size_t i, const Vec3& began, const Vec3& change) const;
  // Of the cells inside of a window of the own ones, or outside of it.
  void separate_coincident(const CellWindow& window, bool inside);
  void note_sweep();
  void count_pass(const Event& event, Range part, double flops_per_pair);

  MPI_Comm comm_;
  Neighbourhood<T>& near_;
  const DensityConstraint<T>& constraint_;
  Boundary& boundary_;
  Particles* particles_ = nullptr;
  Real dt_ = 0;
  Borrowed<Real> rho_;
  WallsOrShifts<T> field_;  // walls between lambda and delta, then shifts
  Borrowed<T> multiplier_;  // m², as in the records
  bool positions_only_ = false, is_projected_ = false;
  Borrowed<T> act_;        // how far the grid acts on each particle
  Borrowed<T> in_flight_;  // m², of all sweeps, times 1 − act_
  FreeFlight<T> free_flight_;
  SweptRows swept_;
  std::vector<Range> swept_rows_, moved_rows_;  // owned particles: of the present sweep, and of those that have moved
  bool looks_later_ = false, has_swept_ = false;
  Borrowed<Real> swept_rho_;  // kg/m³, that the last sweep saw, where there was one and rho_ may be later ones
  double pair_passes_ = 0;
  std::array<Event, 2> phase_event_{Event("Lambda"), Event("Move")};
  const Event& lambda_event() const { return phase_event_[static_cast<std::size_t>(Phase::lambda)]; }
  Event delta_event_{"Delta"};
};

template <class T>
template <class Work>
void DensityProblem<T>::with_halo(Phase phase, Work&& work) {
  const ScopedEvent timed(phase_event_[static_cast<std::size_t>(phase)]);
  if (!near_.halo().has_neighbours()) {
    work(near_.all());
    return phase == Phase::lambda ? near_.finish_scalars() : finish_moves();
  }
  for (const Range& part : near_.boundary()) work(part);
  if (phase == Phase::lambda) {
    near_.start_scalars();
    for (const Range& part : near_.interior()) work(part);
    near_.finish_scalars();
  } else {
    near_.start_positions();
    for (const Range& part : near_.interior()) work(part);
    finish_moves();
  }
}

template <class T>
template <class Chosen>
void DensityProblem<T>::compute_lambda(Range part, const Chosen& chosen) {
  find_lambda(part, [&](Range here, const T* lambda) {
    T* const multiplier = &multiplier_[static_cast<std::size_t>(here.begin)];
    const Chosen own = chosen;
    for (std::size_t k = 0; k < static_cast<std::size_t>(here.size()); ++k)
      multiplier[k] = own(lambda[k], multiplier[k]);
  });
  set_multipliers(part);
}

template <class T>
template <class Position>
void DensityProblem<T>::set_positions(Range part, Position&& position) {
  std::vector<Vec3>& p = particles_->predicted;
  swept_.move_all();
  constexpr LocalId part_size = 512;
  for_each_part(part, part_size, [&](Range few) {  // encoded while they are in the cache
    for (LocalId i = few.begin; i < few.end; ++i) p[static_cast<std::size_t>(i)] = position(i);
    near_.encode(p, few);
  });
}

extern template class DensityProblem<float>;
extern template class DensityProblem<double>;

}  // namespace trevi
