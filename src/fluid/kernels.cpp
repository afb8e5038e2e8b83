#include "trevi/fluid/kernels.hpp"

#include <cmath>

namespace trevi {

Real poly6(const Vec3& r, Real h) {
  const Real t = 1 - r.squaredNorm() / (h * h);
  return t > 0 ? poly6_factor(h) * t * t * t : 0;
}

Vec3 spiky_gradient(const Vec3& r, Real h) {
  const Real length = r.norm();
  if (length <= 0 || length >= h) return Vec3::Zero();
  const Real t = 1 - length / h;
  return -spiky_gradient_factor(h) * t * t / length * r;
}

namespace {

// Calls visit(offset) for each lattice point nearer than h, the centre included.
template <class Visit>
void for_each_lattice_point(Real spacing, Real h, Visit&& visit) {
  const int reach = static_cast<int>(h / spacing) + 1;
  for (int x = -reach; x <= reach; ++x) {
    for (int y = -reach; y <= reach; ++y) {
      for (int z = -reach; z <= reach; ++z) {
        const Vec3 offset = spacing * Vec3(x, y, z);
        // Points at exactly h count as outside whatever the rounding.
        if (offset.norm() < h * (1 - 1e-9)) visit(offset);
      }
    }
  }
}

}  // namespace

Real lattice_poly6_sum(Real spacing, Real h) {
  Real sum = 0;
  for_each_lattice_point(spacing, h, [&](const Vec3& offset) { sum += poly6(offset, h); });
  return sum;
}

int lattice_neighbours(Real spacing, Real h) {
  int points = 0;
  for_each_lattice_point(spacing, h, [&](const Vec3&) { ++points; });
  return points - 1;
}

}  // namespace trevi
