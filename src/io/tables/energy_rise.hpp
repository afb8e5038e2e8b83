// How far the total energy of a run has risen above its start, from the rows of its series: kinetic and potential
// energy as they are there. Without pumps water can only lose energy, so a rise is the method's own. It is told as a
// fraction of max(|E0|, m g h N), in which deep water counts by its height and shallow water by a kernel radius;
// without gravity that is the kinetic energy of the start. The definition is that of the stability study
// (postprocess/study.py). Not collective; the same rows give the same fraction on all ranks. May be copied as bytes.
#pragma once

#include "trevi/observer.hpp"

namespace trevi {

class EnergyRise {
 public:
  /// `weight_height`: m g h of a particle, J.
  explicit EnergyRise(Real weight_height) : weight_height_(weight_height) {}

  /// The next row; the first is the start.
  void add(const Diagnostics& row);

  /// The highest rise so far; nan without a row, for a start at rest without gravity, and for one that is compressed by
  /// more than 1 %, which may well push the water apart.
  Real fraction() const { return (highest_ - start_) / scale_; }

 private:
  Real weight_height_;
  Real start_ = NAN, highest_ = NAN, scale_ = NAN;  // J
};

}  // namespace trevi
