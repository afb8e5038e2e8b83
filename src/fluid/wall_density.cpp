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

Missing behind_planes(const std::array<Real, 3>& d, int dimensions, Real spacing, Real h) {
  const int reach = static_cast<int>(h / spacing) + 1;
  Missing missing;
  for (int i = -reach; i <= reach; ++i) {
    for (int j = -reach; j <= reach; ++j) {
      for (int k = -reach; k <= reach; ++k) {
        const Vec3 offset = spacing * Vec3(i, j, k);
        bool behind = offset.norm() < h * (1 - 1e-9);
        for (int a = 0; a < dimensions; ++a) behind = behind && offset[a] < -d[static_cast<std::size_t>(a)];
        if (!behind) continue;
        missing.share += poly6(offset, h);
        missing.gradient += spiky_gradient(offset, h).x();
      }
    }
  }
  const Real whole = lattice_poly6_sum(spacing, h);
  return {missing.share / whole, missing.gradient / whole};
}

Real quotient(Real a, Real b) { return b > 1e-12 ? a / b : 0; }

}  // namespace

Real half_space_share(Real d, Real h) { return d < h ? 315.0 / 256 * tail_integral(d / h) : 0; }

Real half_space_gradient(Real d, Real h) {
  if (d >= h) return 0;
  const Real t = 1 - d / h;
  return 30 / h * t * t * t * t * (0.25 - t / 5);
}

AnalyticWallDensity::AnalyticWallDensity(const Box& box, Real spacing, Real h)
    : box_(box), h_(h), spacing_(spacing), layers_(static_cast<int>(std::ceil(h / spacing - 0.5 - 1e-9))) {
  for (int dimensions = 1; dimensions <= 3; ++dimensions) tabulate(dimensions);
}

void AnalyticWallDensity::tabulate(int dimensions) {
  const auto entries = static_cast<int>(std::pow(layers_, dimensions) + 0.5);
  Table& table = tables_[static_cast<std::size_t>(dimensions) - 1];
  for (int entry = 0; entry < entries; ++entry) {
    // The first plane is the most significant digit.
    Distances d{};
    for (int a = dimensions - 1, rest = entry; a >= 0; --a, rest /= layers_) {
      d[static_cast<std::size_t>(a)] = (rest % layers_ + 0.5) * spacing_;
    }
    const Missing lattice = behind_planes(d, dimensions, spacing_, h_);
    Real share = 1, gradient = 1;
    for (int a = 0; a < dimensions; ++a) {
      const Distances one = {d[static_cast<std::size_t>(a)], 0, 0};
      const Missing plane = behind_planes(one, 1, spacing_, h_);
      share *= dimensions == 1 ? half_space_share(one[0], h_) : plane.share;
      gradient *= a > 0 ? plane.share : dimensions == 1 ? half_space_gradient(one[0], h_) : plane.gradient;
    }
    table.share.push_back(quotient(lattice.share, share));
    table.gradient.push_back(quotient(lattice.gradient, gradient));
  }
}

// Multilinear in the distances; below the first lattice distance and beyond the last the end value holds.
Real AnalyticWallDensity::ratio(const std::vector<Real>& table, const Distances& d, int dimensions) const {
  Real sum = 0;
  for (int vertex = 0; vertex < 1 << dimensions; ++vertex) {
    Real weight = 1;
    int place = 0;
    for (int a = 0; a < dimensions; ++a) {
      const Real x = std::clamp(d[static_cast<std::size_t>(a)] / spacing_ - 0.5, 0.0, static_cast<Real>(layers_ - 1));
      const int low = std::min(static_cast<int>(x), layers_ - 1), high = std::min(low + 1, layers_ - 1);
      const bool upper = (vertex >> a & 1) != 0;
      weight *= upper ? x - low : 1 - (x - low);
      place = place * layers_ + (upper ? high : low);
    }
    sum += weight * table[static_cast<std::size_t>(place)];
  }
  return sum;
}

// What lies behind any of the planes, by inclusion and exclusion: behind A or B = A + B − (A and B). Along the normal
// of A the points behind B alone cancel; those behind both do not.
BoundaryShare AnalyticWallDensity::union_of_planes(const Distances& d, const std::array<int, 3>& axis, int near) const {
  Distances f{}, g{};
  for (std::size_t a = 0; a < static_cast<std::size_t>(near); ++a) {
    f[a] = half_space_share(d[a], h_) * ratio(tables_[0].share, {d[a], 0, 0}, 1);
    g[a] = half_space_gradient(d[a], h_) * ratio(tables_[0].gradient, {d[a], 0, 0}, 1);
  }
  BoundaryShare total;
  for (std::size_t a = 0; a < static_cast<std::size_t>(near); ++a) {
    Real share = f[a], along = 1;
    for (std::size_t b = 0; b < static_cast<std::size_t>(near); ++b) {
      if (b == a) continue;
      along -= f[b] * ratio(tables_[1].gradient, {d[a], d[b], 0}, 2);
      if (b > a) share -= f[a] * f[b] * ratio(tables_[1].share, {d[a], d[b], 0}, 2);
    }
    if (near == 3)
      along += f[(a + 1) % 3] * f[(a + 2) % 3] * ratio(tables_[2].gradient, {d[a], d[(a + 1) % 3], d[(a + 2) % 3]}, 3);
    total.density += share;
    total.gradient[axis[a]] = g[a] * along;
  }
  if (near == 3) total.density += f[0] * f[1] * f[2] * ratio(tables_[2].share, d, 3);
  return total;
}

BoundaryShare AnalyticWallDensity::at(const Vec3& p) const {
  Distances d{};
  std::array<int, 3> axis{};
  Vec3 sign = Vec3::Zero();
  int near = 0;
  for (int a = 0; a < 3; ++a) {
    const Real low = p[a] - box_.min[a], high = box_.max[a] - p[a];
    const Real distance = std::max(std::min(low, high), 0.0);
    if (!(distance < h_)) continue;  // a NaN is nowhere near; the guards report it
    // rho falls as the particle moves away from the plane.
    sign[a] = low < high ? -1 : 1;
    d[static_cast<std::size_t>(near)] = distance;
    axis[static_cast<std::size_t>(near++)] = a;
  }
  if (near == 0) return {};
  BoundaryShare total = union_of_planes(d, axis, near);
  total.gradient = total.gradient.cwiseProduct(sign);
  return total;
}

}  // namespace trevi
