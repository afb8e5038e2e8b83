#include "boundary/geometry/mass_properties.hpp"

#include <numbers>

namespace trevi {

namespace {

using Matrix3 = Eigen::Matrix3d;

MassProperties about_origin(Real volume, const Vec3& moments) {
  MassProperties of{volume, Vec3::Zero(), Matrix3::Zero()};
  for (int a = 0; a < 3; ++a) of.inertia(a, a) = moments[a];
  return of;
}

MassProperties of_box(const Vec3& size) {
  const Vec3 square = size.cwiseProduct(size);
  const Real volume = size.x() * size.y() * size.z();
  return about_origin(volume,
                      volume / 12 * Vec3(square.y() + square.z(), square.x() + square.z(), square.x() + square.y()));
}

MassProperties of_cylinder(Real radius, Real height) {
  const Real volume = std::numbers::pi * radius * radius * height;
  const Real across = volume * (3 * radius * radius + height * height) / 12;
  return about_origin(volume, {across, across, volume * radius * radius / 2});
}

MassProperties of_sphere(Real radius) {
  const Real volume = 4 * std::numbers::pi / 3 * radius * radius * radius;
  return about_origin(volume, Vec3::Constant(volume * 2 / 5 * radius * radius));
}

// A cylinder between the two halves of a ball.
MassProperties of_capsule(Real radius, Real height) {
  const Real length = height - 2 * radius;
  MassProperties all = of_cylinder(radius, length);
  const MassProperties ball = of_sphere(radius);
  all.volume += ball.volume;
  all.inertia += ball.inertia;
  const Real shifted = ball.volume * (length * length / 4 + 3 * length * radius / 8);
  all.inertia(0, 0) += shifted;
  all.inertia(1, 1) += shifted;
  return all;
}

MassProperties of_torus(Real radius, Real tube) {
  const Real volume = 2 * std::numbers::pi * std::numbers::pi * radius * tube * tube;
  const Real across = volume * (radius * radius / 2 + 5 * tube * tube / 8);
  return about_origin(volume, {across, across, volume * (radius * radius + 3 * tube * tube / 4)});
}

Matrix3 parallel_axes(const Vec3& arm) { return arm.squaredNorm() * Matrix3::Identity() - arm * arm.transpose(); }

// The rest of a solid around the origin, whose centre is `below` the origin, after the space around the origin has been
// removed.
MassProperties without(const MassProperties& hull, Real below, const MassProperties& space) {
  MassProperties rest;
  rest.volume = hull.volume - space.volume;
  const Vec3 middle(0, 0, -below);
  rest.center = hull.volume / rest.volume * middle;
  rest.inertia = hull.inertia + hull.volume * parallel_axes(middle - rest.center) - space.inertia -
                 space.volume * parallel_axes(rest.center);
  return rest;
}

MassProperties of_basin(const ObstacleSettings& basin) {
  const Real wall = basin.wall;
  if (basin.size.isZero())
    return without(of_cylinder(basin.radius + wall, basin.height + wall), wall / 2,
                   of_cylinder(basin.radius, basin.height));
  const Real across = basin.extruded ? 0 : 2 * wall;  // no walls along y
  return without(of_box(basin.size + Vec3(2 * wall, across, wall)), wall / 2, of_box(basin.size));
}

// A tetrahedron with a corner at the origin has the moments det/120 Σ (x_i x_j over pairs of corners).
MassProperties of_mesh(const TriangleMesh& mesh) {
  const Vec3 origin = mesh.points.front();
  Real six_volumes = 0;
  Vec3 first = Vec3::Zero();
  Matrix3 second = Matrix3::Zero();
  for (const auto& triangle : mesh.triangles) {
    const Vec3 a = mesh.points[static_cast<std::size_t>(triangle[0])] - origin,
               b = mesh.points[static_cast<std::size_t>(triangle[1])] - origin,
               c = mesh.points[static_cast<std::size_t>(triangle[2])] - origin, sum = a + b + c;
    const Real det = a.x() * (b.y() * c.z() - b.z() * c.y()) + a.y() * (b.z() * c.x() - b.x() * c.z()) +
                     a.z() * (b.x() * c.y() - b.y() * c.x());
    six_volumes += det;
    first += det * sum;
    second += det * (a * a.transpose() + b * b.transpose() + c * c.transpose() + sum * sum.transpose());
  }
  MassProperties of;
  of.volume = six_volumes / 6;
  const Vec3 middle = first / (24 * of.volume);
  const Matrix3 about_middle = second / 120 - of.volume * middle * middle.transpose();
  of.center = origin + middle;
  of.inertia = (about_middle(0, 0) + about_middle(1, 1) + about_middle(2, 2)) * Matrix3::Identity() - about_middle;
  return of;
}

}  // namespace

MassProperties mass_properties(const ObstacleSettings& obstacle) {
  switch (obstacle.shape) {
    case ShapeKind::box:
      return of_box(obstacle.size);
    case ShapeKind::cylinder:
      return of_cylinder(obstacle.radius, obstacle.height);
    case ShapeKind::capsule:
      return of_capsule(obstacle.radius, obstacle.height);
    case ShapeKind::torus:
      return of_torus(obstacle.radius, obstacle.tube);
    case ShapeKind::basin:
      return of_basin(obstacle);
    case ShapeKind::mesh:
      return of_mesh(*obstacle.mesh);
    default:
      return of_sphere(obstacle.radius);
  }
}

}  // namespace trevi
