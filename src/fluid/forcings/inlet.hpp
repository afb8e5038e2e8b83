// Inlets: openings through which water enters (inputs/README.md, Inlets and drains). An inlet makes particles layer by
// layer, on a square lattice with the fluid's spacing across its opening: one layer whenever the water has moved by one
// spacing. Which rank makes them, and with which ids, is determined by InflowOutflow (solver/inflow_outflow.hpp).
// Collective: prepare() only.
#pragma once

#include <array>
#include <functional>

#include "fluid/forcings/fountain.hpp"

namespace trevi {

/// The places of a layer, centred in the opening. Places are numbered over the rectangle around the opening, row by
/// row.
class InletLattice {
 public:
  InletLattice(const InletSettings& settings, Real spacing);

  /// Number of places of the rectangle around an opening, before it is known whether they can be counted.
  static Real places_of(const InletSettings& settings, Real spacing);

  /// Of the rectangle around the opening.
  GlobalId places() const { return count_[0] * count_[1]; }
  /// Of that rectangle, from below.
  GlobalId rows() const { return count_[1]; }
  /// Whether a place is in the opening itself.
  bool is_open(GlobalId place) const;
  /// Number of open places: the particles of a layer.
  GlobalId open_places() const { return open_; }
  /// `ahead`: distance from the opening along the direction, m.
  Vec3 position(GlobalId place, Real ahead) const;
  const Vec3& direction() const { return settings_.direction; }
  /// Farthest that the opening reaches from its centre along each coordinate, m.
  Vec3 reach() const;

  /// A position as seen from the inlet: distance ahead of the opening and, in units of places, where across it.
  struct Seen {
    Real ahead, row, column;
  };
  Seen seen(const Vec3& p) const;
  /// The four places around this point, including all that are nearer than a spacing; −1 for one outside of the
  /// rectangle.
  std::array<GlobalId, 4> around(const Seen& seen) const;
  /// Whether a position at most one spacing ahead is in front of the opening.
  bool in_nozzle(const Vec3& p) const;

 private:
  InletSettings settings_;
  Real spacing_;
  GlobalId place(Real row, Real column) const;

  Vec3 level_, across_;  // directions of the columns of a row, and of the rows
  GlobalId count_[2];    // columns, rows
  GlobalId open_ = 0;
};

/// The speed of water that enters at this many m³/s, m/s; each particle counts as the volume spacing³.
Real speed_of_flow(Real flow, const InletLattice& lattice, Real spacing);

/// Sets the velocity of the particles within one spacing ahead of its opening as a fountain does, so that water in the
/// way does not immediately hold up the next layer: all layers of a jet have the same path, however many of them a
/// substep makes. Water that has a solid or a wall less than a spacing ahead of it is left alone.
class Inlet : public PumpedForcing {
 public:
  Inlet(const InletSettings& settings, std::unique_ptr<Pump> pump, Real spacing, std::uint64_t seed, int index);
  /// `covers`: whether something solid is between two positions, or at one of them.
  void place_in(const Vec3& gravity, std::function<bool(const Vec3&, const Vec3&)> covers) {
    let_fall(gravity);
    covers_ = std::move(covers);
  }

  const InletLattice& lattice() const { return lattice_; }
  bool recycles() const { return recycles_; }
  /// How far the water advances in the substep, m.
  Real path_length(const StepInfo& info) const;
  /// The speed without jitter while it flows, m/s; 0 if the pump is off.
  Real speed(const StepInfo& info) const;
  Vec3 velocity(Real speed, GlobalId id, const StepInfo& info) const { return jet(speed, id, info); }

 private:
  TimeSpan working(const StepInfo& info) const;
  bool reaches(const Vec3& p) const override;
  Real leaves_after(const Vec3& p, const Vec3& velocity) const override;

  InletLattice lattice_;
  bool recycles_;
  std::function<bool(const Vec3&, const Vec3&)> covers_;
  Real spacing_;
  Vec3 direction_;
};

/// Whether a drain removes what is at a position.
bool drains(const DrainSettings& drain, const Vec3& p);
/// A box that contains the whole drain; for a plane, all of space.
Box bounds_of(const DrainSettings& drain);

}  // namespace trevi
