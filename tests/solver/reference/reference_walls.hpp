// The kernels and the walls' share of density by brute force: every share is a sum over the lattice
// points behind planes, summed anew from its definition in trevi/fluid/wall_density.hpp, and the gradient is its
// derivative by automatic differentiation. Shares no code with the solver. Not collective.
#pragma once

#include <cmath>
#include <map>
#include <numbers>
#include <stdexcept>
#include <string>
#include <unsupported/Eigen/AutoDiff>
#include <vector>

#include "trevi/scene.hpp"

namespace trevi::test {

inline Real reference_poly6(Real r, Real h, int dimensions = 3) {
  if (r >= h) return 0;
  if (dimensions == 2) return 4 / (std::numbers::pi * std::pow(h, 8)) * std::pow(h * h - r * r, 3);
  return 315 / (64 * std::numbers::pi * std::pow(h, 9)) * std::pow(h * h - r * r, 3);
}

struct ReferenceKernel {
  std::string name;
  Real h;
  int dimensions = 3;

  Real operator()(Real r) const {
    if (r >= h) return 0;
    if (dimensions == 2) return in_plane(r);
    if (name == "poly6") return reference_poly6(r, h);
    if (name == "spiky") return 15 / (std::numbers::pi * std::pow(h, 6)) * std::pow(h - r, 3);
    if (name == "wendland_c2") return 21 / (2 * std::numbers::pi * std::pow(h, 8)) * std::pow(h - r, 4) * (h + 4 * r);
    throw std::invalid_argument("the reference does not know " + name);
  }
  Real in_plane(Real r) const {
    if (name == "poly6") return reference_poly6(r, h, 2);
    if (name == "spiky") return 10 / (std::numbers::pi * std::pow(h, 5)) * std::pow(h - r, 3);
    return 7 / (std::numbers::pi * std::pow(h, 7)) * std::pow(h - r, 4) * (h + 4 * r);
  }
  Real slope_in_plane(Real r) const {
    if (name == "poly6") return -24 / (std::numbers::pi * std::pow(h, 8)) * r * std::pow(h * h - r * r, 2);
    if (name == "spiky") return -30 / (std::numbers::pi * std::pow(h, 5)) * std::pow(h - r, 2);
    return -140 / (std::numbers::pi * std::pow(h, 7)) * r * std::pow(h - r, 3);
  }
  /// dW/dr
  Real slope(Real r) const {
    if (r >= h) return 0;
    if (dimensions == 2) return slope_in_plane(r);
    if (name == "poly6") return -6 * 315 / (64 * std::numbers::pi * std::pow(h, 9)) * r * std::pow(h * h - r * r, 2);
    if (name == "spiky") return -45 / (std::numbers::pi * std::pow(h, 6)) * std::pow(h - r, 2);
    if (name == "wendland_c2") return -210 / (std::numbers::pi * std::pow(h, 8)) * r * std::pow(h - r, 3);
    throw std::invalid_argument("the reference does not know " + name);
  }
  /// The largest −dW/dr, by its place.
  Real steepest() const {
    const Real place = name == "poly6" ? h / std::sqrt(5.0) : name == "spiky" ? 0 : h / 4;
    return -slope(place);
  }
};

class ReferenceWalls {
 public:
  /// `slope` of a plane, over that of what the lattice misses.
  ReferenceWalls(const Scene& scene, Real slope)
      : slope_(slope),
        min_(scene.domain.min),
        max_(scene.domain.max),
        kernel_{scene.fluid.density_kernel, scene.fluid.kernel_radius, scene.fluid.dimensions},
        s_(scene.fluid.spacing) {
    for (int a = 0; a < 3; ++a) {  // no walls where the box repeats, and none across a layer
      if (!scene.periodic[static_cast<std::size_t>(a)] && !(a == 1 && kernel_.dimensions == 2)) continue;
      min_[a] -= 1000;
      max_[a] += 1000;
    }
    for (int k = 0; missing({k}).share > 0; ++k) layers_ = k + 1;
  }

  struct Share {
    Real density = 0;
    Vec3 gradient = Vec3::Zero();
  };
  Share at(const Vec3& p) const {
    Vec<Dual> place;
    for (int a = 0; a < 3; ++a) place[a] = Dual(p[a], 3, a);
    const Dual w = share(place);
    return {w.value(), w.derivatives()};
  }

 private:
  using Dual = Eigen::AutoDiffScalar<Vec3>;
  template <class S>
  using Vec = Eigen::Matrix<S, 3, 1>;
  // What the lattice misses behind planes in front of the first axes, as a share of the whole sum, and its slope along
  // the first of them.
  struct Missing {
    Real share = 0, slope = 0;
  };
  // Between the layers `low` and `low` + 1, at `upper` of the way on a smooth step.
  struct Plane {
    int axis = 0, low = 0;
    Dual share = Dual(0), upper = Dual(0);
  };

  /// Planes half a spacing behind the lattice layers `layer`, counted from the wall.
  const Missing& missing(const std::vector<int>& layer) const {
    const auto [known, is_new] = missing_.try_emplace(layer);
    if (!is_new) return known->second;
    const bool in_plane = kernel_.dimensions == 2;
    const int reach = static_cast<int>(std::ceil(kernel_.h / s_)), across = in_plane ? 0 : reach;
    Missing sum;
    Real whole = 0;
    for (int x = -reach; x <= reach; ++x)
      for (int y = -across; y <= across; ++y)
        for (int z = -reach; z <= reach; ++z) {
          const int at[] = {x, in_plane ? z : y, in_plane ? y : z};
          const Real r = s_ * std::sqrt(x * x + y * y + z * z);
          if (r > kernel_.h * (1 - 1e-9)) continue;
          whole += kernel_(r);
          bool behind = true;
          for (std::size_t a = 0; a < layer.size(); ++a) behind = behind && at[a] < -layer[a];
          if (!behind) continue;
          sum.share += kernel_(r);
          sum.slope += kernel_.slope(r) * std::abs(x) * s_ / r;
        }
    known->second = {sum.share / whole, sum.slope / whole};
    return known->second;
  }

  /// Gregory & Delbourgo (1982) between the layers, a straight line below the first.
  Plane plane(int axis, const Dual& distance) const {
    Plane result;
    result.axis = axis;
    const Dual x = distance / s_ - 0.5;
    if (x.value() < 0) {
      result.share = missing({0}).share + slope_ * missing({0}).slope * s_ * x;
      return result;
    }
    const int k = result.low = std::min(static_cast<int>(x.value()), layers_ - 1);
    const Real w0 = missing({k}).share, w1 = missing({k + 1}).share, rise = w1 - w0;
    const Real d0 = slope_ * missing({k}).slope * s_, d1 = slope_ * missing({k + 1}).slope * s_;
    const Dual t = x - static_cast<Real>(k), s = 1 - t;
    result.share = w0 + rise * (rise * t * t + d0 * t * s) / (rise + (d0 + d1 - 2 * rise) * t * s);
    result.upper = t * t * (3 - 2 * t);
    return result;
  }

  /// r of two or three planes. From the first layer on that misses nothing it is that of the last that does.
  Dual ratio(const std::vector<Plane>& planes) const {
    Dual sum(0);
    for (unsigned corner = 0; corner < 1U << planes.size(); ++corner) {
      Dual weight(1);
      std::vector<int> layer;
      Real product = 1;
      for (std::size_t a = 0; a < planes.size(); ++a) {
        const bool upper = (corner >> a & 1U) != 0;
        weight = Dual(weight * (upper ? planes[a].upper : Dual(1 - planes[a].upper)));
        layer.push_back(std::min(planes[a].low + (upper ? 1 : 0), layers_ - 1));
        product *= missing({layer.back()}).share;
      }
      sum = Dual(sum + weight * (missing(layer).share / product));
    }
    return sum;
  }

  Dual share(const Vec<Dual>& p) const {
    std::vector<Plane> near;
    for (int a = 0; a < 3; ++a)
      for (const Dual& d : {Dual(p[a] - min_[a]), Dual(max_[a] - p[a])})
        if (d.value() < (layers_ + 0.5) * s_) near.push_back(plane(a, d));
    Dual sum(0);
    for (const Plane& a : near) {
      sum = Dual(sum + a.share);
      for (const Plane& b : near) {
        if (b.axis <= a.axis) continue;
        sum = Dual(sum - a.share * b.share * ratio({a, b}));
        for (const Plane& c : near)
          if (c.axis > b.axis) sum = Dual(sum + a.share * b.share * c.share * ratio({a, b, c}));
      }
    }
    return sum;
  }

  Real slope_;
  Vec3 min_, max_;
  ReferenceKernel kernel_;
  Real s_;
  int layers_ = 0;  // that miss something behind a plane
  mutable std::map<std::vector<int>, Missing> missing_;
};

}  // namespace trevi::test
