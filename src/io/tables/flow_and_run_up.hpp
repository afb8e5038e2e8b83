// Two gauges of the water: the flow through a rectangle, and the run-up of water on an obstacle. Not collective.
#pragma once

#include <optional>

#include "boundary/gauges.hpp"
#include "boundary/standing_solids.hpp"
#include "trevi/settings.hpp"

namespace trevi {

/// The flow through a rectangle, in the direction of its normal. Each particle is a cube of one spacing along the edges
/// of the rectangle; the part of it in the slab, two spacings thick, around the rectangle flows with its velocity. For
/// a lattice that moves as a whole, the flow is speed times area to rounding, wherever the rectangle is, if its edges
/// are along those of the lattice. In a periodic box it is at most as long as the box.
class RectangleFlow {
 public:
  RectangleFlow(const GaugeSettings& gauge, const Settings& settings);
  /// The contribution of a particle, m³/s.
  Real flow(const Vec3& p, const Vec3& v) const;

 private:
  // The volume of one of its images in the slab, from the centre, m³.
  Real volume(const Vec3& from) const;

  Vec3 normal_, level_, across_;
  Real half_[2];  // m, of the edges
  Real spacing_;
  SeenFrom seen_;
};

/// The run-up of the water on standing obstacles, in a strip from a place up the beach: the top of the highest particle
/// whose centre is no further from a surface than one spacing. Spray in the air does not count.
class RunUp {
 public:
  RunUp(const GaugeSettings& gauge, const Settings& settings);
  /// Whether the particle counts.
  bool touches(const Vec3& p) const;
  /// Height above the centre of the gauge, m.
  Real height(const Vec3& p) const { return p.z() + spacing_ / 2 - gauge_.center.z(); }

 private:
  GaugeSettings gauge_;
  Real spacing_;
  SeenFrom seen_;
  std::optional<StandingSolids> solids_;
};

}  // namespace trevi
