// The density solve of a substep as the density solvers (density_solver.hpp) see it: by the operations below they move
// the positions p* until C_i = 0, on a fixed neighbour list. Line numbers are those of Algorithm 1 of Macklin & Müller
// 2013. An operation for a range changes the records of owned particles only. with_halo() updates the ghosts, and sends
// the messages while interior planes are processed. Collective: with_halo, compression, project, release_in_flight,
// filter_shifts.
//
// With a projection the velocities come from it, by set_velocities(), and the sweeps after it shift positions only: the
// kernel sums of a sheared lattice are larger than those of a lattice that is not, and a sweep that became velocity
// would resist shear. Where the grid does not act, in sheets, thin jets and spray, there are only the sweeps. Their
// multipliers then also become velocity, each with its own fraction 1 − act_i, so that each pair conserves its
// momentum.
//
// A pass skips rows of cells whose result is known: densities where nothing has moved, and shifts where there is no
// multiplier (swept_rows.hpp).
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
  /// `gravity`: that of free flight, m/s²; 0 if velocities are not those of the projection.
  DensityProblem(MPI_Comm comm, Neighbourhood<T>& near, const DensityConstraint<T>& constraint, Boundary& boundary,
                 const Vec3& gravity);

  /// Starts a solve for the particles just sorted into `near`, which were predicted over the time dt, s. Their
  /// neighbours need not be known before prepare(), which follows project(). `held`: for how long something other than
  /// gravity determines the motion of a particle, s; may be empty.
  void start(Particles& particles, Real dt, std::function<Real(std::size_t)> held = {});
  void prepare();
  /// Gives back densities and all other memory; to be called before particles are sorted again.
  void give_back();

  /// Calls work(part) for the boundary, sends the scalars of its records, or with Phase::move their positions, calls
  /// work(interior), and receives those of the ghosts.
  template <class Work>
  void with_halo(Phase phase, Work&& work);

  /// Computes rho_i and lambda_i of the owned particles of a range from the present p* (lines 9 to 11). The records,
  /// which neighbours read, get chosen(lambda_i, last), m², where last is the previously chosen value in this solve, at
  /// first 0.
  template <class Chosen>
  void compute_lambda(Range part, const Chosen& chosen);
  /// Compression of all particles at the last compute_lambda() or compute_density(); the same bits on any rank count.
  Compression compression() const;
  /// Computes delta_i, m, of all owned particles from the present lambda (lines 12 and 13).
  void compute_delta();
  /// The same, followed by separate_coincident(), if requested, and by collide_and_move(). The boundary comes first,
  /// and its positions are sent while the rest is computed. Collective.
  void compute_delta_and_move(bool separate);
  /// Sets delta from the projection instead: displacements that conserve the volume over long distances. Velocities
  /// lose their values, as in sorting.
  void project(Projection& projection);
  /// Sets velocities from the motion so far; from here on only positions are shifted. `looks_later`: whether densities
  /// are computed once more after the sweeps, as a tolerance requires.
  void set_velocities(bool looks_later);
  /// Gives the water in flight the velocity that the sweeps have found for its pairs and at walls.
  void release_in_flight();
  /// Marks particles as belonging to pieces of water that touch nothing (free_flight.hpp). After prepare().
  void let_fly(std::span<const Range> parts) { free_flight_.let_fly(near_.all(), parts, near_.scratch()); }
  /// The final position of particle i if the pressure does not move it further. Between let_fly() and set_velocities().
  Vec3 end_of_flight(std::size_t i) const { return particles_->predicted[i] + free_flight_.lift_of(i); }
  /// Removes from the shifts since set_velocities() the part that moves the water as a whole, and lifts water in flight
  /// to its path. Changes p* only, neither records nor ghosts.
  void filter_shifts(Projection& projection);
  /// Adds small, opposite shifts to delta for coincident particles, which their kernel gradient would never separate
  /// because it is zero.
  void separate_coincident() { separate_coincident({}, false); }
  Vec3 delta(LocalId i) const { return field_.shift(static_cast<std::size_t>(i)); }
  /// Sets p*_i += relaxation · delta_i as far as walls allow (lines 14 to 18).
  void collide_and_move(Range part, Real relaxation = 1);
  /// Sets p*_i = position(i) for the range.
  template <class Position>
  void set_positions(Range part, Position&& position);

  /// Computes rho_i of all owned particles at the present p*, without changing lambda.
  void compute_density();
  /// The same before the first step, as a pass that is not counted.
  void look_at_density();

  const CellOrder& order() const { return near_.order(); }
  /// Sends the numbers of particles from their owners to the ghosts. Collective.
  void exchange(Borrowed<std::int64_t>& numbers) { near_.exchange(numbers); }
  /// The memory that the stages of the substep share.
  Scratch& scratch() const { return near_.scratch(); }
  /// All owned particles.
  Range all() const { return near_.all(); }
  /// Length of the substep, s.
  Real dt() const { return dt_; }
  /// Null if there are none.
  Obstacles* obstacles() const { return boundary_.obstacles(); }
  /// Impulses that obstacles and the box received from the water in this step; only with obstacles. Collective.
  std::vector<TotalImpulse> taken() const { return boundary_.obstacles()->total(comm_); }
  /// Impulses on the pressure gauges in this step, m² (PressureGauges); as taken().
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
  // Rows to be moved; after find_delta() and separate_coincident(), which mark them.
  std::vector<Range> rows_to_move() const;
  void move_rows(Range part, const std::vector<Range>& moving);
  static constexpr LocalId moved_at_once = Obstacles::at_once;
  // Moves a few particles, most of which are in `open`, where they meet nothing.
  void move_in(const OpenSpace& open, Range few, Real relaxation);
  void note_collision(std::size_t i, const Vec3& began, const Vec3& change) const;
  // For the cells inside a window of the owned cells, or outside it.
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
  WallsOrShifts<T> field_;  // contributions of walls between lambda and delta, then shifts
  Borrowed<T> multiplier_;  // m², as in the records
  bool positions_only_ = false, is_projected_ = false;
  Borrowed<T> act_;        // how far the grid acts on each particle
  Borrowed<T> in_flight_;  // m², sum over all sweeps, times 1 − act_
  FreeFlight<T> free_flight_;
  SweptRows swept_;
  std::vector<Range> swept_rows_, moved_rows_;  // owned particles in rows of the present sweep, and in rows that moved
  bool looks_later_ = false, has_swept_ = false;
  Borrowed<Real> swept_rho_;  // kg/m³, densities of the last sweep, if there was one and rho_ may be later ones
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
