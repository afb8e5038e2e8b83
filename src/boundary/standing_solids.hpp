// Obstacles that stay where they are, for what is measured beside them: how much of a level disc or of a part of the
// box is open at each height. IEEE operations only: the same bits on any processor. Not collective.
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

  /// Whether one of them has a surface no further from p than `reach`, m, or p in it.
  bool are_near(const Vec3& p, Real reach) const;
  /// How much of a cube of that edge around p is open; exact at faces along those of the cube.
  Real open_share(const Vec3& p, Real edge) const;
  /// Whether one of them may have a part in a box.
  bool may_reach_into(const Box& box) const;

 private:
  struct Solid {
    std::shared_ptr<const Shape> shape;
    Pose pose;
  };
  std::vector<Solid> solids_;
};

/// The open space between upright planes, from the floor of the box of the water up to its ceiling, by layers.
class OpenVolume {
 public:
  /// `part` reaches from the floor to the ceiling of the box of the settings; no axis of it is empty.
  OpenVolume(const Box& part, const StandingSolids& solids, const Settings& settings);

  /// Up to where so much water fills it, m.
  Real level(Real volume) const;
  /// Its volume over its area, both up to and at that level, m.
  Real depth(Real level) const;
  /// Of that at a level, m².
  Real area(Real level) const { return areas_[layer_of(level)]; }

 private:
  std::size_t layer_of(Real level) const;

  Real bottom_, height_;              // of the layers, m
  std::vector<Real> areas_, volume_;  // of each layer, m²; below each layer, and of all at the end, m³
};

/// Of the disc of a gauge of height, with its weight, at each height: what is in the box and in no solid.
class OpenDisc {
 public:
  OpenDisc(const GaugeSettings& gauge, const StandingSolids& solids, const Settings& settings);
  /// At least a fifth of what is in the box.
  Real at(Real z) const;

 private:
  Real bottom_, step_;        // m
  Real in_box_;               // of the disc
  std::vector<Real> shares_;  // of that, open at heights a step apart; none where no solid is near
};

}  // namespace trevi
