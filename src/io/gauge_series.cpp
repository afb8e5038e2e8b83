#include "io/gauge_series.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "fluid/obstacles/gauges.hpp"
#include "io/kept_rows.hpp"
#include "parallel/collective.hpp"
#include "parallel/reductions.hpp"
#include "trevi/error.hpp"

namespace trevi {

namespace {

bool is_pressure(const GaugeSettings& gauge) { return gauge.kind == GaugeKind::pressure; }

std::string header_for(const std::vector<GaugeSettings>& gauges) {
  std::string header = "step,time";
  for (std::size_t k = 0; k < gauges.size(); ++k)
    header += fmt::format(",{}_{}", is_pressure(gauges[k]) ? "pressure" : "height", k);
  return header;
}

// Sums of heights are integers, so that they do not depend on the order of the particles.
constexpr int unit_exponent = -32;  // of a spacing

}  // namespace

GaugeSeries::GaugeSeries(MPI_Comm comm, GaugeSeriesOptions options)
    : comm_(comm),
      options_(std::move(options)),
      pressures_(std::any_of(options_.gauges.begin(), options_.gauges.end(), is_pressure)) {
  const Real s = options_.spacing;
  for (const GaugeSettings& gauge : options_.gauges)
    volume_.push_back(is_pressure(gauge) ? 0 : s * s * s / gauge_share(gauge, s, options_.box, {}));
  on_root(comm_, [&] { open(); });
  MPI_Bcast(&last_step_, 1, MPI_INT64_T, 0, comm_);
}

void GaugeSeries::open() {
  const std::string path = options_.directory + "/gauges.csv";
  last_step_ = begin_table(path, header_for(options_.gauges), options_.restart_step).last_step;
  file_.emplace(path);
}

// Each particle is a cube of one spacing, cut at the foot of the gauge. A wire that is wetted measures the same: air in
// the water does not count.
std::vector<Real> GaugeSeries::heights(const Particles& particles) {
  const std::vector<GaugeSettings>& gauges = options_.gauges;
  const Real s = options_.spacing, unit = std::ldexp(s, unit_exponent);
  sums_.for_each([&](auto& sums) { sums.assign(gauges.size(), 0); });
  constexpr LocalId part_size = 4096;
  for_each_part({0, static_cast<LocalId>(particles.size())}, part_size, [&](Range part) {
    std::vector<std::int64_t>& sums = sums_.mine();
    for (std::size_t g = 0; g < gauges.size(); ++g) {
      if (volume_[g] == 0) continue;
      for (LocalId i = part.begin; i < part.end; ++i) {
        const Vec3 from = particles.position[static_cast<std::size_t>(i)] - gauges[g].center;
        const Real weight = gauge_weight(from.x() * from.x() + from.y() * from.y(), gauges[g].radius);
        if (weight == 0) continue;
        const Real above = std::clamp(from.z() / s + 0.5, 0.0, 1.0);
        sums[g] += std::llround(above * volume_[g] * weight / unit);
      }
    }
  });
  std::vector<Real> heights;
  for (const std::int64_t sum : sum_over_threads_and_ranks(comm_, sums_))
    heights.push_back(static_cast<Real>(sum) * unit);
  return heights;
}

void GaugeSeries::observe(const Frame& frame) {
  std::vector<Real> shown = heights(frame.particles);
  auto pressure = frame.pressures.begin();
  for (std::size_t k = 0; k < shown.size(); ++k) {
    if (!is_pressure(options_.gauges[k])) continue;
    require(pressure != frame.pressures.end(), "gauges.csv: no pressures in this frame");
    shown[k] = *pressure++;
  }
  std::string row = fmt::format("{},{}", frame.clock.step, frame.clock.time());
  for (const Real one : shown) row += fmt::format(",{}", one);
  on_root(comm_, [&] { file_->write(row + "\n"); });
  last_step_ = frame.clock.step;
}

}  // namespace trevi
