// The two kernels: closed forms, normalisation, gradients; and the lattice sums that calibrate the mass.
#include <gtest/gtest.h>

#include <cmath>

#include "fluid/density.hpp"
#include "fluid/kernels.hpp"

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

TEST(Kernels, SpikyIsTheClosedForm) {
  for (const Real r : {0.0, 0.03, 0.1, 0.19}) {
    const Real expected = 15 / (pi * std::pow(h, 6)) * std::pow(h - r, 3);
    EXPECT_NEAR(spiky(r * Vec3(1, -2, 2) / 3, h), expected, 1e-12 * expected);
  }
  EXPECT_EQ(spiky(Vec3(0, 0, 5 * h), h), 0);
}

TEST(Kernels, GradientsAreTheDerivativesOfKernelsOfUnitIntegral) {
  EXPECT_NEAR(sphere_integral([](Real r) { return spiky(Vec3(r, 0, 0), h); }), 1, 1e-7);
  constexpr Real d = 1e-6;
  for (const Kernel kernel : {Kernel::poly6, Kernel::spiky}) {
    for (const Vec3& r : {Vec3(0.05, 0.02, -0.1), Vec3(-0.15, 0, 0.01), Vec3(0.001, 0.002, 0)}) {
      const Vec3 gradient = density_gradient(kernel, r, h);
      for (int a = 0; a < 3; ++a) {
        const Vec3 step = d * Vec3::Unit(a);
        const Real rise = density_kernel(kernel, r + step, h) - density_kernel(kernel, r - step, h);
        EXPECT_NEAR(gradient[a], rise / (2 * d), 1e-3 * gradient.norm());
      }
      EXPECT_LT((gradient + density_gradient(kernel, -r, h)).norm(), 1e-12 * gradient.norm());
    }
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
    EXPECT_NEAR(mass * lattice_density_sum(Kernel::poly6, s, row.ratio * s), row.density, 0.5) << "h/s = " << row.ratio;
  }
}

TEST(Kernels, CalibratedMassPutsTheLatticeAtRest) {
  for (const Kernel kernel : {Kernel::poly6, Kernel::spiky}) {
    for (const Real ratio : {1.5, 2.0, 2.7, 3.0}) {
      const FluidSettings fluid{0.07, 850, ratio * 0.07, Mass::calibrated, kernel};
      Real sum = 0;
      for (int x = -4; x <= 4; ++x)
        for (int y = -4; y <= 4; ++y)
          for (int z = -4; z <= 4; ++z) sum += density_kernel(kernel, 0.07 * Vec3(x, y, z), fluid.kernel_radius);
      EXPECT_NEAR(particle_mass(fluid) * sum, 850, 1e-9 * 850);
    }
  }
  EXPECT_DOUBLE_EQ(particle_mass({0.1, 1000, 0.2, Mass::volume}), 1.0);
}

// A wave on a periodic lattice, swept once as the solver does (relaxation 1, all neighbours, gradients of Spiky), is
// left as 1 − mu times itself, and no wave has a larger mu. Along the diagonal k = π/s (a, a, a)/12.
TEST(Kernels, JacobiEigenvalueIsThatOfTheWorstWave) {
  constexpr Real s = 0.1, radius = 0.2, epsilon = 1;
  for (const Kernel kernel : {Kernel::poly6, Kernel::spiky}) {
    const Real volume = 1 / lattice_density_sum(kernel, s, radius);
    const Real largest = lattice_jacobi_eigenvalue(kernel, s, radius, volume, epsilon);
    Real found = 0;
    for (int a = 0; a <= 12; ++a) {
      for (int b = 0; b <= 12; ++b) {
        const Vec3 k = pi / s / 12 * Vec3(a, a, b);
        Vec3 shift = Vec3::Zero(), rise = Vec3::Zero();
        Real diagonal = epsilon;
        for (int x = -2; x <= 2; ++x)
          for (int y = -2; y <= 2; ++y)
            for (int z = -2; z <= 2; ++z) {
              const Vec3 r = s * Vec3(x, y, z), push = volume * spiky_gradient(r, radius);
              shift += push * std::sin(k.dot(r));
              if (r.norm() > 0) rise += volume * density_gradient(kernel, r, radius) * std::sin(k.dot(r));
              diagonal += push.squaredNorm();
            }
        EXPECT_LE(shift.dot(rise) / diagonal, largest * (1 + 1e-12));
        found = std::max(found, shift.dot(rise) / diagonal);
      }
    }
    EXPECT_GT(found, 0.9 * largest);
  }
  // Of a program of its own.
  const auto eigenvalue = [](Kernel kernel, Real ratio) {
    const Real volume = 1 / lattice_density_sum(kernel, s, ratio * s);
    return lattice_jacobi_eigenvalue(kernel, s, ratio * s, volume, epsilon);
  };
  EXPECT_NEAR(eigenvalue(Kernel::poly6, 1.5), 2.39008, 1e-5);
  EXPECT_NEAR(eigenvalue(Kernel::poly6, 2), 2.73362, 1e-5);
  EXPECT_NEAR(eigenvalue(Kernel::poly6, 3), 5.33028, 1e-5);
  EXPECT_NEAR(eigenvalue(Kernel::spiky, 2), 2.70368, 1e-5);
  EXPECT_NEAR(eigenvalue(Kernel::spiky, 3), 5.91147, 1e-5);
}

}  // namespace
}  // namespace trevi
