// Observers look at a run and write output; they never change it. Each has its own schedule. The solver calls them at
// the end of a step, while the particles are still in the cell order of that step.
#pragma once

#include <span>
#include <vector>

#include "trevi/body.hpp"
#include "trevi/clock.hpp"
#include "trevi/forcing.hpp"
#include "trevi/particles.hpp"

namespace trevi {

/// One row of series.csv, sums and maxima over all ranks, the same bits on any rank count (but imbalance,
/// wall_seconds). Units: SI; definitions in postprocess/README.md. Undefined values are nan.
struct Diagnostics {
  GlobalId particles = 0;
  std::int64_t iterations = 0;  ///< of the density solves of the step, its substeps added up
  Real density_mean = 0, density_max = 0, density_interior = 0;
  Real compression_mean = 0, compression_max = 0, compression_rms = 0;
  Real kinetic_energy = 0, potential_energy = 0;
  Vec3 momentum = Vec3::Zero(), com = Vec3::Zero();
  Real speed_max = 0, top = 0, front = 0, front_q99 = 0, drift_max = 0;
  Real imbalance = 1, wall_seconds = 0;
};

/// What inlets and drains have done since the start of a run, in particles; the same on all ranks. What is in the scene
/// and what waits together are what was there at the start and what inlets without `recycle` have made since.
struct FlowState {
  GlobalId next_id = 0;              ///< of the next particle that an inlet makes
  GlobalId inflow = 0, outflow = 0;  ///< made by inlets, taken by drains
  GlobalId waiting = 0;              ///< taken by drains for the inlets that recycle
  /// Of an inlet: how far the water has come since its last layer, m, and its speed in the last substep, m/s. Then, in
  /// particles: those made, and those that were asked for and never will be, as a solid covers their places, as other
  /// water was in their places for too long, or as drains had taken too little for them.
  struct Stream {
    Real travelled = 0, speed = 0;
    Real made = 0, covered = 0, blocked = 0, dry = 0;
    Real asked() const { return made + covered + blocked + dry; }
  };
  std::vector<Stream> streams;  ///< in the order of the scene
  /// Of an opening in a wall: the mean speed, m/s, and the mean level, m, that it has come to; and the particles that
  /// should have left and have not, of a drain with a flow.
  struct Opening {
    Real speed = 0, level = 0, owed = 0;
    bool known = false;
    Real due = 0;  ///< of a drain with a flow: particles of what has gone through it that it has still to take
  };
  std::vector<Opening> openings;  ///< of inlets with a profile or a level, then of drains with a level or a flow
  std::vector<Real> rows;  ///< of these inlets: how far the water of each row has come since its last particles, m
};

/// What the water did to an obstacle, or to the box, in the mean over the steps since the observer was last due.
struct BodyForce {
  Vec3 force = Vec3::Zero();   ///< N
  Vec3 torque = Vec3::Zero();  ///< N m, about the centre of the obstacle, the centre of mass of a body
};

/// The forces of the steps since an observer was last due, added up; what a restart needs to go on with the mean.
struct ForceSums {
  std::int64_t steps = 0;           ///< of the forces
  std::vector<BodyForce> forces;    ///< on each obstacle, each body, then on the box
  std::vector<Real> pressures;      ///< of each gauge of pressure on a solid
  std::int64_t pressure_steps = 0;  ///< of these
};

/// What an observer may read at the end of a step. Particles and density: owned ones only, same order.
struct Frame {
  const Clock& clock;
  const Particles& particles;
  std::span<const Real> density;             ///< kg/m³ at the final positions; empty unless an observer wanted it
  const Diagnostics* diagnostics;            ///< null unless an observer wanted it
  std::span<const FountainState> fountains;  ///< at the clock's time, in the order of the scene, inlets last
  const FlowState* flow = nullptr;           ///< null where the scene has no inlet and no drain
  /// On each obstacle, each body, then on the box, in the mean over the steps since this observer was last due; empty
  /// unless it wants them.
  std::span<const BodyForce> forces{};
  /// Pa, of each gauge of pressure on a solid, likewise.
  std::span<const Real> pressures{};
  std::array<LocalId, 3> first_cell{};  ///< Solver::first_cell()
  /// Not yet in a mean, of the first observers that want forces and pressures, which are those of the run's files where
  /// it writes some; null without obstacles and bodies.
  const ForceSums* force_sums = nullptr;
  /// J, given to the water since the start by forcings that are not gravity or friction, by what inlets bring and
  /// drains take, by bodies (what they have less of), and by obstacles that move (of these with an observer that wants
  /// forces only). Measured from the
  /// first step on if an observer wants diagnostics; 0 otherwise.
  Real supplied_energy = 0;
  std::span<const Real> paddle_offsets{};  ///< m, ActiveAbsorption::state(); empty without paddles that absorb
  std::span<const Real> probes{};          ///< Pa, of each gauge of pressure in the water in this step; with pressures
  std::span<const BodyState> bodies{};     ///< in the order of the scene
};

class Observer {
 public:
  virtual ~Observer() = default;
  /// Whether to be called at this step. The same answer on all ranks.
  virtual bool due(const Clock& clock) const = 0;
  virtual bool wants_density() const { return false; }
  virtual bool wants_diagnostics() const { return false; }
  virtual bool wants_forces() const { return false; }
  /// What gauges of pressure show.
  virtual bool wants_pressures() const { return wants_forces(); }
  /// Collective.
  virtual void observe(const Frame& frame) = 0;
  /// Writes what a restart needs, on a request from outside (SIGUSR1, a request to stop), due or not. Collective.
  virtual void save(const Frame&) {}
  /// Once at the end of the run, whatever its reason. Collective.
  virtual void finish(const Frame&) {}
};

}  // namespace trevi
