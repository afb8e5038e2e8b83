#include "io/tables/gauge_series.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "boundary/gauges.hpp"
#include "parallel/reductions.hpp"
#include "trevi/error.hpp"

namespace trevi {

namespace {

bool is_pressure(const GaugeSettings& gauge) { return gauge.kind == GaugeKind::pressure; }

std::string columns_for(const std::vector<GaugeSettings>& gauges) {
  std::string columns;
  for (std::size_t k = 0; k < gauges.size(); ++k)
    columns += fmt::format(",{}_{}", is_pressure(gauges[k]) ? "pressure" : "height", k);
  return columns;
}

// Sums of heights are integers, so that they do not depend on the order of the particles.
constexpr int unit_exponent = -32;  // of a spacing

}  // namespace

GaugeSeries::GaugeSeries(MPI_Comm comm, const TableOptions& options, const Settings& settings)
    : TableSeries(comm, options, "gauges.csv", columns_for(settings.gauges)),
      gauges_(settings.gauges),
      spacing_(settings.fluid.spacing),
      pressures_(std::any_of(gauges_.begin(), gauges_.end(), is_pressure)) {
  const Real volume = spacing_ * spacing_ * spacing_;
  for (const GaugeSettings& gauge : gauges_)
    volume_.push_back(is_pressure(gauge) ? 0 : volume / open_fraction_of_gauge(gauge, spacing_, settings.domain, {}));
}

// Each particle is a cube of one spacing, cut at the foot of the gauge. A wire that is wetted measures the same: air in
// the water does not count.
std::vector<Real> GaugeSeries::heights(const Particles& particles) {
  const Real unit = std::ldexp(spacing_, unit_exponent);
  sums_.for_each([&](auto& sums) { sums.assign(gauges_.size(), 0); });
  constexpr LocalId part_size = 4096;
  for_each_part({0, static_cast<LocalId>(particles.size())}, part_size, [&](Range part) {
    std::vector<std::int64_t>& sums = sums_.mine();
    for (std::size_t g = 0; g < gauges_.size(); ++g) {
      if (volume_[g] == 0) continue;
      for (LocalId i = part.begin; i < part.end; ++i) {
        const Vec3 from = particles.position[static_cast<std::size_t>(i)] - gauges_[g].center;
        const Real weight = gauge_weight(from.x() * from.x() + from.y() * from.y(), gauges_[g].radius);
        if (weight == 0) continue;
        const Real above = std::clamp(from.z() / spacing_ + 0.5, 0.0, 1.0);
        sums[g] += std::llround(above * volume_[g] * weight / unit);
      }
    }
  });
  std::vector<Real> heights;
  for (const std::int64_t sum : sum_over_threads_and_ranks(comm(), sums_))
    heights.push_back(static_cast<Real>(sum) * unit);
  return heights;
}

void GaugeSeries::observe(const Frame& frame) {
  std::vector<Real> shown = heights(frame.particles);
  auto pressure = frame.pressures.begin();
  for (std::size_t k = 0; k < shown.size(); ++k) {
    if (!is_pressure(gauges_[k])) continue;
    require(pressure != frame.pressures.end(), "gauges.csv: no pressures in this frame");
    shown[k] = *pressure++;
  }
  std::string row;
  for (const Real one : shown) row += fmt::format(",{}", one);
  write(frame.clock, row);
}

}  // namespace trevi
