// Two gauges of the water: the flow through a rectangle, and how high water runs up an obstacle. Not collective.
#pragma once

#include <optional>

#include "boundary/gauges.hpp"
#include "boundary/standing_solids.hpp"
#include "trevi/settings.hpp"

namespace trevi {

/// What flows through a rectangle, to the side of its normal. Each particle is a cube of one spacing along the edges of
/// the rectangle; what of it is in the slab two spacings thick around the rectangle flows with its velocity. A lattice
/// that moves as a whole flows by speed times area to rounding, wherever the rectangle stands, if its edges are along
/// those of the lattice. Where the box repeats it is at most as long as that.
class RectangleFlow {
 public:
  RectangleFlow(const GaugeSettings& gauge, const Settings& settings);
  /// What a particle adds, m³/s.
  Real flow(const Vec3& p, const Vec3& v) const;

 private:
  // Of an image of it, from the centre, m³.
  Real volume(const Vec3& from) const;

  Vec3 normal_, level_, across_;
  Real half_[2];  // m, of the edges
  Real spacing_;
  SeenFrom seen_;
};

/// How high the water is on obstacles that stand, in a strip from a place up the beach: the top of the highest particle
/// whose centre is no further from a surface than a spacing. Spray in the air does not count.
class RunUp {
 public:
  RunUp(const GaugeSettings& gauge, const Settings& settings);
  /// Whether the particle counts.
  bool touches(const Vec3& p) const;
  /// Above the centre of the gauge, m.
  Real height(const Vec3& p) const { return p.z() + spacing_ / 2 - gauge_.center.z(); }

 private:
  GaugeSettings gauge_;
  Real spacing_;
  SeenFrom seen_;
  std::optional<StandingSolids> solids_;
};

}  // namespace trevi
