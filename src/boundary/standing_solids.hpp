// Obstacles that do not move, for what is measured beside them: the open fraction of a horizontal disc, or of a part of
// the box, at each height. IEEE operations only: the same bits on any processor. Not collective.
#pragma once

#include <memory>
#include <vector>

#include "boundary/geometry/pose.hpp"
#include "boundary/geometry/shape.hpp"
#include "trevi/settings.hpp"

namespace trevi {

class StandingSolids {
 public:
  explicit StandingSolids(const Settings& settings);

  /// Whether the surface of one of them is within `reach`, m, of p, or p is inside one.
  bool are_near(const Vec3& p, Real reach) const;
  /// The open fraction of a cube with this edge around p; exact at surfaces that are parallel to its faces.
  Real open_share(const Vec3& p, Real edge) const;
  /// Whether one of them may extend into a box.
  bool may_reach_into(const Box& box) const;

 private:
  struct Solid {
    std::shared_ptr<const Shape> shape;
    Pose pose;
  };
  std::vector<Solid> solids_;
};

/// The open space between vertical planes, from the floor of the box of the water to its ceiling, in layers.
class OpenVolume {
 public:
  /// `part` extends from the floor to the ceiling of the box of the settings; it is not empty along any axis.
  OpenVolume(const Box& part, const StandingSolids& solids, const Settings& settings);

  /// The level to which this volume of water fills it, m. A layer of particles more than fits below a solid that closes
  /// all of it counts as if it stood higher there, and all that is too much if nothing is open above.
  Real level(Real volume) const;
  /// Its volume up to this level, m³.
  Real volume(Real level) const;
  /// Its volume up to this level over its area there, m; up to the highest open level below it if it is closed there.
  Real depth(Real level) const;

 private:
  std::size_t layer_of(Real level) const;
  std::size_t highest_open(std::size_t n) const;

  Real bottom_, height_;              // of the layers, m
  std::vector<Real> areas_, volume_;  // of each layer, m²; below each layer, and of all at the end, m³
};

/// The open part of the disc of a height gauge, with its weight, at each height: what is in the box and in no solid.
class OpenDisc {
 public:
  OpenDisc(const GaugeSettings& gauge, const StandingSolids& solids, const Settings& settings);
  /// At least a fifth of the part in the box.
  Real at(Real z) const;

 private:
  Real bottom_, step_;        // m
  Real in_box_;               // the part of the disc in the box
  std::vector<Real> shares_;  // open fractions of it at heights one step apart; empty if no solid is near
};

}  // namespace trevi
