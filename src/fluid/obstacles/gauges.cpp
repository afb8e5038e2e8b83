#include "fluid/obstacles/gauges.hpp"

#include <algorithm>
#include <cmath>
#include <functional>

#include "parallel/reductions.hpp"

namespace trevi {

namespace {

// Two directions along the disc, at right angles.
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

// How far a curved surface may be off the disc that stands for it.
constexpr Real bulge = 0.25;  // spacings

}  // namespace

Real gauge_weight(Real distance2, Real radius) {
  constexpr Real pi = 3.14159265358979323846;
  const Real area = radius * radius;
  return distance2 < area ? 2 / (pi * area) * (1 - distance2 / area) : 0;
}

Real gauge_share(const GaugeSettings& gauge, Real spacing, const Box& box, const IsSolid& is_solid) {
  constexpr int samples = 64;  // across
  const bool pressure = gauge.kind == GaugeKind::pressure;
  const Plane plane = across(gauge.normal);
  const Vec3 off = bulge * spacing * gauge.normal;
  const auto open = [&](const Vec3& p) { return box.contains(p) && !is_solid(p); };
  Real all = 0, counted = 0;
  for (int k = 0; k < samples * samples; ++k) {
    const Real a = 2 * (k % samples + 0.5) / samples - 1, b = 2 * (k / samples + 0.5) / samples - 1;
    const Real weight = gauge_weight((a * a + b * b) * gauge.radius * gauge.radius, gauge.radius);
    if (weight == 0) continue;
    all += weight;
    const Vec3 p = gauge.center + gauge.radius * (a * plane.u + b * plane.v);
    if (pressure ? open(p + off) && !open(p - off) : box.contains(p)) counted += weight;
  }
  return counted / all;
}

PressureGauges::PressureGauges(const Settings& settings, const IsSolid& is_solid)
    : spacing_(settings.fluid.spacing),
      h_(settings.fluid.kernel_radius),
      unit_(std::ldexp(settings.fluid.kernel_radius * settings.fluid.kernel_radius, -34)) {
  for (const GaugeSettings& gauge : settings.gauges) {
    if (gauge.kind != GaugeKind::pressure) continue;
    gauges_.push_back(gauge);
    volume_.push_back(spacing_ * spacing_ * spacing_ / gauge_share(gauge, spacing_, settings.domain, is_solid));
  }
  clear();
}

void PressureGauges::clear() {
  sums_.for_each([&](auto& sums) { sums.assign(gauges_.size(), 0); });
}

void PressureGauges::add_to(std::size_t k, const Vec3& shift, const Vec3& p) {
  const GaugeSettings& gauge = gauges_[k];
  const Vec3 from = p - gauge.center;
  const Real height = from.dot(gauge.normal);
  if (!(height >= -bulge * spacing_ && height <= h_)) return;
  const Real weight = gauge_weight(from.squaredNorm() - height * height, gauge.radius);
  if (weight != 0) add_phi(k, -volume_[k] * weight * shift.dot(gauge.normal));
}

// The grid's phi is negative where there is pressure.
void PressureGauges::add_phi(std::size_t gauge, Real phi) { sums_.mine()[gauge] -= std::llround(phi / unit_); }

std::vector<Real> PressureGauges::total(MPI_Comm comm) {
  if (gauges_.empty()) return {};
  std::vector<std::int64_t> all(gauges_.size(), 0);
  sums_.for_each(
      [&](const auto& sums) { std::transform(all.begin(), all.end(), sums.begin(), all.begin(), std::plus()); });
  all = sum_over_ranks(comm, all);
  std::vector<Real> pressed(all.size());
  std::transform(all.begin(), all.end(), pressed.begin(),
                 [&](std::int64_t sum) { return static_cast<Real>(sum) * unit_; });
  return pressed;
}

}  // namespace trevi
