// A shape of obstacle: a cone on a disc of `radius` at z = −height/2, with its tip at z = height/2. Everything else
// that an obstacle is (volume map, contacts, forces, pictures) follows from distance, bounds and surface.
#pragma once

#include <cmath>

#include "boundary/geometry/shape.hpp"
#include "boundary/geometry/tessellation.hpp"

namespace trevi {

class Cone : public Shape {
 public:
  Cone(Real radius, Real height) : radius_(radius), half_(height / 2) {}

  /// To the nearest point of the base or of the side, in the half plane through the axis.
  Real distance(const Vec3& p) const override {
    const Real r = std::sqrt(p.x() * p.x() + p.y() * p.y()), z = p.z() + half_, height = 2 * half_;
    const Real along =
        std::min(std::max((radius_ * (radius_ - r) + height * z) / (radius_ * radius_ + height * height), 0.0), 1.0);
    const Real side = length(r - radius_ * (1 - along), z - height * along);
    const Real base = length(std::max(r - radius_, 0.0), z);
    const bool inside = z > 0 && r < radius_ * (1 - z / height);
    return (inside ? -1 : 1) * std::min(side, base);
  }
  Box bounds() const override { return {Vec3(-radius_, -radius_, -half_), Vec3(radius_, radius_, half_)}; }
  TriangleMesh surface(Real finest) const override {
    return turned({{0, -half_}, {radius_, -half_}, {0, half_}}, finest);
  }

 private:
  static Real length(Real a, Real b) { return std::sqrt(a * a + b * b); }

  Real radius_, half_;
};

}  // namespace trevi
