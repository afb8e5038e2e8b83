// Settings of obstacles of each shape, and random places.
#pragma once

#include <random>
#include <vector>

#include "boundary/obstacles/obstacles.hpp"

namespace trevi::test {

inline constexpr Real spacing = 0.1, h = 0.2;

inline ObstacleSettings of(ShapeKind shape, Real radius, Real height = 0) {
  ObstacleSettings settings;
  settings.shape = shape;
  settings.radius = radius;
  settings.height = height;
  return settings;
}
inline ObstacleSettings sphere(Real radius) { return of(ShapeKind::sphere, radius); }
inline ObstacleSettings cylinder(Real radius, Real height) { return of(ShapeKind::cylinder, radius, height); }
inline ObstacleSettings capsule(Real radius, Real height) { return of(ShapeKind::capsule, radius, height); }
inline ObstacleSettings box(const Vec3& size) {
  ObstacleSettings settings;
  settings.shape = ShapeKind::box;
  settings.size = size;
  return settings;
}
inline ObstacleSettings torus(Real radius, Real tube) {
  ObstacleSettings settings = of(ShapeKind::torus, radius);
  settings.tube = tube;
  return settings;
}
inline ObstacleSettings basin(ObstacleSettings space, Real wall) {
  space.shape = ShapeKind::basin;
  space.wall = wall;
  return space;
}
inline std::vector<ObstacleSettings> shapes() {
  return {sphere(0.5),
          box({0.7, 0.4, 0.9}),
          cylinder(0.4, 0.8),
          capsule(0.3, 1.1),
          torus(0.5, 0.2),
          basin(cylinder(0.5, 0.8), 0.15),
          basin(box({0.7, 0.5, 0.6}), 0.2)};
}

inline Vec3 random_point(std::mt19937& generator, Real reach) {
  std::uniform_real_distribution<Real> number(-reach, reach);
  return {number(generator), number(generator), number(generator)};  // in this order, by the braces
}

}  // namespace trevi::test
