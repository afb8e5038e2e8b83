// Deep water that enters and leaves through upright walls of the box: inlets with a profile or a level, drains with a
// level or a flow (inputs/README.md, Open boundaries). Before each substep the level of the water before each opening
// says how fast it goes there:
//   U = mean + sqrt(g/d) (level - held level)  out of a drain, and with the other sign into an inlet,
// which is what a long wave that leaves needs: none comes back. The mean follows U in 20 sqrt(d/g), so that the level
// is held. Where a flow is held the mean speed is given, and the level that waves are counted from follows the water.
// Sums over particles are integers: no bit depends on the ranks. Collective: measure() and leaving().
#pragma once

#include <optional>
#include <span>
#include <string>
#include <tuple>
#include <vector>

#include "base/threads.hpp"
#include "boundary/standing_solids.hpp"
#include "fluid/forcings/inlet.hpp"
#include "projection/openings.hpp"
#include "trevi/observer.hpp"
#include "trevi/session.hpp"

namespace trevi {

/// An upright wall of the box.
struct UprightWall {
  int axis = 0;
  bool at_max = false;
};
/// Those that a box touches across x or y, but for axes that it spans from wall to wall.
std::vector<UprightWall> walls_beside(const DrainSettings& drain, const Settings& settings);

/// What is wrong with an opening in a wall, with a remedy.
struct WallRefusal {
  const char* key;
  std::string why;
};
/// Of settings whose box and spacing are known; `inlet.direction` has the length 1.
std::optional<WallRefusal> why_not_in_wall(const InletSettings& inlet, const Settings& settings);
std::optional<WallRefusal> why_not_in_wall(const DrainSettings& drain, const Settings& settings);
/// Of one inlet more than those of the settings: two of a wall that overlap would bring water to the same places.
std::optional<WallRefusal> why_not_beside(const InletSettings& inlet, std::span<const InletSettings> others,
                                          const Settings& settings);
/// Of one drain more than those of the settings: two of a wall that overlap would both take, and both measure, the same
/// water. It is good by itself, the others need not be.
std::optional<WallRefusal> why_not_beside(const DrainSettings& drain, std::span<const DrainSettings> others,
                                          const Settings& settings);
/// Of an inlet with a profile, which has that many rows, at a time, m/s.
Real mean_speed(const InletSettings& inlet, Real rows, Real spacing, Real time);

class WallFlows {
 public:
  explicit WallFlows(const Settings& settings);
  /// Makes room in the state of a run that begins.
  void resize(FlowState& state) const;

  bool any() const { return !openings_.empty(); }
  /// How fast the water goes in the substep, from where it stands. `state` is that of the flow.
  void measure(MPI_Comm comm, const Particles& particles, const StepInfo& info, FlowState& state);
  /// The particles of this rank that leave through walls in the time dt, in ascending order. By a drain that draws
  /// nothing none does: what is still trembles, and would be lost particle by particle. By one with a flow as many as
  /// what goes through it is worth, those nearest to the wall.
  std::vector<LocalId> leaving(MPI_Comm comm, const Particles& particles, Real dt, FlowState& state) const;
  std::vector<WallOpening> walls(Real dt) const;

  /// The first of the rows of an inlet in FlowState::rows; -1 where it is not in a wall.
  std::ptrdiff_t first_row(std::size_t inlet) const { return first_row_[inlet]; }
  /// m/s, of each row of an inlet; those above its level are not there.
  const std::vector<Real>& speeds(std::size_t inlet) const { return openings_[of_inlet_[inlet]].speeds; }

 private:
  struct Opening {
    UprightWall wall;
    Real from = 0, to = 0;         // where its level is measured, along the axis, m
    std::array<Real, 2> across{};  // along the other level axis, m
    std::array<Real, 2> seen{};    // the same; beyond walls where it ends at them, which particles are close to
    Real bottom = 0, top = 0;      // m
    const InletSettings* inlet = nullptr;
    const DrainSettings* drain = nullptr;
    std::vector<Real> speeds{};         // m/s: of rows of an inlet; of a drain one, out of the box
    std::optional<OpenVolume> space{};  // where that is measured; with solids in it
    Real area() const { return (to - from) * (across[1] - across[0]); }
    // Of the water that goes through it.
    Real depth(Real level) const { return space ? std::min(level - bottom, space->depth(level)) : level - bottom; }
    Real width(Real level) const { return space ? space->area(level) / (to - from) : across[1] - across[0]; }
  };
  struct Water {
    Real level, speed;  // m; m/s along the axis
  };
  // A particle that may leave by a drain with a flow: the nearest to the wall, m, is first.
  struct Leaving {
    Real left;
    GlobalId id;
    LocalId local;
    int rank;
    bool operator<(const Leaving& other) const { return std::tie(left, id) < std::tie(other.left, other.id); }
  };
  std::optional<Real> distance_left(const Opening& one, const Vec3& position, const Vec3& velocity, Real dt) const;
  static std::vector<Leaving> first_of_all(MPI_Comm comm, std::vector<Leaving> mine, GlobalId due);
  void add_inlet(const InletSettings& inlet, std::size_t rows);
  void add_drain(const DrainSettings& drain);
  void find_seen(Opening& opening, const StandingSolids& solids) const;
  std::vector<Water> look(MPI_Comm comm, const Particles& particles);
  void drive_inlet(Opening& opening, const Water& water, const StepInfo& info, FlowState::Opening& state) const;
  void drive_drain(Opening& opening, const Water& water, const StepInfo& info, FlowState::Opening& state) const;

  std::vector<InletSettings> inlet_settings_;
  std::vector<DrainSettings> drain_settings_;
  Settings settings_;
  Real spacing_, gravity_;
  std::vector<Opening> openings_;  // inlets first
  std::vector<std::ptrdiff_t> first_row_;
  std::vector<std::size_t> of_inlet_;
  std::size_t rows_ = 0;
  std::size_t drains_ = 0;
  PerThread<std::vector<GlobalId>> sums_;
};

}  // namespace trevi
