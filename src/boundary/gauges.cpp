#include "boundary/gauges.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "parallel/reductions.hpp"

namespace trevi {

namespace {

// Two perpendicular directions in the plane of the disc.
struct Plane {
  Vec3 u, v;
};

Plane across(const Vec3& normal) {
  Eigen::Index least = 0;
  normal.cwiseAbs().minCoeff(&least);
  const Vec3 axis = Vec3::Unit(least);
  const Vec3 u = (axis - normal.dot(axis) * normal).stableNormalized();
  const Vec3 v(normal.y() * u.z() - normal.z() * u.y(), normal.z() * u.x() - normal.x() * u.z(),
               normal.x() * u.y() - normal.y() * u.x());
  return {u, v};
}

// Distance by which a curved surface may deviate from the disc that represents it.
constexpr Real bulge = 0.25;  // spacings

// The weight of the part of the disc that counts, up to a factor.
template <class Counts>
Real weight_of(const Counts& counts, int dimensions) {
  constexpr int samples = 64;  // across
  const int rows = dimensions == 2 ? 1 : samples;
  Real sum = 0;
  for (int k = 0; k < samples * rows; ++k) {
    const Real a = 2 * (k % samples + 0.5) / samples - 1, b = 2 * (k / samples + 0.5) / rows - 1;
    const Real weight = 1 - (a * a + b * b);
    if (weight > 0 && counts(a, b)) sum += weight;
  }
  return sum;
}

// The integral of 1 - x² - y² over the part of [0, a] x [0, b] that is in the disc of radius 1.
Real integral_to(Real a, Real b) {
  if (a < 0) return -integral_to(-a, b);
  if (b < 0) return -integral_to(a, -b);
  a = std::min(a, 1.0);
  b = std::min(b, 1.0);
  const auto below = [b](Real x) { return x * b * (1 - (x * x + b * b) / 3); };  // where all of [0, b] is in the disc
  if (a * a + b * b <= 1) return below(a);
  const auto within = [](Real x) {  // integral of 2/3 (1 - x²)^(3/2), the part up to the edge
    return (x * (5 - 2 * x * x) * std::sqrt(1 - x * x) + 3 * std::asin(x)) / 12;
  };
  const Real edge = std::sqrt(1 - b * b);
  return below(edge) + within(a) - within(edge);
}

constexpr auto everywhere = [](Real, Real) { return true; };

}  // namespace

Real gauge_weight(Real distance2, Real radius) {
  const Real area = radius * radius;
  return distance2 < area ? 2 / (std::numbers::pi * area) * (1 - distance2 / area) : 0;
}

Real gauge_weight_of(const Box2& rectangle, Real radius) {
  const auto to = [radius](Real x, Real y) { return integral_to(x / radius, y / radius); };
  const auto& [x0, y0, x1, y1] = rectangle;
  return 2 / std::numbers::pi * (to(x1, y1) - to(x0, y1) - to(x1, y0) + to(x0, y0));
}

Real gauge_weight_in_layer(Real distance2, Real radius, Real spacing) {
  const Real area = radius * radius;
  return distance2 < area ? 0.75 / (radius * spacing) * (1 - distance2 / area) : 0;
}

Real gauge_weight_in_layer_of(const Box2& rectangle, Real radius) {
  const auto to = [radius](Real x) {
    const Real a = std::clamp(x / radius, -1.0, 1.0);
    return 0.75 * (a - a * a * a / 3);
  };
  return to(rectangle.max_x) - to(rectangle.min_x);
}

SeenFrom::SeenFrom(const Vec3& place, const Vec3& reach, const Settings& settings)
    : place_(place), images_{Vec3::Zero()} {
  for (Eigen::Index a = 0; a < 3; ++a) {
    if (!settings.periodic[static_cast<std::size_t>(a)]) continue;
    length_[a] = settings.domain.max[a] - settings.domain.min[a];
    lengths_per_metre_[a] = 1 / length_[a];
    // The nearest image is at most half a length away.
    const auto each_way = static_cast<int>(std::ceil(std::max(0.0, reach[a] / length_[a] - 0.5)));
    const std::vector<Vec3> others = images_;
    for (int n = -each_way; n <= each_way; ++n)
      for (const Vec3& other : others)
        if (n != 0) images_.emplace_back(other + n * length_[a] * Vec3::Unit(a));
  }
}

Real open_fraction_of_gauge(const GaugeSettings& gauge, const PointLattice& lattice, const Box& box,
                            const IsSolid& is_solid, const std::array<bool, 3>& periodic) {
  const int dimensions = lattice.dimensions;
  const auto ends = [&](Eigen::Index a) { return !periodic[static_cast<std::size_t>(a)]; };
  if (gauge.kind == GaugeKind::height) {
    Vec3 low = box.min - gauge.center, high = box.max - gauge.center;
    for (Eigen::Index a = 0; a < 2; ++a) {
      if (ends(a)) continue;
      low[a] = -INFINITY;
      high[a] = INFINITY;
    }
    const Box2 level{low.x(), low.y(), high.x(), high.y()};
    return dimensions == 2 ? gauge_weight_in_layer_of(level, gauge.radius) : gauge_weight_of(level, gauge.radius);
  }
  // In two dimensions the segment lies in the plane.
  const Plane plane =
      dimensions == 2 ? Plane{Vec3(gauge.normal.z(), 0, -gauge.normal.x()), Vec3::Zero()} : across(gauge.normal);
  const Vec3 off = bulge * lattice.spacing * gauge.normal;
  const auto open = [&](Vec3 p) {
    for (Eigen::Index a = 0; a < 3; ++a) {
      const Real length = box.max[a] - box.min[a];
      if (!ends(a)) p[a] -= std::floor((p[a] - box.min[a]) / length) * length;
    }
    return box.contains(p) && !is_solid(p);
  };
  const auto counts = [&](Real a, Real b) {
    const Vec3 p = gauge.center + gauge.radius * (a * plane.u + b * plane.v);
    return open(p + off) && !open(p - off);
  };
  return weight_of(counts, dimensions) / weight_of(everywhere, dimensions);
}

PressureGauges::PressureGauges(const Settings& settings, const IsSolid& is_solid)
    : spacing_(settings.fluid.spacing),
      h_(settings.fluid.kernel_radius),
      unit_(std::ldexp(settings.fluid.kernel_radius * settings.fluid.kernel_radius, -34)),
      in_layer_(settings.fluid.dimensions == 2) {
  for (const GaugeSettings& gauge : settings.gauges) {
    if (gauge.kind != GaugeKind::pressure) continue;
    gauges_.push_back(gauge);
    seen_.emplace_back(gauge.center, Vec3::Constant(gauge.radius + h_), settings);
    volume_.push_back(
        spacing_ * spacing_ * spacing_ /
        open_fraction_of_gauge(gauge, lattice_of(settings.fluid), settings.domain, is_solid, settings.periodic));
  }
  clear();
}

void PressureGauges::clear() {
  sums_.for_each([&](auto& sums) { sums.assign(gauges_.size(), 0); });
}

void PressureGauges::add_to(std::size_t k, const Vec3& shift, const Vec3& p) {
  const GaugeSettings& gauge = gauges_[k];
  seen_[k].for_each(p, [&](const Vec3& from) {
    const Real height = from.dot(gauge.normal);
    if (!(height >= -bulge * spacing_ && height <= h_)) return;
    const Real distance2 = from.squaredNorm() - height * height;
    const Real weight =
        in_layer_ ? gauge_weight_in_layer(distance2, gauge.radius, spacing_) : gauge_weight(distance2, gauge.radius);
    if (weight != 0) add_phi(k, -volume_[k] * weight * shift.dot(gauge.normal));
  });
}

// On the grid phi is negative where there is pressure.
void PressureGauges::add_phi(std::size_t gauge, Real phi) { sums_.mine()[gauge] -= std::llround(phi / unit_); }

std::vector<Real> PressureGauges::total(MPI_Comm comm) {
  if (gauges_.empty()) return {};
  std::vector<Real> pressed;
  for (const std::int64_t sum : sum_over_threads_and_ranks(comm, sums_))
    pressed.push_back(static_cast<Real>(sum) * unit_);
  return pressed;
}

}  // namespace trevi
