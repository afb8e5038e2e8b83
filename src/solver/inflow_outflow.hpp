// Inflow and outflow of water: before each substep drains remove the particles in their regions, and inlets make the
// layers that are due. All ranks know what has been done so far (FlowState) and derive the same layers from it. A small
// reduction over the ranks determines which places are free, and ids are consecutive, so that no id and no place
// depends on the ranks. A particle is made by the rank that owns its place. Places with water nearer than half a
// spacing are left out, and layers that come sooner make up for them; places that a solid or a wall covers are not made
// up for. Within a spacing ahead of the opening water keeps the velocity of the jet. From there on it flies under
// gravity, also for a part of a substep. Collective: begin() and exchange().
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

/// Counts a particle that has been added, or with `sign` −1 removed.
void count(StepState& change, GlobalId id, std::uint64_t sign);

class InflowOutflow {
 public:
  struct Parts {
    std::vector<std::shared_ptr<Inlet>> inlets;
    std::vector<DrainSettings> drains;
    Box box;
    Real spacing = 0;
    Vec3 gravity = Vec3::Zero();
    std::shared_ptr<WallFlows> flows{};  ///< null if no opening is in a wall
  };
  /// `state`: that of the run that is continued.
  InflowOutflow(Parts parts, std::optional<FlowState> state);

  /// The nozzles of the inlets, in their order.
  std::vector<std::unique_ptr<Forcing>> forcings() const;
  /// To be called before the first substep, with all particles. New ids follow the largest of these. `boundary` must
  /// outlive the forcings.
  void begin(MPI_Comm comm, const Boundary& boundary, const Particles& particles);
  /// Removes and adds particles. Returns the particles of all ranks that were added, minus those that were removed.
  StepState exchange(Particles& particles, const StepInfo& info, const CellGrid& grid, const Slabs& slabs);

  const FlowState& state() const { return state_; }
  /// The openings for the projection.
  Openings* openings() { return openings_.get(); }

 private:
  // The particles of this rank, and the data that determine which of the new ones it owns.
  struct Water {
    Particles& particles;
    const StepInfo& info;
    const CellGrid& grid;
    const Slabs& slabs;
  };
  // Layers that are due at the same time.
  struct Layers {
    const Inlet& inlet;
    Real speed;      // m/s
    Real first = 0;  // distance ahead of the opening, m; the others follow at intervals of a spacing
    GlobalId count = 0;
    Real ahead(GlobalId layer, Real spacing) const { return first - static_cast<Real>(layer) * spacing; }
  };
  // The state of each place, layer by layer, the farthest layer first.
  enum Place : char { taken, open, covered };
  struct Made {
    GlobalId particles = 0, covered = 0, blocked = 0;
    bool dry = false;  // whether there was not enough water for all of the layers
  };
  // A place of an inlet in a wall and its distance ahead of the opening; for a row, the first of its places and the
  // number of its layers.
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
