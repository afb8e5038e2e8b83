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
  tabulate(spacing);
}

void AnalyticWallDensity::tabulate(Real spacing) {
  const auto distance = [&](int k) { return (k + 0.5) * spacing; };
  std::vector<Real> share;
  for (int i = 0; i < layers_; ++i) {
    const Missing plane = behind_planes({distance(i), 0, 0}, 1, spacing, h_);
    share.push_back(plane.share);
    plane_.push_back(quotient(plane.share, half_space_share(distance(i), h_)));
    gradient_.push_back(quotient(plane.gradient, half_space_gradient(distance(i), h_)));
  }
  for (int i = 0; i < layers_; ++i) {
    for (int j = 0; j < layers_; ++j) {
      const Real product = share[static_cast<std::size_t>(i)] * share[static_cast<std::size_t>(j)];
      edge_.push_back(quotient(behind_planes({distance(i), distance(j), 0}, 2, spacing, h_).share, product));
      for (int k = 0; k < layers_; ++k) {
        const Missing corner = behind_planes({distance(i), distance(j), distance(k)}, 3, spacing, h_);
        corner_.push_back(quotient(corner.share, product * share[static_cast<std::size_t>(k)]));
      }
    }
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

BoundaryShare AnalyticWallDensity::at(const Vec3& p) const {
  BoundaryShare total;
  Distances d{}, share{};
  int near = 0;
  for (int a = 0; a < 3; ++a) {
    const Real low = p[a] - box_.min[a], high = box_.max[a] - p[a];
    const Real distance = std::max(std::min(low, high), 0.0);
    if (distance >= h_) continue;
    const Distances one = {distance, 0, 0};
    const Real f = half_space_share(distance, h_) * ratio(plane_, one, 1);
    const Real g = half_space_gradient(distance, h_) * ratio(gradient_, one, 1);
    total.density += f;
    // rho falls as the particle moves away from the plane.
    total.gradient[a] = low < high ? -g : g;
    d[static_cast<std::size_t>(near)] = distance;
    share[static_cast<std::size_t>(near++)] = f;
  }
  if (near >= 2) total.density -= share[0] * share[1] * ratio(edge_, {d[0], d[1], 0}, 2);
  if (near == 3) {
    total.density -= share[0] * share[2] * ratio(edge_, {d[0], d[2], 0}, 2);
    total.density -= share[1] * share[2] * ratio(edge_, {d[1], d[2], 0}, 2);
    total.density += share[0] * share[1] * share[2] * ratio(corner_, d, 3);
  }
  return total;
}

}  // namespace trevi
