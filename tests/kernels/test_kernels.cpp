// The kernels: closed forms, normalisation, gradients; and the lattice sums that calibrate the mass. A new kernel has a
// row here, and is in all the tests below.
#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <map>
#include <numbers>

#include "fluid/constraint/density.hpp"
#include "kernels/kernels.hpp"
#include "trevi/error.hpp"

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

/// A kernel as it is in the literature, and eigenvalues of Jacobi sweeps of a program of its own (spacing 0.1 m,
/// epsilon 1, the mass calibrated, gradients as they follow from the density).
struct Row {
  std::string name, gradient_name;
  std::function<Real(Real)> value, slope;  // W and dW/dr at r, both 0 from h on
  std::map<Real, Real> eigenvalues;        // by h/spacing
};

const std::vector<Row>& rows() {
  static const std::vector<Row> all = {
      {"poly6",
       "spiky",
       [](Real r) { return 315 / (64 * pi * std::pow(h, 9)) * std::pow(h * h - r * r, 3); },
       [](Real r) { return -945 / (32 * pi * std::pow(h, 9)) * r * std::pow(h * h - r * r, 2); },
       {{1.5, 2.39008}, {2, 2.73362}, {3, 5.33028}}},
      {"spiky",
       "spiky",
       [](Real r) { return 15 / (pi * std::pow(h, 6)) * std::pow(h - r, 3); },
       [](Real r) { return -45 / (pi * std::pow(h, 6)) * std::pow(h - r, 2); },
       {{2, 2.70368}, {3, 5.91147}}},
      {"wendland_c2",
       "wendland_c2",
       [](Real r) { return 21 / (2 * pi * std::pow(h, 3)) * std::pow(1 - r / h, 4) * (1 + 4 * r / h); },
       [](Real r) { return -210 / (pi * std::pow(h, 5)) * r * std::pow(1 - r / h, 3); },
       {{1.5, 1.95124}, {2, 2.54784}, {3, 5.64125}}},
  };
  return all;
}

TEST(Kernels, EachOfTheListHasARow) {
  std::vector<std::string> names;
  for (const Row& row : rows()) names.push_back(row.name);
  EXPECT_EQ(names, kernel_names());
  EXPECT_THROW(kernel_named("gauss"), InputError);
}

TEST(Kernels, AreTheClosedForms) {
  for (const Row& row : rows()) {
    SCOPED_TRACE(row.name);
    const Kernel& kernel = kernel_named(row.name);
    for (const Real r : {0.0, 0.03, 0.1, 0.19}) {
      EXPECT_NEAR(kernel.value(Vec3(0, r, 0), h), row.value(r), 1e-12 * row.value(r));
      EXPECT_NEAR(kernel.value(r * Vec3(1, -2, 2) / 3, h), row.value(r), 1e-12 * row.value(r));
      const Vec3 direction = Vec3(1, -2, 2) / 3, gradient = r > 0 ? Vec3(row.slope(r) * direction) : Vec3::Zero();
      EXPECT_LE((kernel.gradient(r * direction, h) - gradient).norm(), 1e-12 * gradient.norm());
    }
    EXPECT_NEAR(kernel.factor(h), row.value(0), 1e-12 * row.value(0));
    for (const Vec3& outside : {Vec3(h, 0, 0), Vec3(0, 0, 5 * h), Vec3(0, 3 * h, h)}) {
      EXPECT_EQ(kernel.value(outside, h), 0);
      EXPECT_EQ(kernel.gradient(outside, h), Vec3::Zero());
    }
  }
}

TEST(Kernels, HaveUnitIntegralsAndTheGradientsAreTheirDerivatives) {
  constexpr Real d = 1e-6;
  for (const Kernel& kernel : all_kernels()) {
    SCOPED_TRACE(kernel.name);
    EXPECT_NEAR(sphere_integral([&](Real r) { return kernel.value(Vec3(r, 0, 0), h); }), 1, 1e-7);
    for (const Vec3& r : {Vec3(0.05, 0.02, -0.1), Vec3(-0.15, 0, 0.01), Vec3(0.001, 0.002, 0)}) {
      const Vec3 gradient = kernel.gradient(r, h);
      for (int a = 0; a < 3; ++a) {
        const Vec3 step = d * Vec3::Unit(a);
        const Real rise = kernel.value(r + step, h) - kernel.value(r - step, h);
        EXPECT_NEAR(gradient[a], rise / (2 * d), 1e-3 * gradient.norm());
      }
      EXPECT_LT((gradient + kernel.gradient(-r, h)).norm(), 1e-12 * gradient.norm());
    }
  }
}

TEST(Kernels, TheSteepestGradientIsTheLargestThereIs) {
  for (const Kernel& kernel : all_kernels()) {
    SCOPED_TRACE(kernel.name);
    Real largest = 0;
    for (Real r = 1e-6 * h; r < h; r += 1e-4 * h) largest = std::max(largest, kernel.gradient(Vec3(0, 0, r), h).norm());
    EXPECT_LE(largest, kernel.steepest(h) * (1 + 1e-12));
    EXPECT_GT(largest, kernel.steepest(h) * (1 - 1e-5));
  }
}

TEST(Kernels, TheGradientFollowsFromTheDensity) {
  for (const Row& row : rows()) {
    const Kernels kernels = kernels_of({.density_kernel = row.name});
    EXPECT_EQ(kernels.density.name, row.name);
    EXPECT_EQ(kernels.gradient.name, row.gradient_name);
    EXPECT_EQ(kernels_of({.density_kernel = row.name, .gradient_kernel = "poly6"}).gradient.name, "poly6");
  }
}

// Density of a cubic lattice with m = rho0 s³ and its neighbours, for the usual h/s: known to the digits given.
TEST(Kernels, LatticeTable) {
  constexpr Real s = 0.1, mass = 1000 * s * s * s;
  struct Lattice {
    Real ratio;
    int neighbours;
    Real density;
  };
  for (const Lattice& row :
       {Lattice{1.5, 18, 949}, {1.8, 26, 983}, {2.0, 26, 1010}, {2.4, 56, 1001}, {2.5, 80, 995}, {3.0, 92, 1002}}) {
    EXPECT_EQ(lattice_neighbours(s, row.ratio * s), row.neighbours) << "h/s = " << row.ratio;
    EXPECT_NEAR(mass * lattice_density_sum(kernel_named("poly6"), s, row.ratio * s), row.density, 0.5)
        << "h/s = " << row.ratio;
  }
}

TEST(Kernels, CalibratedMassPutsTheLatticeAtRest) {
  for (const Kernel& kernel : all_kernels()) {
    for (const Real ratio : {1.5, 2.0, 2.7, 3.0}) {
      const FluidSettings fluid{0.07, 850, ratio * 0.07, Mass::calibrated, std::string(kernel.name)};
      Real sum = 0;
      for (int x = -4; x <= 4; ++x)
        for (int y = -4; y <= 4; ++y)
          for (int z = -4; z <= 4; ++z) sum += kernel.value(0.07 * Vec3(x, y, z), fluid.kernel_radius);
      EXPECT_NEAR(particle_mass(fluid) * sum, 850, 1e-9 * 850);
    }
  }
  EXPECT_DOUBLE_EQ(particle_mass({0.1, 1000, 0.2, Mass::volume}), 1.0);
}

// ---- in the plane -------------------------------------------------------------------------------------------------

/// Density kernels and gradients of the literature in two dimensions.
const std::vector<std::pair<std::string, std::function<Real(Real)>>>& rows_in_plane() {
  static const std::vector<std::pair<std::string, std::function<Real(Real)>>> all = {
      {"poly6", [](Real r) { return 4 / (pi * std::pow(h, 8)) * std::pow(h * h - r * r, 3); }},
      {"spiky", [](Real r) { return 10 / (pi * std::pow(h, 5)) * std::pow(h - r, 3); }},
      {"wendland_c2", [](Real r) { return 7 / (pi * h * h) * std::pow(1 - r / h, 4) * (1 + 4 * r / h); }}};
  return all;
}

TEST(KernelsInThePlane, HaveUnitIntegralsAndTheGradientsAreTheirDerivatives) {
  constexpr int parts = 20000;
  std::vector<std::string> names;
  for (const auto& [name, value] : rows_in_plane()) {
    SCOPED_TRACE(name);
    names.push_back(name);
    const Kernel& kernel = kernel_named(name, 2);
    EXPECT_EQ(kernel.dimensions, 2);
    EXPECT_EQ(kernel.index, kernel_named(name).index);
    Real sum = 0;
    for (int k = 0; k < parts; ++k) {
      const Real r = h * (k + 0.5) / parts;
      sum += kernel.value(Vec3(0, 0, r), h) * 2 * pi * r * h / parts;
    }
    EXPECT_NEAR(sum, 1, 1e-7);
    for (const Real r : {0.01, 0.06, 0.13, 0.19}) {
      constexpr Real d = 1e-6;
      EXPECT_NEAR(kernel.value(Vec3(0.6 * r, 0, 0.8 * r), h), value(r), 1e-12 * value(0));
      EXPECT_NEAR(kernel.gradient(Vec3(0, 0, r), h).z(), (value(r + d) - value(r - d)) / (2 * d), 1e-5 * value(0) / h);
    }
    EXPECT_NEAR(kernel.factor(h), value(0), 1e-12 * value(0));
    EXPECT_NEAR(kernel.slope_factor(h) / kernel.factor(h),
                kernel_named(name).slope_factor(h) / kernel_named(name).factor(h), 1e-9);
  }
  EXPECT_EQ(names, kernel_names());
}

TEST(KernelsInThePlane, LatticeIsSquareAndAtRest) {
  EXPECT_EQ(lattice_neighbours({0.1, 2}, 0.2), 8);
  EXPECT_EQ(lattice_neighbours({0.1, 2}, 0.25), 20);
  for (const Real ratio : {1.5, 2.0, 2.7, 4.0}) {
    FluidSettings fluid{0.07, 850, ratio * 0.07, Mass::calibrated, "wendland_c2"};
    fluid.dimensions = 2;
    Real sum = 0, moment = 0;
    for (int x = -5; x <= 5; ++x)
      for (int z = -5; z <= 5; ++z) {
        const Vec3 r = 0.07 * Vec3(x, 0, z);
        sum += kernels_of(fluid).density.value(r, fluid.kernel_radius);
        moment +=
            std::pow(std::max(1 - r.squaredNorm() / std::pow(fluid.kernel_radius, 2), 0.0), 2) * r.z() * r.z() / 2;
      }
    EXPECT_NEAR(particle_mass(fluid) * sum, 850, 1e-9 * 850);
    EXPECT_NEAR(lattice_laplacian_moment(lattice_of(fluid), fluid.kernel_radius), moment, 1e-12 * moment);
    // Water of spacing³ weighs 850 spacing³, and a kernel sum has as much in a layer a metre thick.
    fluid.mass = Mass::volume;
    EXPECT_DOUBLE_EQ(particle_mass(fluid) * 0.07, water_mass(fluid));
  }
}

/// The largest mu of the waves k = π/s (a, a, b)/12 by its definition.
Real largest_of_some_waves(const Kernels& kernels, Real s, Real radius, Real volume, Real epsilon) {
  Real found = 0;
  for (int a = 0; a <= 12; ++a) {
    for (int b = 0; b <= 12; ++b) {
      const Vec3 k = pi / s / 12 * Vec3(a, a, b);
      Vec3 shift = Vec3::Zero(), rise = Vec3::Zero();
      Real diagonal = epsilon;
      for (int x = -2; x <= 2; ++x)
        for (int y = -2; y <= 2; ++y)
          for (int z = -2; z <= 2; ++z) {
            const Vec3 r = s * Vec3(x, y, z), push = volume * kernels.gradient.gradient(r, radius);
            shift += push * std::sin(k.dot(r));
            if (r.norm() > 0) rise += volume * kernels.density.gradient(r, radius) * std::sin(k.dot(r));
            diagonal += push.squaredNorm();
          }
      found = std::max(found, shift.dot(rise) / diagonal);
    }
  }
  return found;
}

// A wave on a periodic lattice, swept once as the solver does (relaxation 1, all neighbours), is left as 1 − mu times
// itself, and no wave has a larger mu.
TEST(Kernels, JacobiEigenvalueIsThatOfTheWorstWave) {
  constexpr Real s = 0.1, radius = 0.2, epsilon = 1;
  for (const Kernel& density : all_kernels()) {
    for (const Kernel& gradient : all_kernels()) {
      const Kernels kernels{density, gradient};
      const Real volume = 1 / lattice_density_sum(density, s, radius);
      const Real largest = lattice_jacobi_eigenvalue(kernels, s, radius, volume, epsilon);
      const Real found = largest_of_some_waves(kernels, s, radius, volume, epsilon);
      EXPECT_LE(found, largest * (1 + 1e-12)) << density.name << ", " << gradient.name;
      EXPECT_GT(found, 0.9 * largest) << density.name << ", " << gradient.name;
    }
  }
}

TEST(Kernels, JacobiEigenvaluesAreKnown) {
  constexpr Real s = 0.1, epsilon = 1;
  for (const Row& row : rows()) {
    const Kernels kernels = kernels_of({.density_kernel = row.name});
    for (const auto& [ratio, eigenvalue] : row.eigenvalues) {
      const Real volume = 1 / lattice_density_sum(kernels.density, s, ratio * s);
      EXPECT_NEAR(lattice_jacobi_eigenvalue(kernels, s, ratio * s, volume, epsilon), eigenvalue, 1e-5)
          << row.name << ", h/s = " << ratio;
    }
  }
}

}  // namespace
}  // namespace trevi
