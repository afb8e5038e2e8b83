// The pressure in the water at the places of gauges, on walls or away from them, as the projection finds it in the
// surrounding cells (projection/probe_pressures.hpp): the mean over the substeps of the step. Sums are integers, so
// that they do not depend on the number of ranks or threads. Collective: means().
#pragma once

#include <cstdint>
#include <vector>

#include "trevi/session.hpp"
#include "trevi/settings.hpp"

namespace trevi {

class PressureProbes {
 public:
  /// The gauges of pressure in the water.
  explicit PressureProbes(const Settings& settings);

  std::size_t count() const { return places_.size(); }
  const Vec3& place(std::size_t k) const { return places_[k]; }

  /// Adds the value in a cell near the place: phi, m², the pressure over the density times the square of the substep,
  /// with a weight from 0 to 1. Not in loops that threads share.
  void add(std::size_t k, Real weight, Real phi);
  /// The weighted means since clear(), m²; 0 where there was no water.
  std::vector<Real> means(MPI_Comm comm) const;
  void clear();

 private:
  std::vector<Vec3> places_;
  Real unit_;                       // m²
  std::vector<std::int64_t> sums_;  // of weight times phi, and of weights
};

}  // namespace trevi
