// The time step of position based fluids (Macklin & Müller 2013, Algorithm 1) on slabs, and the state that it advances.
// Collective throughout. The ghosts and the order of the particles stay the same from the prediction to the end of the
// velocity filters of a substep. So does the neighbour list from its construction after the projection on: the
// projection and the neighbour list use the same memory in turn (base/scratch.hpp).
#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <vector>

#include "base/threads.hpp"
#include "boundary/boundary.hpp"
#include "domain/balance.hpp"
#include "fluid/filters/velocity_filter.hpp"
#include "solver/active_absorption.hpp"
#include "solver/guard.hpp"
#include "solver/inflow_outflow.hpp"
#include "solver/reporter.hpp"
#include "solver/substep_rule.hpp"
#include "trevi/solver.hpp"

namespace trevi {

/// A duplicate of a communicator for the lifetime of the object. Collective.
class OwnCommunicator {
 public:
  explicit OwnCommunicator(MPI_Comm comm) { MPI_Comm_dup(comm, &comm_); }
  ~OwnCommunicator();
  OwnCommunicator(const OwnCommunicator&) = delete;
  OwnCommunicator& operator=(const OwnCommunicator&) = delete;
  operator MPI_Comm() const { return comm_; }

 private:
  MPI_Comm comm_ = MPI_COMM_NULL;
};

/// All parts of a solver; filled by make_solver().
template <class T>
struct SolverParts {
  std::unique_ptr<OwnCommunicator> comm;
  Box box;  ///< beginning at the first cell along periodic axes
  std::array<LocalId, 3> first_cell{};
  std::unique_ptr<CellGrid> grid;
  std::unique_ptr<Slabs> slabs;
  std::unique_ptr<Balance> balance;
  std::unique_ptr<Boundary> boundary;
  std::unique_ptr<ActiveAbsorption> absorption;                    ///< null without absorbing paddles
  std::unique_ptr<PressureProbes> probes;                          ///< null without gauges of pressure in the water
  std::shared_ptr<Scratch> scratch = std::make_shared<Scratch>();  ///< memory from which stages of a step borrow arrays
  std::unique_ptr<DensityConstraint<T>> constraint;
  std::unique_ptr<DensitySolver<T>> density_solver;
  std::shared_ptr<InflowOutflow> flow;             ///< may be null
  std::vector<std::unique_ptr<Forcing>> forcings;  ///< gravity and friction first
  std::size_t first_own_forcing = 0;  ///< from here on they are the program's, and the particles are checked after them
  std::vector<std::unique_ptr<VelocityFilter<T>>> filters;
  std::vector<std::unique_ptr<Observer>> observers;
  std::unique_ptr<DiagnosticsSum> diagnostics;
  SubstepRule substep_rule;
  ForceSums force_sums;  ///< of the previous solver, as are the next two
  std::vector<BodyState> bodies;
  Real supplied_energy = 0;          ///< J
  std::vector<Real> paddle_offsets;  ///< of the previous solver, m
  Real water_mass = 0;               ///< of a particle, kg
  Vec3 gravity = Vec3::Zero();
  Vec3 corner = Vec3::Zero();  ///< of the box, m, where the potential energy is 0
  Real crush_limit = 0;
  Clock clock;
  std::function<RequestCounts()> requests;  ///< requests from outside that this rank sees; may be empty
  Particles particles;                      ///< particles in this rank's slab by position
};

template <class T>
class PbfSolver : public Solver {
 public:
  explicit PbfSolver(SolverParts<T> parts);

  void start() override;
  void step() override;
  void save() override;
  const RequestCounts& requests() const override { return guard_.requests(); }
  void finish() override;

  const Clock& clock() const override { return parts_.clock; }
  const Particles& particles() const override { return parts_.particles; }
  void change_particles(const std::function<void(Particles&)>& change) override;
  Particles take_particles() override { return std::move(parts_.particles); }
  Counters counters() const override;
  std::vector<FountainState> fountains() const override { return reporter_.fountain_states(clock().time()); }
  std::array<LocalId, 3> first_cell() const override { return parts_.first_cell; }
  std::vector<BodyState> bodies() const override {
    const Obstacles* const solids = parts_.boundary->obstacles();
    return solids != nullptr && solids->floating() != nullptr ? solids->floating()->states() : std::vector<BodyState>{};
  }
  const FlowState* flow() const override { return parts_.flow ? &parts_.flow->state() : nullptr; }

 private:
  void prepare_step();
  void ask_observers(std::int64_t step);
  SubstepRule::Push push();
  void exchange_water(const StepInfo& info);
  void substep(const StepInfo& info);
  // The lines of Algorithm 1, in their order.
  void apply_forcings(const StepInfo& info);
  void apply_forcing(Forcing& forcing, const StepInfo& info);
  std::function<Real(std::size_t)> held(const StepInfo& info) const;
  void predict_positions(Real dt);
  void migrate_particles(std::vector<Vec3> Particles::*position);
  void arrange_particles(Velocities velocities);
  void find_neighbours();
  void update_velocities(Real dt);
  void apply_velocity_filters(Real dt);
  void agree_on_failures();
  void accept_positions();

  int threads_ = thread_count();
  SolverParts<T> parts_;
  Guard guard_;
  Neighbourhood<T> near_;
  DensityProblem<T> problem_;
  Reporter<T> reporter_;
  Event predict_event_{"Predict"}, migrate_event_{"Migrate"}, update_event_{"UpdateVelocity"};
};

extern template class PbfSolver<float>;
extern template class PbfSolver<double>;

}  // namespace trevi
