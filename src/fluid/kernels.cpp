#include "fluid/kernels.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "fluid/lattice_points.hpp"

namespace trevi {

Real poly6(const Vec3& r, Real h) {
  const Real t = 1 - r.squaredNorm() / (h * h);
  return t > 0 ? poly6_factor(h) * t * t * t : 0;
}

Vec3 poly6_gradient(const Vec3& r, Real h) {
  const Real t = 1 - r.squaredNorm() / (h * h);
  return t > 0 ? Vec3(-6 * poly6_factor(h) / (h * h) * t * t * r) : Vec3::Zero();
}

Real spiky(const Vec3& r, Real h) {
  const Real t = 1 - r.norm() / h;
  return t > 0 ? spiky_factor(h) * t * t * t : 0;
}

Vec3 spiky_gradient(const Vec3& r, Real h) {
  const Real length = r.norm();
  if (length <= 0 || length >= h) return Vec3::Zero();
  const Real t = 1 - length / h;
  return -spiky_gradient_factor(h) * t * t / length * r;
}

Real density_kernel(Kernel kernel, const Vec3& r, Real h) {
  return kernel == Kernel::poly6 ? poly6(r, h) : spiky(r, h);
}

Vec3 density_gradient(Kernel kernel, const Vec3& r, Real h) {
  return kernel == Kernel::poly6 ? poly6_gradient(r, h) : spiky_gradient(r, h);
}

Real lattice_density_sum(Kernel kernel, Real spacing, Real h) {
  Real sum = 0;
  for_each_lattice_point(spacing, h, [&](const Vec3& offset) { sum += density_kernel(kernel, offset, h); });
  return sum;
}

Real lattice_laplacian_moment(Real spacing, Real h) {
  Real sum = 0;
  for_each_lattice_point(spacing, h, [&](const Vec3& r) { sum += r.x() * r.x() * poly6(r, h); });
  return sum / 2;
}

int lattice_neighbours(Real spacing, Real h) {
  int points = 0;
  for_each_lattice_point(spacing, h, [&](const Vec3&) { ++points; });
  return points - 1;
}

namespace {

// sin(π q/12) for q = 0 ... 23, without a library function, whose last bit may depend on the processor.
std::array<Real, 24> sines_of_twelfths() {
  const Real twice_cosine = (std::sqrt(6.0) + std::sqrt(2.0)) / 2;
  std::array<Real, 24> sine{};
  sine[1] = (std::sqrt(6.0) - std::sqrt(2.0)) / 4;
  for (std::size_t q = 2; q <= 12; ++q) sine[q] = twice_cosine * sine[q - 1] - sine[q - 2];
  for (std::size_t q = 0; q < 12; ++q) sine[q + 12] = -sine[q];
  return sine;
}

}  // namespace

Real lattice_jacobi_eigenvalue(Kernel kernel, Real spacing, Real h, Real volume, Real epsilon) {
  struct Neighbour {
    std::array<int, 3> place;
    Vec3 dense, push;
  };
  std::vector<Neighbour> neighbours;
  Real diagonal = epsilon;
  for_each_lattice_point(spacing, h, [&](const Vec3& r) {
    const auto index = [&](Real x) { return static_cast<int>(std::lround(x / spacing)); };
    neighbours.push_back({{index(r.x()), index(r.y()), index(r.z())},
                          volume * density_gradient(kernel, r, h),
                          volume * spiky_gradient(r, h)});
    diagonal += neighbours.back().push.squaredNorm();
  });
  const std::array<Real, 24> sine = sines_of_twelfths();
  Real largest = 0;
  // k = π/spacing (x, y, z)/12 with 12 >= x >= y >= z >= 0; the other waves are mirror images.
  for (int x = 0; x <= 12; ++x) {
    for (int y = 0; y <= x; ++y) {
      for (int z = 0; z <= y; ++z) {
        Vec3 dense = Vec3::Zero(), push = Vec3::Zero();
        for (const Neighbour& n : neighbours) {
          const int q = (x * n.place[0] + y * n.place[1] + z * n.place[2]) % 24;
          const Real s = sine[static_cast<std::size_t>(q < 0 ? q + 24 : q)];
          dense += s * n.dense;
          push += s * n.push;
        }
        largest = std::max(largest, dense.dot(push) / diagonal);
      }
    }
  }
  return largest;
}

}  // namespace trevi
