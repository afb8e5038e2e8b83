// Solids as signed distances: the distance of a point from the surface, negative inside the solid, m. In the frame of
// the solid, with its centre at the origin. All distances are exact, so that their slope is 1: a ball with this radius
// around a point does not meet the surface. IEEE operations only: the same bits on any processor. Not collective.
#pragma once

#include <memory>
#include <optional>
#include <span>

#include "trevi/box.hpp"
#include "trevi/obstacle.hpp"

namespace trevi {

/// Unit vector along which the distance grows at a position, where distance(step) is the distance at a displacement
/// from this position. Differences are taken over a length on which curvature is negligible; at an edge the result is
/// the mean of the faces. `bounds` are those of the surface.
template <class Distance>
Vec3 slope_of(const Box& bounds, const Distance& distance) {
  const Real step = 1e-6 * (bounds.max - bounds.min).maxCoeff();
  Vec3 slope;
  for (int a = 0; a < 3; ++a) slope[a] = distance(step * Vec3::Unit(a)) - distance(-step * Vec3::Unit(a));
  const Real length = slope.norm();
  return length > 0 ? Vec3(slope / length) : Vec3::UnitZ();
}

class Shape {
 public:
  virtual ~Shape() = default;
  virtual Real distance(const Vec3& p) const = 0;
  /// The same for many positions.
  virtual void distances(std::span<const Vec3> p, std::span<Real> found) const {
    for (std::size_t k = 0; k < p.size(); ++k) found[k] = distance(p[k]);
  }
  /// The distance if its magnitude is below `reach`; otherwise the distance, or exactly `reach`.
  virtual Real distance_within(const Vec3& p, Real) const { return distance(p); }
  /// Bounds of the surface, not of the solid of a vessel, which has no bounds.
  virtual Box bounds() const = 0;
  /// Radius of a ball around the origin that contains bounds(), or at least the surface, m.
  virtual Real bounding_radius() const;
  /// Triangles on the surface, for pictures; `finest`, m, is the largest deviation of a chord.
  virtual TriangleMesh surface(Real finest) const = 0;
  /// Unit vector along which the distance grows.
  Vec3 normal(const Vec3& p) const;
  /// A length below which it has no sheets: from anywhere on the surface a straight path into the solid can go this far
  /// without coming out; 0 if that is not known.
  virtual Real min_thickness() const { return 0; }
  /// The coordinate along which the shape extends without end, so that its distance does not depend on it, if any.
  virtual std::optional<Eigen::Index> extruded_along() const { return std::nullopt; }
};

/// The shape of an obstacle; for a vessel that of its solid, which is all the rest of the world. `axis` and `rotate`
/// are not part of it: they belong to the pose of the frame.
std::unique_ptr<Shape> make_shape(const ObstacleSettings& obstacle);
bool has_same_shape(const ObstacleSettings& a, const ObstacleSettings& b);
/// Its bounds(), without building the tree of a mesh.
Box bounds_of(const ObstacleSettings& obstacle);
/// The projection onto the axes of revolution of its shape, in the frame of the shape.
Eigen::Matrix3d axes_of_revolution(const ObstacleSettings& obstacle);

}  // namespace trevi
