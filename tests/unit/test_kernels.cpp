// The two kernels: closed forms, normalisation, gradients; and the lattice sums that calibrate the mass.
#include <gtest/gtest.h>

#include <cmath>

#include "trevi/fluid/density.hpp"
#include "trevi/fluid/kernels.hpp"

namespace trevi {
namespace {

constexpr Real h = 0.2;
constexpr Real pi = std::numbers::pi;

/// ∫ f(r) 4 π r² dr over the sphere of radius h, midpoint rule.
template <class F>
Real sphere_integral(F&& f) {
  constexpr int parts = 20000;
  Real sum = 0;
  for (int k = 0; k < parts; ++k) {
    const Real r = h * (k + 0.5) / parts;
    sum += f(r) * 4 * pi * r * r * h / parts;
  }
  return sum;
}

TEST(Kernels, Poly6IsTheClosedForm) {
  for (const Real r : {0.0, 0.03, 0.1, 0.19}) {
    const Real expected = 315 / (64 * pi * std::pow(h, 9)) * std::pow(h * h - r * r, 3);
    EXPECT_NEAR(poly6(Vec3(0, r, 0), h), expected, 1e-12 * expected);
    EXPECT_NEAR(poly6(r * Vec3(1, -2, 2) / 3, h), expected, 1e-12 * expected);
  }
  EXPECT_EQ(poly6(Vec3(h, 0, 0), h), 0);
  EXPECT_EQ(poly6(Vec3(0, 0, 5 * h), h), 0);
}

TEST(Kernels, Poly6IntegratesToOne) {
  EXPECT_NEAR(sphere_integral([](Real r) { return poly6(Vec3(r, 0, 0), h); }), 1, 1e-7);
}

/// Spiky itself, whose gradient the method uses: 15/(π h⁶) (h − r)³.
Real spiky(const Vec3& r) { return 15 / (pi * std::pow(h, 6)) * std::pow(h - r.norm(), 3); }

TEST(Kernels, SpikyGradientIsTheDerivativeOfAKernelOfUnitIntegral) {
  EXPECT_NEAR(sphere_integral([](Real r) { return spiky(Vec3(r, 0, 0)); }), 1, 1e-7);
  constexpr Real d = 1e-6;
  for (const Vec3& r : {Vec3(0.05, 0.02, -0.1), Vec3(-0.15, 0, 0.01), Vec3(0.001, 0.002, 0)}) {
    const Vec3 gradient = spiky_gradient(r, h);
    for (int a = 0; a < 3; ++a) {
      const Vec3 step = d * Vec3::Unit(a);
      EXPECT_NEAR(gradient[a], (spiky(r + step) - spiky(r - step)) / (2 * d), 1e-3 * gradient.norm());
    }
    EXPECT_LT((gradient + spiky_gradient(-r, h)).norm(), 1e-12 * gradient.norm());
  }
}

TEST(Kernels, SpikyGradientVanishesWhereItHasNoDirection) {
  EXPECT_EQ(spiky_gradient(Vec3::Zero(), h), Vec3::Zero());
  EXPECT_EQ(spiky_gradient(Vec3(0, h, 0), h), Vec3::Zero());
  EXPECT_EQ(spiky_gradient(Vec3(0, 3 * h, h), h), Vec3::Zero());
}

// Density of a cubic lattice with m = rho0 s³ and its neighbours, for the usual h/s: known to the digits given.
TEST(Kernels, LatticeTable) {
  constexpr Real s = 0.1, mass = 1000 * s * s * s;
  struct Row {
    Real ratio;
    int neighbours;
    Real density;
  };
  for (const Row& row : {Row{1.5, 18, 949}, Row{1.8, 26, 983}, Row{2.0, 26, 1010}, Row{2.4, 56, 1001},
                         Row{2.5, 80, 995}, Row{3.0, 92, 1002}}) {
    EXPECT_EQ(lattice_neighbours(s, row.ratio * s), row.neighbours) << "h/s = " << row.ratio;
    EXPECT_NEAR(mass * lattice_poly6_sum(s, row.ratio * s), row.density, 0.5) << "h/s = " << row.ratio;
  }
}

TEST(Kernels, CalibratedMassPutsTheLatticeAtRest) {
  for (const Real ratio : {1.5, 2.0, 2.7, 3.0}) {
    const FluidSettings fluid{0.07, 850, ratio * 0.07, Mass::calibrated};
    Real rho = 0;
    for (int x = -4; x <= 4; ++x)
      for (int y = -4; y <= 4; ++y)
        for (int z = -4; z <= 4; ++z) rho += particle_mass(fluid) * poly6(0.07 * Vec3(x, y, z), fluid.kernel_radius);
    EXPECT_NEAR(rho, 850, 1e-9 * 850);
  }
  EXPECT_DOUBLE_EQ(particle_mass({0.1, 1000, 0.2, Mass::volume}), 1.0);
}

}  // namespace
}  // namespace trevi
