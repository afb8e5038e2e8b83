// Deep water that enters and leaves through vertical walls of the box: inlets with a profile or a level, drains with a
// level or a flow (inputs/README.md, Open boundaries). Before each substep the level of the water in front of each
// opening determines its speed there:
//   U = mean + sqrt(g/d) (level - held level)  out of a drain, and with the other sign into an inlet.
// This is the speed of an outgoing long wave, so that none is reflected. The mean follows U within 20 sqrt(d/g), so
// that the level is held. Where a flow is held, the mean speed is given, and the level relative to which waves are
// measured follows the water. Sums over particles are integers: no bit depends on the ranks. Collective: measure() and
// leaving().
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

/// A vertical wall of the box.
struct UprightWall {
  int axis = 0;
  bool at_max = false;
};
/// The walls across x or y that the box of a drain touches, except along axes that it spans from wall to wall.
std::vector<UprightWall> walls_beside(const DrainSettings& drain, const Settings& settings);

/// What is wrong with an opening in a wall, and the remedy.
struct WallRefusal {
  const char* key;
  std::string why;
};
/// For settings whose box and spacing are known; `inlet.direction` must have the length 1.
std::optional<WallRefusal> why_not_in_wall(const InletSettings& inlet, const Settings& settings);
std::optional<WallRefusal> why_not_in_wall(const DrainSettings& drain, const Settings& settings);
/// For one inlet in addition to those of the settings: overlapping inlets in a wall would bring water to the same
/// places.
std::optional<WallRefusal> why_not_beside(const InletSettings& inlet, std::span<const InletSettings> others,
                                          const Settings& settings);
/// For one drain in addition to those of the settings: two overlapping drains at a wall would both take, and both
/// measure, the same water. The drain itself must be valid, the others need not be.
std::optional<WallRefusal> why_not_beside(const DrainSettings& drain, std::span<const DrainSettings> others,
                                          const Settings& settings);
/// The mean speed of an inlet with a profile, which has `rows` rows, at a given time, m/s.
Real mean_speed(const InletSettings& inlet, Real rows, Real spacing, Real time);

class WallFlows {
 public:
  explicit WallFlows(const Settings& settings);
  /// Sets the sizes of the state of a run that begins.
  void resize(FlowState& state) const;

  bool any() const { return !openings_.empty(); }
  /// Determines the speeds of the water in the substep from its levels. `state` is that of the flow.
  void measure(MPI_Comm comm, const Particles& particles, const StepInfo& info, FlowState& state);
  /// The particles of this rank that leave through walls in the time dt, in ascending order. None leave through a drain
  /// without a flow through it: water at rest trembles and would be lost particle by particle. Through a drain with a
  /// prescribed flow, as many leave as correspond to the flow through it, those nearest to the wall.
  std::vector<LocalId> leaving(MPI_Comm comm, const Particles& particles, Real dt, FlowState& state) const;
  std::vector<WallOpening> walls(Real dt) const;

  /// The index of the first row of an inlet in FlowState::rows; -1 if it is not in a wall.
  std::ptrdiff_t first_row(std::size_t inlet) const { return first_row_[inlet]; }
  /// The speed of each row of an inlet, m/s; rows above its level are not included.
  const std::vector<Real>& speeds(std::size_t inlet) const { return openings_[of_inlet_[inlet]].speeds; }

 private:
  struct Opening {
    UprightWall wall;
    Real from = 0, to = 0;         // range along the axis in which its level is measured, m
    std::array<Real, 2> across{};  // range along the other horizontal axis, m
    std::array<Real, 2> seen{};    // the same, extended beyond walls at which it ends, as particles are close to them
    Real bottom = 0, top = 0;      // m
    const InletSettings* inlet = nullptr;
    const DrainSettings* drain = nullptr;
    std::vector<Real> speeds{};         // m/s: one for each row of an inlet; one for a drain, out of the box
    std::optional<OpenVolume> space{};  // where the level is measured, if there are solids in it
    Real area() const { return (to - from) * (across[1] - across[0]); }
    Real width() const { return across[1] - across[0]; }
    // Depth of the water in front of it.
    Real depth(Real level) const { return space ? std::min(level - bottom, space->depth(level)) : level - bottom; }
    // Cross-section of the water that flows through it, m².
    Real section(Real level) const {
      const Real high = std::min(level, top);
      return space ? (space->volume(high) - space->volume(bottom)) / (to - from) : (high - bottom) * width();
    }
  };
  struct Water {
    Real level, speed;  // m; m/s along the axis
  };
  // A particle that may leave through a drain with a flow, ordered by its remaining distance to the wall, m.
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
