// Water that enters and leaves: before each substep drains take the particles in their regions, and inlets make the
// layers that are due. All ranks know what has been done so far (FlowState) and find the same layers from it: which
// places are free is a small reduction over the ranks, and the ids are those that follow, so that no id and no place
// depends on the ranks. A particle is made by the rank that owns its place. Places with water nearer than half a
// spacing are left out, and made up for by layers that come sooner; those that a solid or a wall covers are not made up
// for. Within a spacing ahead of the opening water keeps the velocity of the jet, from there on it flies under gravity,
// to the part of a substep. Collective: begin() and exchange().
#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "boundary/boundary.hpp"
#include "domain/slabs.hpp"
#include "fluid/forcings/inlet.hpp"
#include "parallel/step_consensus.hpp"
#include "particles/cell_grid.hpp"
#include "projection/openings.hpp"
#include "solver/wall_flows.hpp"
#include "trevi/box.hpp"
#include "trevi/observer.hpp"
#include "trevi/session.hpp"

namespace trevi {

/// Counts a particle that has come to, or of `sign` −1 gone from, the others.
void count(StepState& change, GlobalId id, std::uint64_t sign);

class InflowOutflow {
 public:
  struct Parts {
    std::vector<std::shared_ptr<Inlet>> inlets;
    std::vector<DrainSettings> drains;
    Box box;
    Real spacing = 0;
    Vec3 gravity = Vec3::Zero();
    std::shared_ptr<WallFlows> flows{};  ///< null where no opening is in a wall
  };
  /// `state`: that of a run that goes on.
  InflowOutflow(Parts parts, std::optional<FlowState> state);

  /// The nozzles of the inlets, in their order.
  std::vector<std::unique_ptr<Forcing>> forcings() const;
  /// Before the first substep, with all particles there are. New ids follow the largest of them. `boundary` outlives
  /// the forcings.
  void begin(MPI_Comm comm, const Boundary& boundary, const Particles& particles);
  /// The particles of all ranks that have come, less those that have gone.
  StepState exchange(Particles& particles, const StepInfo& info, const CellGrid& grid, const Slabs& slabs);

  const FlowState& state() const { return state_; }
  /// What a projection is to know.
  Openings* openings() { return openings_.get(); }

 private:
  // The particles of this rank, and what tells which of the new ones are its own.
  struct Water {
    Particles& particles;
    const StepInfo& info;
    const CellGrid& grid;
    const Slabs& slabs;
  };
  // Layers that are due at once.
  struct Layers {
    const Inlet& inlet;
    Real speed;      // m/s
    Real first = 0;  // ahead of the opening, m; the others follow, a spacing each
    GlobalId count = 0;
    Real ahead(GlobalId layer, Real spacing) const { return first - static_cast<Real>(layer) * spacing; }
  };
  // Places layer by layer, the farthest layer first: what can be made of each.
  enum Place : char { taken, open, covered };
  struct Made {
    GlobalId particles = 0, covered = 0, blocked = 0;
    bool dry = false;  // there was not enough water for all of the layers
  };
  // A place of an inlet in a wall, and how far ahead of the opening; of a row the first of these, and its layers.
  struct Due {
    GlobalId place;
    Real ahead;
  };
  struct RowDue {
    std::size_t first = 0;
    GlobalId layers = 0;
  };
  std::vector<Due> due_places(std::size_t k, std::vector<RowDue>& rows);
  std::vector<char> free_places(std::size_t k, const std::vector<Due>& due, const std::vector<RowDue>& rows,
                                const Particles& particles) const;
  void run_rows(std::size_t k, Water& water, StepState& change);
  void drain(Particles& particles, Real dt, StepState& change);
  void run(std::size_t k, Water& water, StepState& change);
  std::vector<char> places(const Layers& layers, const Particles& particles) const;
  void add_sources(const Inlet& inlet, Real path);
  bool covers(const Vec3& from, const Vec3& place) const;
  Made make(const Layers& layers, Water& water, StepState& change);
  void add(Water& water, const Vec3& place, const Vec3& velocity) const;

  MPI_Comm comm_ = MPI_COMM_NULL;
  const Boundary* boundary_ = nullptr;
  Parts parts_;
  std::shared_ptr<WallFlows> flows_;
  FlowState state_;
  bool recycles_;
  std::unique_ptr<Openings> openings_;
  std::vector<Openings::Source> sources_;  // of the substep
  std::optional<StepConsensus> consensus_;
  Event event_{"OpenFlow"};
};

}  // namespace trevi
