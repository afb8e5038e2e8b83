// Shapes against definitions; what a solid is to the density against brute quadrature. See test_paths.cpp for paths
// among them, and test_obstacle_meshes.cpp for meshes.
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <cmath>
#include <numbers>
#include <random>

#include "some_obstacles.hpp"

namespace trevi::test {
namespace {

// A distance to a set has slope 1 nearly everywhere and nowhere more; and one step along it ends on the surface.
TEST(Shape, DistanceIsThatToTheSurface) {
  std::mt19937 generator(1);
  for (const ObstacleSettings& settings : shapes()) {
    const auto shape = make_shape(settings);
    for (int k = 0; k < 2000; ++k) {
      const Vec3 p = random_point(generator, 1.2), q = random_point(generator, 1.2);
      EXPECT_LE(std::abs(shape->distance(p) - shape->distance(q)), (p - q).norm() * (1 + 1e-12));
      const Real d = shape->distance(p);
      if (d < 0.01) continue;
      EXPECT_NEAR(shape->distance(p - d * shape->normal(p)), 0, 1e-5);
    }
  }
}

TEST(Shape, VolumeIsThatOfTheFormula) {
  const Real pi = std::numbers::pi;
  const std::vector<Real> volumes = {pi * 0.125 * 4 / 3,
                                     0.7 * 0.4 * 0.9,
                                     pi * 0.16 * 0.8,
                                     pi * 0.09 * 0.5 + pi * 0.027 * 4 / 3,
                                     2 * pi * pi * 0.5 * 0.04,
                                     pi * (0.65 * 0.65 * 0.95 - 0.25 * 0.8),
                                     1.1 * 0.9 * 0.8 - 0.7 * 0.5 * 0.6};
  for (std::size_t s = 0; s < volumes.size(); ++s) {
    const auto shape = make_shape(shapes()[s]);
    const Box bounds = shape->bounds();
    constexpr int n = 80;
    const Vec3 step = (bounds.max - bounds.min) / n;
    int inside = 0;
    for (int k = 0; k < n * n * n; ++k) {
      const Vec3 p = bounds.min + step.cwiseProduct(Vec3(k % n + 0.5, k / n % n + 0.5, k / n / n + 0.5));
      inside += shape->distance(p) < 0 ? 1 : 0;
    }
    EXPECT_NEAR(inside * step.prod() / volumes[s], 1, 0.01) << s;
  }
}

// The surface that is drawn: on the surface, and its triangles enclose the volume (divergence theorem), so that they
// face outwards.
TEST(Shape, DrawnSurfaceIsTheSurface) {
  for (const ObstacleSettings& settings : shapes()) {
    const auto shape = make_shape(settings);
    const TriangleMesh mesh = shape->surface(0.001);
    Real volume = 0;
    for (const auto& t : mesh.triangles) {
      const auto corner = [&](std::size_t k) { return mesh.points[static_cast<std::size_t>(t[k])]; };
      volume += corner(0).dot(corner(1).cross(corner(2))) / 6;
    }
    for (const Vec3& p : mesh.points) EXPECT_NEAR(shape->distance(p), 0, 1e-9);
    EXPECT_GT(volume, 0.1);
  }
}

const Kernel& kernel() { return kernel_named("spiky"); }

/// The share of the kernel's ball around p that is solid, by 160³ points.
template <class Solid>
Real quadrature(const Vec3& p, const Solid& is_solid) {
  constexpr int n = 80;
  Real inside = 0, all = 0;
  for (int x = -n; x < n; ++x)
    for (int y = -n; y < n; ++y)
      for (int z = -n; z < n; ++z) {
        const Vec3 r = h / n * Vec3(x + 0.5, y + 0.5, z + 0.5);
        const Real w = kernel().value(r, h);
        all += w;
        if (w > 0 && is_solid(p + r)) inside += w;
      }
  return inside / all;
}

struct Solid {
  std::string name;
  ObstacleSettings settings;
  Vec3 from, to;  // a way of test points, in the frame of the body
};

std::vector<Solid> solids() {
  ObstacleSettings ball = sphere(2 * h), vessel = sphere(2 * h);
  vessel.inside = true;
  return {{"plane", box({2, 2, 2}), {0.1, 0.2, 1 + h}, {0.13, 0.22, 1}},
          {"edge", box({2, 2, 2}), {1 + 0.7 * h, 0.1, 1 + 0.7 * h}, {1, 0.1, 1}},
          {"ball", ball, {0.1, 0.2, 3 * h}, {0.1, 0.05, 1.97 * h}},
          {"vessel", vessel, {0.1, 0.2, 0.5 * h}, {0.1, 0.05, 1.9 * h}},
          {"plate", box({2, 2, 0.25 * spacing}), {0.1, 0.2, h}, {0.1, 0.1, 0.126 * spacing}},
          {"thick plate", box({2, 2, spacing}), {0.1, 0.2, h}, {0.1, 0.1, 0.51 * spacing}},
          {"rim", box({2, 2, 0.5 * spacing}), {1 + h, 0.2, 0.5 * h}, {1, 0.1, 0}}};
}

// The share that the map stands for: within 2 % of the whole ball, for all of them.
TEST(VolumeMap, IsTheVolumeShareOfBruteQuadrature) {
  const PlaneVolume plane(kernel(), h);
  for (const Solid& solid : solids()) {
    const auto shape = make_shape(solid.settings);
    const VolumeMap map(*shape, kernel(), h, {});
    Real worst = 0;
    constexpr int points = 7;
    for (int k = 0; k <= points; ++k) {
      const Vec3 p = solid.from + (solid.to - solid.from) * k / points;
      const Real exact = quadrature(p, [&](const Vec3& q) { return shape->distance(q) < 0; });
      worst = std::max(worst, std::abs(plane.fraction(map.at(p).distance) - exact));
    }
    RecordProperty(solid.name, std::to_string(worst));
    std::printf("%-12s %.4f\n", solid.name.c_str(), worst);
    EXPECT_LT(worst, 0.02) << solid.name;
  }
}

// At any angle, to a thousandth of h.
TEST(VolumeMap, PlaneIsItsDistance) {
  std::mt19937 generator(3);
  const auto shape = make_shape(box({4, 4, 4}));
  for (int turn = 0; turn < 20; ++turn) {
    ObstacleSettings settings = box({4, 4, 4});
    settings.rotate = 180 * random_point(generator, 1);
    const Pose pose = BodyMotion(settings).at(0);
    const VolumeMap map(*shape, kernel(), h, {});
    for (int k = 0; k < 20; ++k) {
      const Vec3 p = random_point(generator, 1);
      const Real d = 0.5 * h * (1 + p.z());
      const EquivalentPlane at = map.at(Vec3(p.x(), p.y(), 2 + d));
      EXPECT_NEAR(at.distance, d, 2e-3 * h);
      EXPECT_NEAR(at.gradient.z(), 1, 0.02);
    }
    EXPECT_NEAR(pose.turn.determinant(), 1, 1e-14);
  }
}

TEST(VolumeMap, GradientIsTheDerivative) {
  std::mt19937 generator(4);
  for (const Solid& solid : solids()) {
    const auto shape = make_shape(solid.settings);
    const VolumeMap map(*shape, kernel(), h, {});
    for (int k = 0; k < 300; ++k) {
      const Vec3 p = solid.to + random_point(generator, h);
      for (int a = 0; a < 3; ++a) {
        const Vec3 step = 1e-6 * h * Vec3::Unit(a);
        const Real slope = (map.at(p + step).distance - map.at(p - step).distance) / (2e-6 * h);
        EXPECT_NEAR(map.at(p).gradient[a], slope, 1e-4) << solid.name;
      }
    }
  }
}

// A solid on the floor, or cut by a wall, is felt as if it went on behind the wall.
TEST(VolumeMap, StandingSolidGoesOnBehindTheWalls) {
  ObstacleSettings settings = box({2, 2, 1});
  settings.center = {0, 0, 0.5};
  const Pose pose = BodyMotion(settings).at(0);
  const auto shape = make_shape(settings);
  const VolumeMap map(*shape, kernel(), h, Fixed{pose, {{-3, -3, 0}, {3, 3, 3}}});
  const EquivalentPlane low = map.at(pose.into_body({1 + h / 4, 0.1, 0.01})),
                        high = map.at(pose.into_body({1 + h / 4, 0.1, 0.5}));
  EXPECT_NEAR(low.distance, high.distance, 1e-6);
}

}  // namespace
}  // namespace trevi::test
