#include "boundary/gauges.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

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

// A rectangle around some of the disc, in radii from its centre.
struct Part {
  Real low[2], high[2];
};
constexpr Part whole{{-1, -1}, {1, 1}};

// The weight of what counts in that part, but for a factor.
template <class Counts>
Real weight_in(const Part& part, const Counts& counts) {
  constexpr int samples = 64;  // across
  const Real width = (part.high[0] - part.low[0]) / samples, length = (part.high[1] - part.low[1]) / samples;
  Real sum = 0;
  for (int k = 0; k < samples * samples; ++k) {
    const Real a = part.low[0] + (k % samples + 0.5) * width, b = part.low[1] + (k / samples + 0.5) * length;
    const Real weight = 1 - (a * a + b * b);
    if (weight > 0 && counts(a, b)) sum += weight;
  }
  return sum * width * length;
}

constexpr auto everywhere = [](Real, Real) { return true; };

// Samples lie in the box alone, as that may be much narrower than the disc.
Real open_fraction_of_height_gauge(const GaugeSettings& gauge, const Box& box) {
  Part part = whole;
  for (int a = 0; a < 2; ++a) {
    part.low[a] = std::max(-1.0, (box.min[a] - gauge.center[a]) / gauge.radius);
    part.high[a] = std::min(1.0, (box.max[a] - gauge.center[a]) / gauge.radius);
  }
  return weight_in(part, everywhere) / weight_in(whole, everywhere);
}

}  // namespace

Real gauge_weight(Real distance2, Real radius) {
  const Real area = radius * radius;
  return distance2 < area ? 2 / (std::numbers::pi * area) * (1 - distance2 / area) : 0;
}

Real open_fraction_of_gauge(const GaugeSettings& gauge, Real spacing, const Box& box, const IsSolid& is_solid) {
  if (gauge.kind == GaugeKind::height) return open_fraction_of_height_gauge(gauge, box);
  const Plane plane = across(gauge.normal);
  const Vec3 off = bulge * spacing * gauge.normal;
  const auto open = [&](const Vec3& p) { return box.contains(p) && !is_solid(p); };
  const auto counts = [&](Real a, Real b) {
    const Vec3 p = gauge.center + gauge.radius * (a * plane.u + b * plane.v);
    return open(p + off) && !open(p - off);
  };
  return weight_in(whole, counts) / weight_in(whole, everywhere);
}

PressureGauges::PressureGauges(const Settings& settings, const IsSolid& is_solid)
    : spacing_(settings.fluid.spacing),
      h_(settings.fluid.kernel_radius),
      unit_(std::ldexp(settings.fluid.kernel_radius * settings.fluid.kernel_radius, -34)) {
  for (const GaugeSettings& gauge : settings.gauges) {
    if (gauge.kind != GaugeKind::pressure) continue;
    gauges_.push_back(gauge);
    volume_.push_back(spacing_ * spacing_ * spacing_ /
                      open_fraction_of_gauge(gauge, spacing_, settings.domain, is_solid));
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
  std::vector<Real> pressed;
  for (const std::int64_t sum : sum_over_threads_and_ranks(comm, sums_))
    pressed.push_back(static_cast<Real>(sum) * unit_);
  return pressed;
}

}  // namespace trevi
