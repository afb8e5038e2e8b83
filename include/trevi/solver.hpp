// A solver of position based fluids on slabs (Macklin & Müller 2013, Algorithm 1), as a program uses it. Collective
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

  /// Notifies the observers of step 0. Once, before the first step of a run that is not a restart.
  virtual void start() = 0;
  /// One step of length clock().dt, observers included. Throws BlowUp on all ranks alike.
  virtual void step() = 0;
  /// Makes the observers save what a restart needs, between two steps.
  virtual void save() = 0;
  /// Requests from outside the run, as agreed on by all ranks at the end of the last step.
  virtual const RequestCounts& requests() const = 0;
  /// Tells the observers that the run is over, whatever its reason.
  virtual void finish() = 0;

  virtual const Clock& clock() const = 0;
  /// Those that this rank owns. The next step may reorder them and send some to other ranks.
  virtual const Particles& particles() const = 0;
  /// Lets `change` move, add or remove particles of this rank between two steps; where they go is up to the solver.
  /// Particles::predicted is not read. Ids stay unique over all ranks. Collective; throws BlowUp on all ranks alike for
  /// a particle outside the box, RunError for arrays of different lengths.
  virtual void change_particles(const std::function<void(Particles&)>& change) = 0;
  /// Those of this rank, in the memory where they were; the solver is of no use from then on. Not collective.
  virtual Particles take_particles() = 0;

  /// Work and traffic of this rank so far, for run.json.
  struct Counters {
    double pair_passes = 0;       ///< pairs times passes over them
    std::int64_t iterations = 0;  ///< density iterations, summed over substeps
    std::int64_t substeps = 0;
    std::int64_t unconverged = 0;  ///< solves that missed their tolerance
    std::int64_t halo_bytes = 0, halo_messages = 0, migrated = 0;
    /// Imbalance (max/mean of the work of the ranks, 1 is even) whenever it was measured, and how often cuts were
    /// moved.
    struct Balance {
      std::int64_t looks = 0, moves = 0;
      Real sum = 0, max = 1;
    } balance;
    /// Mean compression of the water: the largest at the end of a step so far, and the first step (from 1; 0 is the
    /// start, −1 none) in which it was above DensitySettings::crush_limit. The same on all ranks.
    struct Compression {
      Real largest = 0;
      std::int64_t first_crushed = -1;
    } compression;
    std::size_t bytes = 0;  ///< memory of particles, ghosts, lists and everything else the solver holds
    double seconds = 0;     ///< in step(), observers not counted
    /// Of that, waiting for other ranks, and of this, in reductions over all ranks. Of this rank.
    double waiting_seconds = 0, reduction_seconds = 0;
  };
  virtual Counters counters() const = 0;
  /// What the fountains do at the clock's time, in the order of the forcings.
  virtual std::vector<FountainState> fountains() const = 0;
  /// Of the box along x, y, z: from which cell on cells are counted where it is periodic; 0 elsewhere.
  virtual std::array<LocalId, 3> first_cell() const = 0;
  /// Where the bodies are and how they move, in the order of the settings; the same on all ranks.
  virtual std::vector<BodyState> bodies() const = 0;
  /// What inlets and drains have done so far; null without any.
  virtual const FlowState* flow() const = 0;
};

/// What a solver may be given besides its settings.
struct SolverExtras {
  std::vector<std::unique_ptr<Forcing>> forcings;    ///< called after gravity, friction and fountains, in this order
  std::vector<std::unique_ptr<Observer>> observers;  ///< called in this order, after those that write files
  std::function<RequestCounts()> requests;           ///< of this rank, from outside; may be empty
  std::int64_t step = 0;                             ///< steps done before, for a restart
  int substeps = 1;                                  ///< of the last of them
  /// Of the solver before, for a restart; by default that of the particle with the least id. Of no effect where there
  /// are obstacles, inlets or drains: it is 0 there.
  std::optional<std::array<LocalId, 3>> first_cell{};
  std::optional<FlowState> flow{};  ///< of the solver before, for a restart, as the next four
  ForceSums force_sums{};
  Real supplied_energy = 0;            ///< J
  std::vector<Real> paddle_offsets{};  ///< of the frame before, for a restart with paddles that absorb
  std::vector<BodyState> bodies{};     ///< empty: as the settings have them
};

/// A solver for particles that may be on any rank, each of them once; ids are unique over all ranks, `predicted` may be
/// empty. It works on a duplicate of `comm`, so that its messages meet no others. Collective. Throws InputError on all
/// ranks alike for settings that cannot be, music that cannot be used, a particle outside the box, more ranks than cell
/// planes, more particles than a rank can count, or a folder for the output that holds another run. Where
/// settings.output.directory is given, files are written as output says: by start(), step(), save() and finish().
std::unique_ptr<Solver> make_solver(MPI_Comm comm, const Settings& settings, Particles particles,
                                    SolverExtras extras = {});

}  // namespace trevi
