#include "boundary/wall_density.hpp"

#include <algorithm>
#include <cmath>
#include <span>

#include "kernels/lattice_points.hpp"

namespace trevi {

namespace {

// What a particle lacks because lattice points are behind all of the planes at the distances d along as many axes.
struct Missing {
  Real value = 0;  // of the whole lattice sum
  Real pull = 0;   // magnitude of its gradient along the first axis, 1/m
};

Missing behind_planes(std::span<const Real> d, const Kernel& kernel, Real spacing, Real h) {
  using Axes = std::array<Eigen::Index, 3>;
  const Axes axes = kernel.dimensions == 2 ? Axes{0, 2, 1} : Axes{0, 1, 2};  // in the plane no point lies along y
  Missing missing;
  const PointLattice lattice{spacing, kernel.dimensions};
  for_each_lattice_point(lattice, h, [&](const Vec3& offset) {
    bool behind = true;
    for (std::size_t a = 0; a < d.size(); ++a) behind = behind && offset[axes[a]] < -d[a];
    if (!behind) return;
    missing.value += kernel.value(offset, h);
    missing.pull += kernel.gradient(offset, h).x();
  });
  const Real whole = lattice_density_sum(kernel, lattice, h);
  return {missing.value / whole, std::abs(missing.pull) / whole};
}

}  // namespace

AnalyticWallDensity::AnalyticWallDensity(const Box& box, const Kernel& kernel, Real spacing, Real h, Real slope)
    : box_(box),
      kernel_(kernel),
      h_(h),
      spacing_(spacing),
      per_spacing_(1 / spacing),
      layers_(std::max(1, static_cast<int>(std::ceil(h / spacing - 1e-9)) - 1)) {
  interior_ = {box.min.array() + reach(), box.max.array() - reach()};
  tabulate_layers(slope);
  tabulate_ratios();
}

void AnalyticWallDensity::tabulate_layers(Real slope) {
  for (int k = 0; k < layers_; ++k) {
    const std::array<Real, 1> d = {(k + 0.5) * spacing_};
    const Missing missing = behind_planes(d, kernel_, spacing_, h_);
    value_.push_back(missing.value);
    slope_.push_back(-slope * missing.pull);
  }
  value_.push_back(0);
  slope_.push_back(0);
}

void AnalyticWallDensity::tabulate_ratios() {
  const auto value = [&](std::initializer_list<int> layers) {
    std::vector<Real> d;
    Real product = 1;
    for (const int k : layers) {
      d.push_back((std::min(k, layers_ - 1) + 0.5) * spacing_);
      product *= value_[static_cast<std::size_t>(std::min(k, layers_ - 1))];
    }
    return behind_planes(d, kernel_, spacing_, h_).value / product;
  };
  for (int a = 0; a <= layers_; ++a) {
    for (int b = 0; b <= layers_; ++b) {
      edge_.push_back(value({a, b}));
      for (int c = 0; c <= layers_; ++c) corner_.push_back(value({a, b, c}));
    }
  }
}

// `side` is −1 for a plane below the particle and +1 for one above. Derivatives are along the axis, not with respect to
// the distance.
AnalyticWallDensity::Plane AnalyticWallDensity::plane_at(Real distance, int axis, Real side) const {
  const Real x = distance * per_spacing_ - 0.5, per = -side * per_spacing_;
  if (x < 0) return {axis, 0, value_[0] + slope_[0] * spacing_ * x, -side * slope_[0], 0, 0};
  const int layer = std::min(static_cast<int>(x), layers_ - 1);
  const auto k = static_cast<std::size_t>(layer);
  const Real t = x - layer, w0 = value_[k], w1 = value_[k + 1];
  const Real m0 = slope_[k] * spacing_, m1 = slope_[k + 1] * spacing_, rise = w1 - w0, u = t * (1 - t);
  const Real part = rise / (rise + (m0 + m1 - 2 * rise) * u);
  return {axis,
          layer,
          w0 + part * (rise * t * t + m0 * u),
          per * part * part * (m1 * t * t + 2 * rise * u + m0 * (1 - t) * (1 - t)),
          t * t * (3 - 2 * t),
          per * 6 * u};
}

AnalyticWallDensity::OfPlane AnalyticWallDensity::of_plane(Real distance) const {
  if (distance >= reach()) return {0, 0};
  const Plane plane = plane_at(distance, 0, -1);
  return {plane.value, plane.slope};
}

// Interpolates the table linearly in the blend of each plane.
AnalyticWallDensity::Ratio AnalyticWallDensity::ratio(std::initializer_list<const Plane*> planes) const {
  const std::vector<Real>& table = planes.size() == 2 ? edge_ : corner_;
  Ratio result;
  for (std::size_t corner = 0; corner < std::size_t{1} << planes.size(); ++corner) {
    std::size_t index = 0, a = 0;
    std::array<Real, 3> weight{1, 1, 1}, slope{};
    for (const Plane* plane : planes) {
      const bool upper = (corner >> a & 1U) != 0;
      index =
          index * (static_cast<std::size_t>(layers_) + 1) + static_cast<std::size_t>(plane->layer) + (upper ? 1 : 0);
      weight[a] = upper ? plane->blend : 1 - plane->blend;
      slope[a] = upper ? plane->blend_slope : -plane->blend_slope;
      ++a;
    }
    result.value += table[index] * weight[0] * weight[1] * weight[2];
    for (a = 0; a < 3; ++a) result.slope[a] += table[index] * slope[a] * weight[(a + 1) % 3] * weight[(a + 2) % 3];
  }
  return result;
}

void AnalyticWallDensity::add_edge(const Plane& a, const Plane& b, BoundaryDensity& total) const {
  const Ratio r = ratio({&a, &b});
  total.density -= a.value * b.value * r.value;
  total.gradient[a.axis] -= b.value * (a.slope * r.value + a.value * r.slope[0]);
  total.gradient[b.axis] -= a.value * (b.slope * r.value + b.value * r.slope[1]);
}

void AnalyticWallDensity::add_corner(const Plane& a, const Plane& b, const Plane& c, BoundaryDensity& total) const {
  const Ratio r = ratio({&a, &b, &c});
  total.density += a.value * b.value * c.value * r.value;
  total.gradient[a.axis] += b.value * c.value * (a.slope * r.value + a.value * r.slope[0]);
  total.gradient[b.axis] += a.value * c.value * (b.slope * r.value + b.value * r.slope[1]);
  total.gradient[c.axis] += a.value * b.value * (c.slope * r.value + c.value * r.slope[2]);
}

BoundaryDensity AnalyticWallDensity::at(const Vec3& p) const {
  std::array<Plane, max_planes> near;
  std::size_t count = 0;
  for (int axis = 0; axis < 3; ++axis) {
    // All comparisons with a NaN are false, so it has no wall; the guard of the run reports it.
    if (p[axis] < interior_.min[axis]) near[count++] = plane_at(std::max(p[axis] - box_.min[axis], 0.0), axis, -1);
    if (p[axis] > interior_.max[axis]) near[count++] = plane_at(std::max(box_.max[axis] - p[axis], 0.0), axis, 1);
  }
  if (count != 1) return combined({near.data(), count});
  BoundaryDensity value{near[0].value};
  value.gradient[near[0].axis] = near[0].slope;
  return value;
}

BoundaryDensity AnalyticWallDensity::combined(std::span<const Plane> planes) const {
  BoundaryDensity total;
  for (std::size_t i = 0; i < planes.size(); ++i) {
    const Plane& a = planes[i];
    total.density += a.value;
    total.gradient[a.axis] += a.slope;
    for (std::size_t j = i + 1; j < planes.size(); ++j) {
      if (planes[j].axis == a.axis) continue;
      add_edge(a, planes[j], total);
      for (std::size_t k = j + 1; k < planes.size(); ++k) {
        if (planes[k].axis != planes[j].axis) add_corner(a, planes[j], planes[k], total);
      }
    }
  }
  return total;
}

}  // namespace trevi
