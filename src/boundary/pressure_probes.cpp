#include "boundary/pressure_probes.hpp"

#include <algorithm>
#include <cmath>

#include "parallel/reductions.hpp"

namespace trevi {

namespace {

constexpr Real unit_of_weight = 0x1p-30;

}  // namespace

PressureProbes::PressureProbes(const Settings& settings)
    : unit_(std::ldexp(settings.fluid.kernel_radius * settings.fluid.kernel_radius, -34)) {
  for (const GaugeSettings& gauge : settings.gauges)
    if (gauge.kind == GaugeKind::pressure_in_water) places_.push_back(gauge.center);
  clear();
}

void PressureProbes::clear() { sums_.assign(2 * places_.size(), 0); }

void PressureProbes::add(std::size_t k, Real weight, Real phi) {
  sums_[2 * k] += std::llround(weight * phi / unit_);
  sums_[2 * k + 1] += std::llround(weight / unit_of_weight);
}

std::vector<Real> PressureProbes::means(MPI_Comm comm) const {
  const std::vector<std::int64_t> all = sum_over_ranks(comm, sums_);
  std::vector<Real> means;
  for (std::size_t k = 0; k < all.size(); k += 2) {
    const Real weight = static_cast<Real>(all[k + 1]) * unit_of_weight;
    means.push_back(weight > 0 ? static_cast<Real>(all[k]) * unit_ / weight : 0);
  }
  return means;
}

}  // namespace trevi
