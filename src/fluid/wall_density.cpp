#include "trevi/fluid/wall_density.hpp"

#include <algorithm>
#include <cmath>

#include "trevi/fluid/kernels.hpp"

namespace trevi {

namespace {

// ∫ (1 − x²)⁴ dx from x to 1.
Real tail_integral(Real x) {
  const auto primitive = [](Real t) {
    const Real t2 = t * t;
    return t * (1 + t2 * (-4.0 / 3 + t2 * (6.0 / 5 + t2 * (-4.0 / 7 + t2 / 9))));
  };
  return primitive(1) - primitive(x);
}

// Sums over the lattice points around a particle that lie behind the planes at d (of the first `dimensions` axes, all
// of them), as shares of the whole lattice sum.
struct Missing {
  Real share = 0;
  Real gradient = 0;  // Σ t² along the first axis
};

Missing behind_planes(const std::array<Real, 3>& d, int dimensions, Kernel kernel, Real spacing, Real h) {
  const int reach = static_cast<int>(h / spacing) + 1;
  Missing missing;
  for (int i = -reach; i <= reach; ++i) {
    for (int j = -reach; j <= reach; ++j) {
      for (int k = -reach; k <= reach; ++k) {
        const Vec3 offset = spacing * Vec3(i, j, k);
        bool behind = offset.norm() < h * (1 - 1e-9);
        for (int a = 0; a < dimensions; ++a) behind = behind && offset[a] < -d[static_cast<std::size_t>(a)];
        if (!behind) continue;
        missing.share += density_kernel(kernel, offset, h);
        missing.gradient += spiky_gradient(offset, h).x();
      }
    }
  }
  const Real whole = lattice_density_sum(kernel, spacing, h);
  return {missing.share / whole, missing.gradient / whole};
}

Real quotient(Real a, Real b) { return b > 1e-12 ? a / b : 0; }

}  // namespace

Real half_space_share(Kernel kernel, Real d, Real h) {
  if (d >= h) return 0;
  if (kernel == Kernel::poly6) return 315.0 / 256 * tail_integral(d / h);
  const Real t = 1 - d / h, t2 = t * t;
  return t2 * t2 * t * (1.5 - t);
}

Real half_space_gradient(Real d, Real h) {
  if (d >= h) return 0;
  const Real t = 1 - d / h;
  return 30 / h * t * t * t * t * (0.25 - t / 5);
}

AnalyticWallDensity::AnalyticWallDensity(const Box& box, Kernel kernel, Real spacing, Real h)
    : box_(box),
      interior_{box.min.array() + h, box.max.array() - h},
      kernel_(kernel),
      h_(h),
      spacing_(spacing),
      per_spacing_(1 / spacing),
      layers_(static_cast<int>(std::ceil(h / spacing - 0.5 - 1e-9))) {
  for (int dimensions = 1; dimensions <= most_planes; ++dimensions) tabulate(dimensions);
}

void AnalyticWallDensity::tabulate(int dimensions) {
  const int side = layers_ + 1;
  const auto entries = static_cast<int>(std::lround(std::pow(side, dimensions)));
  Table& table = tables_[static_cast<std::size_t>(dimensions) - 1];
  for (int entry = 0; entry < entries; ++entry) {
    // The first plane is the most significant digit.
    std::array<Real, most_planes> d{};
    for (int a = dimensions - 1, rest = entry; a >= 0; --a, rest /= side) {
      d[static_cast<std::size_t>(a)] = (std::min(rest % side, layers_ - 1) + 0.5) * spacing_;
    }
    const Missing lattice = behind_planes(d, dimensions, kernel_, spacing_, h_);
    Real share = 1, gradient = 1;
    for (int a = 0; a < dimensions; ++a) {
      const std::array<Real, most_planes> one = {d[static_cast<std::size_t>(a)], 0, 0};
      const Missing plane = behind_planes(one, 1, kernel_, spacing_, h_);
      share *= dimensions == 1 ? half_space_share(kernel_, one[0], h_) : plane.share;
      gradient *= a > 0 ? plane.share : dimensions == 1 ? half_space_gradient(one[0], h_) : plane.gradient;
    }
    table.share.push_back(quotient(lattice.share, share));
    table.gradient.push_back(quotient(lattice.gradient, gradient));
  }
}

// Multilinear in the distances; below the first lattice distance and beyond the last the end value holds.
template <std::size_t Dimensions>
Real AnalyticWallDensity::ratio(const std::vector<Real>& table,
                                const std::array<const Plane*, Dimensions>& planes) const {
  const auto side = static_cast<std::size_t>(layers_) + 1;
  std::array<Real, std::size_t{1} << Dimensions> value;  // at the corners of the interval, the last plane fastest
  for (std::size_t corner = 0; corner < value.size(); ++corner) {
    std::size_t place = 0;
    for (std::size_t a = 0; a < Dimensions; ++a) {
      const std::size_t upper = corner >> (Dimensions - 1 - a) & 1U;
      place = place * side + static_cast<std::size_t>(planes[a]->layer) + upper;
    }
    value[corner] = table[place];
  }
  for (std::size_t a = 0; a < Dimensions; ++a) {
    const std::size_t half = value.size() >> (a + 1);
    for (std::size_t k = 0; k < half; ++k) value[k] += planes[a]->fraction * (value[k + half] - value[k]);
  }
  return value[0];
}

AnalyticWallDensity::Plane AnalyticWallDensity::plane_at(Real distance, int axis, Real side) const {
  Plane plane{distance, axis, side};
  const Real x = std::clamp(distance * per_spacing_ - 0.5, 0.0, static_cast<Real>(layers_ - 1));
  plane.layer = static_cast<int>(x);
  plane.fraction = x - plane.layer;
  plane.share = half_space_share(kernel_, distance, h_) * ratio<1>(tables_[0].share, {&plane});
  plane.gradient = half_space_gradient(distance, h_) * ratio<1>(tables_[0].gradient, {&plane});
  return plane;
}

// What lies behind any of the planes, by inclusion and exclusion: behind A or B = A + B − (A and B). Along the normal
// of A the points behind B alone cancel; those behind both do not.
BoundaryShare AnalyticWallDensity::union_of(const std::array<Plane, most_planes>& planes, std::size_t count) const {
  BoundaryShare total;
  for (std::size_t k = 0; k < count; ++k) {
    const Plane& a = planes[k];
    Real share = a.share, along = 1;
    for (std::size_t l = 0; l < count; ++l) {
      if (l == k) continue;
      const Plane& b = planes[l];
      along -= b.share * ratio<2>(tables_[1].gradient, {&a, &b});
      if (l > k) share -= a.share * b.share * ratio<2>(tables_[1].share, {&a, &b});
    }
    if (count == 3) {
      const Plane &b = planes[(k + 1) % 3], &c = planes[(k + 2) % 3];
      along += b.share * c.share * ratio<3>(tables_[2].gradient, {&a, &b, &c});
    }
    total.density += share;
    total.gradient[a.axis] = a.side * a.gradient * along;
  }
  if (count == 3) {
    const auto& [a, b, c] = planes;
    total.density += a.share * b.share * c.share * ratio<3>(tables_[2].share, {&a, &b, &c});
  }
  return total;
}

BoundaryShare AnalyticWallDensity::near_walls(const Vec3& p) const {
  std::array<Plane, most_planes> planes;
  std::size_t count = 0;
  for (int axis = 0; axis < 3; ++axis) {
    const Real low = p[axis] - box_.min[axis], high = box_.max[axis] - p[axis];
    const Real distance = std::max(std::min(low, high), 0.0);
    // A NaN is nowhere near; the guards report it.
    if (distance < h_) planes[count++] = plane_at(distance, axis, low < high ? -1 : 1);
  }
  return union_of(planes, count);
}

}  // namespace trevi
