// The walls' contribution to the density against brute-force sums over the lattice that would go on behind them; its
// gradient against central differences; and how it falls with the distance.
#include "boundary/wall_density.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "kernels/kernels.hpp"

namespace trevi {
namespace {

constexpr Real spacing = 0.1;

struct Case {
  Kernel kernel;
  Real ratio;  // h in spacings
  Real h() const { return ratio * spacing; }
};

std::vector<Case> cases(int dimensions = 3) {
  std::vector<Case> all;
  for (const Kernel& kernel : all_kernels(dimensions))
    for (const Real ratio : {1.5, 2.0, 2.5, 3.0, 4.0}) all.push_back({kernel, ratio});
  return all;
}

std::string name_of(const Case& c) {
  return std::string(c.kernel.name) + ", h = " + std::to_string(c.ratio) + " spacings";
}

/// A box of so many spacings, its corner not the origin.
Box box_of(int x, int y, int z) {
  const Vec3 corner(-0.3, 0.2, 1.7);
  return {corner, corner + spacing * Vec3(x, y, z)};
}

AnalyticWallDensity walls(const Case& c, const Box& box) {
  return {box, c.kernel, spacing, c.h(), WallSlope::of_velocities};
}

/// Of the particle at lattice place (x, y, z) of `count` in each direction: the share of the places that are not in the
/// box.
Real missing_share(const Case& c, const std::array<int, 3>& count, const std::array<int, 3>& place) {
  constexpr int reach = 5;
  const int across = c.kernel.dimensions == 2 ? 0 : reach;
  Real missing = 0, all = 0;
  for (int x = -reach; x <= reach; ++x)
    for (int y = -across; y <= across; ++y)
      for (int z = -reach; z <= reach; ++z) {
        const Real w = c.kernel.value(spacing * Vec3(x, y, z), c.h());
        const std::array<int, 3> there = {place[0] + x, place[1] + y, place[2] + z};
        bool inside = true;
        for (std::size_t a = 0; a < 3; ++a) inside = inside && there[a] >= 0 && there[a] < count[a];
        all += w;
        if (!inside) missing += w;
      }
  return missing / all;
}

void expect_start_at_rest(const Case& c, const std::array<int, 3>& count) {
  const Box box = box_of(count[0], count[1], count[2]);
  const AnalyticWallDensity w = walls(c, box);
  Real worst = 0;
  for (int x = 0; x < count[0]; ++x)
    for (int y = 0; y < count[1]; ++y)
      for (int z = 0; z < count[2]; ++z) {
        const Vec3 p = box.min + spacing * (Vec3(x, y, z) + Vec3::Constant(0.5));
        worst = std::max(worst, std::abs(w.at(p).density - missing_share(c, count, {x, y, z})));
      }
  EXPECT_LT(worst, 1e-12) << count[0] << " x " << count[1] << " x " << count[2];
}

TEST(WallDensity, StartIsAtRestAtWallsEdgesAndCorners) {
  for (const Case& c : cases()) {
    SCOPED_TRACE(name_of(c));
    expect_start_at_rest(c, {11, 10, 9});
  }
}

// Narrower than the reach of two walls, in one direction, two or all three.
TEST(WallDensity, StartIsAtRestInNarrowBoxes) {
  for (const Case& c : cases()) {
    SCOPED_TRACE(name_of(c));
    for (const int width : {2, 3, 4, 5}) {
      expect_start_at_rest(c, {width, 10, 10});
      expect_start_at_rest(c, {10, width, 5});
      expect_start_at_rest(c, {10, 3, width});
      expect_start_at_rest(c, {width, width, width});
    }
  }
}

// A layer has no walls along y: they are far away.
TEST(WallDensity, StartIsAtRestInTwoDimensions) {
  for (const Case& c : cases(2)) {
    SCOPED_TRACE(name_of(c));
    for (const auto& [x, z] : {std::pair{11, 9}, {3, 10}, {10, 2}, {3, 4}}) {
      Box box = box_of(x, 1, z);
      box.min.y() -= 100;
      box.max.y() += 100;
      const AnalyticWallDensity w = walls(c, box);
      Real worst = 0;
      for (int i = 0; i < x; ++i)
        for (int k = 0; k < z; ++k) {
          const Vec3 p = box.min + spacing * Vec3(i + 0.5, 0, k + 0.5) + Vec3(0, 100 + spacing / 2, 0);
          worst = std::max(worst, std::abs(w.at(p).density - missing_share(c, {x, 1, z}, {i, 0, k})));
          EXPECT_EQ(w.at(p).gradient.y(), 0);
        }
      EXPECT_LT(worst, 1e-12) << x << " x " << z;
    }
  }
}

/// Relative to the gradient, or to a thousandth of 1/spacing, where there is next to none.
Real gradient_error(const AnalyticWallDensity& w, const Vec3& p) {
  constexpr Real step = 1e-6 * spacing;
  const Vec3 gradient = w.at(p).gradient;
  Vec3 difference;
  for (int a = 0; a < 3; ++a) {
    const Vec3 d = step * Vec3::Unit(a);
    difference[a] = (w.at(p + d).density - w.at(p - d).density) / (2 * step);
  }
  return (difference - gradient).norm() / std::max(gradient.norm(), 1e-3 / spacing);
}

TEST(WallDensity, GradientIsTheDerivative) {
  std::mt19937_64 random(11);
  std::uniform_real_distribution<Real> number(1e-4, 1 - 1e-4);
  // Wide, a slit, a channel and a box all of whose walls are near.
  const std::array<int, 3> shapes[] = {{10, 9, 8}, {2, 9, 9}, {3, 9, 2}, {4, 3, 5}, {5, 5, 5}};
  for (const Case& c : cases()) {
    SCOPED_TRACE(name_of(c));
    for (const auto& [x, y, z] : shapes) {
      const Box box = box_of(x, y, z);
      const AnalyticWallDensity w = walls(c, box);
      Real worst = 0;
      int near = 0;
      for (int k = 0; k < 2000; ++k) {
        const Vec3 p = box.min + Vec3(number(random), number(random), number(random)).cwiseProduct(box.max - box.min);
        worst = std::max(worst, gradient_error(w, p));
        near += w.at(p).gradient.cwiseAbs().minCoeff() > 0 ? 1 : 0;
      }
      EXPECT_LT(worst, 1e-5) << x << " x " << y << " x " << z;
      EXPECT_GT(near, 30) << "corners are not looked at";
    }
  }
}

// In front of the middle of each wall; zero from the first layer on that misses nothing.
TEST(WallDensity, ShareFallsWithTheDistanceOfAPlane) {
  const Box box = box_of(20, 20, 20);
  const Vec3 middle = (box.min + box.max) / 2;
  for (const Case& c : cases()) {
    SCOPED_TRACE(name_of(c));
    const AnalyticWallDensity w = walls(c, box);
    const Real reach = c.h() + spacing / 2;
    for (int axis = 0; axis < 3; ++axis) {
      for (const Real side : {-1.0, 1.0}) {
        Real last = 1;
        for (Real d = 0; d < reach + spacing; d += 0.01 * spacing) {
          Vec3 p = middle;
          p[axis] = side < 0 ? box.min[axis] + d : box.max[axis] - d;
          const BoundaryDensity share = w.at(p);
          EXPECT_GE(share.density, 0);
          EXPECT_TRUE(share.density < last || (share.density == 0 && last == 0)) << "at " << d;
          EXPECT_GE(share.gradient[axis] * side, 0) << "a wall that pulls";
          EXPECT_TRUE(d <= reach || share.density == 0) << "at " << d;
          last = share.density;
        }
        EXPECT_EQ(last, 0);
      }
    }
  }
}

}  // namespace
}  // namespace trevi
