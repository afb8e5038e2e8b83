#include "io/tables/energy_rise.hpp"

#include <algorithm>
#include <cmath>

namespace trevi {

void EnergyRise::add(const Diagnostics& row) {
  constexpr Real compressed = 0.01;
  const Real energy = row.kinetic_energy + row.potential_energy;
  if (std::isnan(start_)) {
    start_ = highest_ = energy;
    const Real scale = std::max(std::abs(energy), weight_height_ * static_cast<Real>(row.particles));
    if (scale > 0 && row.compression_max <= compressed) scale_ = scale;
  }
  highest_ = std::max(highest_, energy);
}

}  // namespace trevi
