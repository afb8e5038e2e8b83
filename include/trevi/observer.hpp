// Observers read the state of a run and write output; they never change the run. Each has its own schedule. The solver
// calls them at the end of a step, while the particles are still in the cell order of that step.
#pragma once

#include <span>
#include <vector>

#include "trevi/body.hpp"
#include "trevi/clock.hpp"
#include "trevi/forcing.hpp"
#include "trevi/particles.hpp"

namespace trevi {

/// One row of series.csv: sums and maxima over all ranks, with the same bits on any rank count, except for imbalance
/// and wall_seconds. SI units; the definitions are in postprocess/README.md. Undefined values are nan.
struct Diagnostics {
  GlobalId particles = 0;
  std::int64_t iterations = 0;  ///< of the density solves of the step, summed over its substeps
  Real density_mean = 0, density_max = 0, density_interior = 0;
  Real compression_mean = 0, compression_max = 0, compression_rms = 0;
  Real kinetic_energy = 0, potential_energy = 0;
  Vec3 momentum = Vec3::Zero(), com = Vec3::Zero();
  Real speed_max = 0, top = 0, front = 0, front_q99 = 0, drift_max = 0;
  Real imbalance = 1, wall_seconds = 0;
};

/// What inlets and drains have done since the start of a run, in particles; the same on all ranks. The particles in the
/// scene and those that wait are together as many as the initial ones and those made since by inlets without `recycle`.
struct FlowState {
  GlobalId next_id = 0;              ///< id of the next particle that an inlet makes
  GlobalId inflow = 0, outflow = 0;  ///< made by inlets, removed by drains
  GlobalId waiting = 0;              ///< removed by drains, and available to the inlets that recycle
  /// State of an inlet: how far the water has travelled since its last layer, m, and its speed in the last substep,
  /// m/s. Then numbers of particles: those made, and those that were requested but will never be made, because a solid
  /// covers their places, because other water occupied their places for too long, or because drains had removed too
  /// little.
  struct Stream {
    Real travelled = 0, speed = 0;
    Real made = 0, covered = 0, blocked = 0, dry = 0;
    Real asked() const { return made + covered + blocked + dry; }
  };
  std::vector<Stream> streams;  ///< in the order of the scene
  /// State of an opening in a wall: its present mean speed, m/s, and mean level, m; and, for a drain with a flow, the
  /// particles that should have left but have not.
  struct Opening {
    Real speed = 0, level = 0, owed = 0;
    bool known = false;
    Real due = 0;  ///< for a drain with a flow: particles of the water that has passed it which it has yet to remove
  };
  std::vector<Opening> openings;  ///< inlets with a profile or a level, then drains with a level or a flow
  std::vector<Real> rows;         ///< for these inlets: distance of the water of each row since its last particles, m
};

/// Force and torque of the water on an obstacle or on the box, averaged over the steps since the observer was last due.
struct BodyForce {
  Vec3 force = Vec3::Zero();   ///< N
  Vec3 torque = Vec3::Zero();  ///< N m, about the centre of the obstacle or the centre of mass of the body
};

/// The forces summed over the steps since an observer was last due. A restart needs them to continue the average.
struct ForceSums {
  std::int64_t steps = 0;           ///< number of steps in the sums of forces
  std::vector<BodyForce> forces;    ///< on each obstacle, each body, then on the box
  std::vector<Real> pressures;      ///< at each gauge of pressure on a solid
  std::int64_t pressure_steps = 0;  ///< number of steps in the sums of pressures
};

/// What an observer may read at the end of a step. Particles and density: owned ones only, in the same order.
struct Frame {
  const Clock& clock;
  const Particles& particles;
  std::span<const Real> density;             ///< kg/m³ at the final positions; empty unless an observer wanted it
  const Diagnostics* diagnostics;            ///< null unless an observer wanted it
  std::span<const FountainState> fountains;  ///< at the clock's time, in the order of the scene, inlets last
  const FlowState* flow = nullptr;           ///< null where the scene has no inlet and no drain
  /// Forces on each obstacle, on each body, then on the box, averaged over the steps since this observer was last due;
  /// empty unless the observer wants them.
  std::span<const BodyForce> forces{};
  /// Pressures at each gauge of pressure on a solid, Pa, averaged likewise.
  std::span<const Real> pressures{};
  std::array<LocalId, 3> first_cell{};  ///< Solver::first_cell()
  /// Sums that have not yet entered an average, of the first observers that want forces and pressures. These are the
  /// observers that write the files of the run, where it writes any. Null without obstacles and bodies.
  const ForceSums* force_sums = nullptr;
  /// Energy supplied to the water since the start, J: by forcings other than gravity and friction, by the water that
  /// inlets bring and drains take, by bodies (the energy that they have lost), and by moving obstacles (only with an
  /// observer that wants forces). Measured from the first step on if an observer wants diagnostics; 0 otherwise.
  Real supplied_energy = 0;
  std::span<const Real> paddle_offsets{};  ///< m, ActiveAbsorption::state(); empty without absorbing paddles
  std::span<const Real> probes{};          ///< Pa, at each gauge of pressure in the water in this step; with pressures
  std::span<const BodyState> bodies{};     ///< in the order of the scene
};

class Observer {
 public:
  virtual ~Observer() = default;
  /// Whether the observer is to be called at this step. The same answer on all ranks.
  virtual bool due(const Clock& clock) const = 0;
  virtual bool wants_density() const { return false; }
  virtual bool wants_diagnostics() const { return false; }
  virtual bool wants_forces() const { return false; }
  /// Whether it wants the readings of pressure gauges.
  virtual bool wants_pressures() const { return wants_forces(); }
  /// Collective.
  virtual void observe(const Frame& frame) = 0;
  /// Writes what a restart needs, on a request from outside (SIGUSR1, a request to stop), due or not. Collective.
  virtual void save(const Frame&) {}
  /// Called once at the end of the run, whatever its reason. Collective.
  virtual void finish(const Frame&) {}
};

}  // namespace trevi
