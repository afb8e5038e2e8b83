#include "boundary/geometry/shape.hpp"

#include <algorithm>
#include <cmath>

#include "boundary/geometry/mesh_shape.hpp"
#include "boundary/geometry/tessellation.hpp"

namespace trevi {

namespace {

std::unique_ptr<Shape> make_extruded(const ObstacleSettings& obstacle);

Real radial(const Vec3& p) { return std::sqrt(p.x() * p.x() + p.y() * p.y()); }

// The shape's own distance() is part of the loop over positions, without a call for each.
template <class Own>
class ShapeOf : public Shape {
 public:
  void distances(std::span<const Vec3> p, std::span<Real> found) const final {
    const Own& own = static_cast<const Own&>(*this);
    for (std::size_t k = 0; k < p.size(); ++k) found[k] = own.Own::distance(p[k]);
  }
};

class Sphere : public ShapeOf<Sphere> {
 public:
  explicit Sphere(Real radius) : radius_(radius) {}
  Real distance(const Vec3& p) const override { return p.norm() - radius_; }
  Box bounds() const override { return {Vec3::Constant(-radius_), Vec3::Constant(radius_)}; }
  Real bounding_radius() const override { return radius_; }
  Real min_thickness() const override { return 2 * radius_; }
  TriangleMesh surface(Real finest) const override { return turned(arc(radius_, 0, radius_, finest), finest); }

 private:
  Real radius_;
};

class Cuboid : public ShapeOf<Cuboid> {
 public:
  explicit Cuboid(const Vec3& size) : half_(size / 2) {}
  Real distance(const Vec3& p) const override {
    const Vec3 q = p.cwiseAbs() - half_;
    return q.cwiseMax(0.0).norm() + std::min(q.maxCoeff(), 0.0);
  }
  Box bounds() const override { return {-half_, half_}; }
  TriangleMesh surface(Real) const override { return cuboid_surface(half_); }
  Real min_thickness() const override { return 2 * half_.minCoeff(); }

 private:
  Vec3 half_;
};

class Cylinder : public ShapeOf<Cylinder> {
 public:
  Cylinder(Real radius, Real height) : radius_(radius), half_(height / 2) {}
  Real distance(const Vec3& p) const override {
    const Real side = radial(p) - radius_, end = std::abs(p.z()) - half_;
    const Real a = std::max(side, 0.0), b = std::max(end, 0.0);
    return std::sqrt(a * a + b * b) + std::min(std::max(side, end), 0.0);
  }
  Box bounds() const override { return {Vec3(-radius_, -radius_, -half_), Vec3(radius_, radius_, half_)}; }
  Real bounding_radius() const override { return std::sqrt(radius_ * radius_ + half_ * half_); }
  Real min_thickness() const override { return 2 * std::min(radius_, half_); }
  TriangleMesh surface(Real finest) const override {
    return turned({{0, -half_}, {radius_, -half_}, {radius_, half_}, {0, half_}}, finest);
  }

 private:
  Real radius_, half_;
};

class Capsule : public ShapeOf<Capsule> {
 public:
  Capsule(Real radius, Real height) : radius_(radius), straight_(height / 2 - radius) {}
  Real distance(const Vec3& p) const override {
    return Vec3(p.x(), p.y(), p.z() - std::clamp(p.z(), -straight_, straight_)).norm() - radius_;
  }
  Box bounds() const override {
    const Vec3 corner(radius_, radius_, straight_ + radius_);
    return {-corner, corner};
  }
  Real bounding_radius() const override { return straight_ + radius_; }
  Real min_thickness() const override { return 2 * radius_; }
  TriangleMesh surface(Real finest) const override { return turned(arc(radius_, straight_, radius_, finest), finest); }

 private:
  Real radius_, straight_;
};

class Torus : public ShapeOf<Torus> {
 public:
  Torus(Real radius, Real tube) : radius_(radius), tube_(tube) {}
  Real distance(const Vec3& p) const override {
    const Real off = radial(p) - radius_;
    return std::sqrt(off * off + p.z() * p.z()) - tube_;
  }
  Box bounds() const override {
    const Vec3 corner(radius_ + tube_, radius_ + tube_, tube_);
    return {-corner, corner};
  }
  Real bounding_radius() const override { return radius_ + tube_; }
  Real min_thickness() const override { return 2 * tube_; }
  TriangleMesh surface(Real finest) const override { return turned(ring(radius_, tube_, finest), finest); }

 private:
  Real radius_, tube_;
};

// For the union of two solids, which is a hull minus a cavity that is open at its top. The distance to both is exact
// outside; inside it is that to the nearer of the hull's surface and the cavity.
Real open_distance(Real hull, Real cavity, Real nearest_part) {
  return hull < 0 && cavity > 0 ? -std::min(-hull, cavity) : nearest_part;
}

// Upright, around a space of this radius and height whose centre is at the origin.
class RoundBasin : public ShapeOf<RoundBasin> {
 public:
  RoundBasin(Real radius, Real height, Real wall) : radius_(radius), half_(height / 2), wall_(wall) {}
  Real distance(const Vec3& p) const override {
    const Real r = radial(p), z = p.z(), outer = radius_ + wall_;
    const auto rectangle = [&](Real low_r, Real low_z, Real high_z) {
      const Real side = std::max(r - outer, low_r - r), end = std::max(z - high_z, low_z - z);
      const Real a = std::max(side, 0.0), b = std::max(end, 0.0);
      return std::sqrt(a * a + b * b) + std::min(std::max(side, end), 0.0);
    };
    const Real out_r = std::max(r - radius_, 0.0), out_z = std::max(-half_ - z, 0.0);
    constexpr Real no_edge = -1e300;
    return open_distance(
        rectangle(no_edge, -half_ - wall_, half_), std::sqrt(out_r * out_r + out_z * out_z),
        std::min(rectangle(no_edge, -half_ - wall_, -half_), rectangle(radius_, -half_ - wall_, half_)));
  }
  Box bounds() const override {
    const Real outer = radius_ + wall_;
    return {Vec3(-outer, -outer, -half_ - wall_), Vec3(outer, outer, half_)};
  }
  TriangleMesh surface(Real finest) const override {
    const Real outer = radius_ + wall_, foot = -half_ - wall_;
    return turned({{0, foot}, {outer, foot}, {outer, half_}, {radius_, half_}, {radius_, -half_}, {0, -half_}}, finest);
  }

 private:
  Real radius_, half_, wall_;
};

// The same around a box.
class BoxBasin : public ShapeOf<BoxBasin> {
 public:
  BoxBasin(const Vec3& size, Real wall) : half_(size / 2), wall_(wall) {}
  Real distance(const Vec3& p) const override {
    const auto to = [&](const Vec3& low, const Vec3& high) {
      const Vec3 q = (low - p).cwiseMax(p - high);
      return q.cwiseMax(0.0).norm() + std::min(q.maxCoeff(), 0.0);
    };
    const Box all = bounds();
    constexpr Real no_lid = 1e300;
    Real nearest = to(all.min, Vec3(all.max.x(), all.max.y(), -half_.z()));
    for (int a = 0; a < 2; ++a) {
      Vec3 low = all.min, high = all.max;
      low[a] = half_[a];
      nearest = std::min(nearest, to(low, high));
      low[a] = all.min[a];
      high[a] = -half_[a];
      nearest = std::min(nearest, to(low, high));
    }
    return open_distance(to(all.min, all.max), to(-half_, Vec3(half_.x(), half_.y(), no_lid)), nearest);
  }
  Box bounds() const override {
    const Vec3 outer(half_.x() + wall_, half_.y() + wall_, half_.z());
    return {Vec3(-outer.x(), -outer.y(), -half_.z() - wall_), outer};
  }
  TriangleMesh surface(Real) const override { return basin_surface(bounds(), half_); }

 private:
  Vec3 half_;
  Real wall_;
};

// A shape that extends infinitely along a coordinate: its distance is that in the section through the centre of a shape
// whose ends are so far away that they are never the nearest part of its surface.
class Extruded : public ShapeOf<Extruded> {
 public:
  /// `shown`: the same shape, with the length that pictures show.
  Extruded(std::unique_ptr<Shape> shape, std::unique_ptr<Shape> shown, Eigen::Index along)
      : shape_(std::move(shape)), shown_(std::move(shown)), along_(along) {}
  Real distance(const Vec3& p) const override {
    Vec3 in_cut = p;
    in_cut[along_] = 0;
    return shape_->distance(in_cut);
  }
  Box bounds() const override { return shown_->bounds(); }
  Real bounding_radius() const override { return INFINITY; }
  TriangleMesh surface(Real finest) const override { return shown_->surface(finest); }
  std::optional<Eigen::Index> extruded_along() const override { return along_; }

 private:
  std::unique_ptr<Shape> shape_, shown_;
  Eigen::Index along_;
};

// The complement of a shape.
class Outside : public ShapeOf<Outside> {
 public:
  explicit Outside(std::unique_ptr<Shape> shape) : shape_(std::move(shape)) {}
  Real distance(const Vec3& p) const override { return -shape_->distance(p); }
  Box bounds() const override { return shape_->bounds(); }
  TriangleMesh surface(Real finest) const override { return shape_->surface(finest); }
  std::optional<Eigen::Index> extruded_along() const override { return shape_->extruded_along(); }

 private:
  std::unique_ptr<Shape> shape_;
};

std::unique_ptr<Shape> make_solid(const ObstacleSettings& obstacle) {
  if (obstacle.extruded) return make_extruded(obstacle);
  switch (obstacle.shape) {
    case ShapeKind::box:
      return std::make_unique<Cuboid>(obstacle.size);
    case ShapeKind::cylinder:
      return std::make_unique<Cylinder>(obstacle.radius, obstacle.height);
    case ShapeKind::capsule:
      return std::make_unique<Capsule>(obstacle.radius, obstacle.height);
    case ShapeKind::torus:
      return std::make_unique<Torus>(obstacle.radius, obstacle.tube);
    case ShapeKind::basin:
      if (obstacle.size.isZero()) return std::make_unique<RoundBasin>(obstacle.radius, obstacle.height, obstacle.wall);
      return std::make_unique<BoxBasin>(obstacle.size, obstacle.wall);
    case ShapeKind::mesh:
      return std::make_unique<MeshShape>(obstacle.mesh, obstacle.inside);
    default:
      return std::make_unique<Sphere>(obstacle.radius);
  }
}

// A cylinder's frame has its axis along z.
std::unique_ptr<Shape> make_extruded(const ObstacleSettings& obstacle) {
  ObstacleSettings shown = obstacle;
  shown.extruded = false;
  ObstacleSettings endless = shown;
  const bool along_axis = obstacle.shape == ShapeKind::cylinder;
  constexpr Real far = 4;  // times the largest extent in the section
  if (along_axis) {
    endless.height = far * obstacle.radius;
  } else {
    endless.size.y() = far * std::max(obstacle.size.x(), obstacle.size.z()) + far * obstacle.wall;
  }
  return std::make_unique<Extruded>(make_solid(endless), make_solid(shown), along_axis ? 2 : 1);
}

}  // namespace

Real Shape::bounding_radius() const {
  const Box box = bounds();
  return box.min.cwiseAbs().cwiseMax(box.max.cwiseAbs()).norm();
}

Vec3 Shape::normal(const Vec3& p) const {
  return slope_of(bounds(), [&](const Vec3& step) { return distance(p + step); });
}

std::unique_ptr<Shape> make_shape(const ObstacleSettings& obstacle) {
  if (!obstacle.inside || obstacle.shape == ShapeKind::mesh) return make_solid(obstacle);
  return std::make_unique<Outside>(make_solid(obstacle));
}

// A mesh that is read twice is not recognised as the same one.
bool has_same_shape(const ObstacleSettings& a, const ObstacleSettings& b) {
  return a.shape == b.shape && a.size == b.size && a.radius == b.radius && a.tube == b.tube && a.height == b.height &&
         a.wall == b.wall && a.inside == b.inside && a.mesh == b.mesh && a.extruded == b.extruded;
}

Box bounds_of(const ObstacleSettings& obstacle) {
  if (obstacle.shape != ShapeKind::mesh) return make_shape(obstacle)->bounds();
  Box bounds{Vec3::Constant(INFINITY), Vec3::Constant(-INFINITY)};
  for (const auto& triangle : obstacle.mesh->triangles) {
    for (const auto corner : triangle) {
      const Vec3& p = obstacle.mesh->points[static_cast<std::size_t>(corner)];
      bounds = {bounds.min.cwiseMin(p), bounds.max.cwiseMax(p)};
    }
  }
  return bounds;
}

Eigen::Matrix3d axes_of_revolution(const ObstacleSettings& obstacle) {
  if (obstacle.shape == ShapeKind::sphere) return Eigen::Matrix3d::Identity();
  const ShapeKind kind = obstacle.shape;
  const bool round_about_z = kind == ShapeKind::cylinder || kind == ShapeKind::capsule || kind == ShapeKind::torus ||
                             (kind == ShapeKind::basin && obstacle.size.isZero());
  if (!round_about_z) return Eigen::Matrix3d::Zero();
  return Vec3::Unit(2) * Vec3::Unit(2).transpose();
}

}  // namespace trevi
