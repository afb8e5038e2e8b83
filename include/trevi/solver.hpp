// The interface of a solver of position based fluids on slabs (Macklin & Müller 2013, Algorithm 1). Collective
// throughout: all ranks of its communicator make the same calls. Between steps each rank owns the particles in its
// slab.
#pragma once

#include <array>
#include <functional>
#include <memory>
#include <optional>
#include <vector>

#include "trevi/clock.hpp"
#include "trevi/error.hpp"
#include "trevi/forcing.hpp"
#include "trevi/observer.hpp"
#include "trevi/particles.hpp"
#include "trevi/requests.hpp"
#include "trevi/session.hpp"
#include "trevi/settings.hpp"

namespace trevi {

class Solver {
 public:
  virtual ~Solver() = default;

  /// Notifies the observers of step 0. Called once, before the first step of a run that is not a restart.
  virtual void start() = 0;
  /// Computes one step of length clock().dt and calls the observers. Throws BlowUp on all ranks alike.
  virtual void step() = 0;
  /// Makes the observers save what a restart needs, between two steps.
  virtual void save() = 0;
  /// Requests from outside the run, as agreed on by all ranks at the end of the last step.
  virtual const RequestCounts& requests() const = 0;
  /// Tells the observers that the run is over, whatever the reason.
  virtual void finish() = 0;

  virtual const Clock& clock() const = 0;
  /// The particles that this rank owns. The next step may reorder them and send some to other ranks.
  virtual const Particles& particles() const = 0;
  /// Lets `change` move, add or remove particles of this rank between two steps; the solver then sends them to the
  /// ranks that own them. Particles::predicted is not read. Ids must stay unique over all ranks. Collective. Throws
  /// BlowUp on all ranks alike for a particle outside the box, and RunError for arrays of different lengths.
  virtual void change_particles(const std::function<void(Particles&)>& change) = 0;
  /// Moves the particles of this rank out of the solver, which must not be used from then on. Not collective.
  virtual Particles take_particles() = 0;

  /// Work and communication of this rank so far, for run.json.
  struct Counters {
    double pair_passes = 0;       ///< pairs times passes over them
    std::int64_t iterations = 0;  ///< density iterations, summed over substeps
    std::int64_t substeps = 0;
    std::int64_t unconverged = 0;  ///< solves that missed their tolerance
    std::int64_t halo_bytes = 0, halo_messages = 0, migrated = 0;
    /// Imbalance (the largest work of a rank over the mean; 1 is even): the number of measurements, how often the cuts
    /// were moved, and the sum and the maximum of the measured values.
    struct Balance {
      std::int64_t looks = 0, moves = 0;
      Real sum = 0, max = 1;
    } balance;
    /// Mean compression of the water: the largest value at the end of a step so far, and the first step (counted from
    /// 1; 0 is the start, −1 none) in which it exceeded DensitySettings::crush_limit. The same on all ranks.
    struct Compression {
      Real largest = 0;
      std::int64_t first_crushed = -1;
    } compression;
    std::size_t bytes = 0;  ///< memory of particles, ghosts, lists and everything else that the solver holds
    double seconds = 0;     ///< time in step(), without observers
    /// The part of that time in which this rank waited for others, and the part of the latter spent in reductions over
    /// all ranks.
    double waiting_seconds = 0, reduction_seconds = 0;
  };
  virtual Counters counters() const = 0;
  /// States of the fountains at the clock's time, in the order of the forcings.
  virtual std::vector<FountainState> fountains() const = 0;
  /// The cell of the box from which cells are counted along x, y, z where the box is periodic; 0 along other axes.
  virtual std::array<LocalId, 3> first_cell() const = 0;
  /// Positions and motions of the bodies, in the order of the settings; the same on all ranks.
  virtual std::vector<BodyState> bodies() const = 0;
  /// What inlets and drains have done so far; null without any.
  virtual const FlowState* flow() const = 0;
};

/// What a solver may be given besides its settings.
struct SolverExtras {
  std::vector<std::unique_ptr<Forcing>> forcings;    ///< called after gravity, friction and fountains, in this order
  std::vector<std::unique_ptr<Observer>> observers;  ///< called in this order, after those that write files
  std::function<RequestCounts()> requests;           ///< requests from outside that this rank sees; may be empty
  std::int64_t step = 0;                             ///< steps completed before, for a restart
  int substeps = 1;                                  ///< number of substeps of the last of them
  /// Solver::first_cell() of the previous solver, for a restart; by default the cell of the particle with the lowest
  /// id. It has no effect in the presence of obstacles, inlets or drains, with which it is 0.
  std::optional<std::array<LocalId, 3>> first_cell{};
  std::optional<FlowState> flow{};  ///< of the previous solver, for a restart, as are the next four
  ForceSums force_sums{};
  Real supplied_energy = 0;            ///< J
  std::vector<Real> paddle_offsets{};  ///< Frame::paddle_offsets, for a restart with absorbing paddles
  std::vector<BodyState> bodies{};     ///< empty: as in the settings
};

/// Makes a solver for particles that may be on any rank, each on one rank only. Ids must be unique over all ranks, and
/// `predicted` may be empty. The solver works on a duplicate of `comm`, so that its messages cannot be confused with
/// others. Collective. Throws InputError on all ranks alike for invalid settings, music that cannot be used, a particle
/// outside the box, more ranks than cell planes, more particles than a rank can count, or an output folder that holds
/// another run. Where settings.output.directory is given, start(), step(), save() and finish() write files as the
/// output settings say.
std::unique_ptr<Solver> make_solver(MPI_Comm comm, const Settings& settings, Particles particles,
                                    SolverExtras extras = {});

}  // namespace trevi
