#include "io/tables/energy_rise.hpp"

#include <algorithm>
#include <cmath>

namespace trevi {

void EnergyRise::add(const Diagnostics& row, Real supplied, Real of_bodies) {
  constexpr Real compressed = 0.01;
  const Real energy = row.kinetic_energy + row.potential_energy - supplied;
  if (std::isnan(start_)) {
    if (!(row.compression_mean <= compressed)) return;
    start_ = highest_ = energy;
    const auto count = static_cast<Real>(row.particles);
    const Real weight = mass_ * g_ * count;
    const Real scale = std::max(std::abs(energy), weight * h_);
    if (scale > 0) scale_ = scale;
    const Real depth = count * spacing_ * spacing_ * spacing_ / floor_;
    least_ = 1e-3 * spacing_ * weight;
    motion_ = energy - weight * depth / 2;
  }
  highest_ = std::max(highest_, energy);
  if (supplied == 0) return;
  const auto count = static_cast<Real>(row.particles);
  const Real largest = std::max({std::abs(supplied), row.kinetic_energy, of_bodies, mass_ * g_ * h_ * count});
  if (largest <= rounding_ * count) return;
  scale_ = std::isnan(scale_) ? largest : std::max(scale_, largest);
}

Real EnergyRise::fraction_of_motion() const {
  const Real rise = highest_ - start_;
  return least_ > 0 && motion_ > least_ && rise > least_ ? rise / motion_ : NAN;
}

}  // namespace trevi
