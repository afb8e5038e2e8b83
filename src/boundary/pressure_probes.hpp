// The pressure in the water at places of gauges, on walls or away from them, as the projection finds it in the cells
// around (projection/probe_pressures.hpp): the mean over the substeps of the step. Sums are integers, so that no number
// of ranks or threads is seen in them. Collective: means().
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

  /// What a cell near the place says: phi, m², the pressure over the density times the time of the substep squared,
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
