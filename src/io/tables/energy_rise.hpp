// How far the total energy of a run has risen above its initial value, from the rows of its series: kinetic and
// potential energy as given there, minus the energy that was supplied (solver/supplied_energy.hpp). Water by itself can
// only lose energy, so a rise is an error of the method. It is reported in two ways. As a fraction of max(|E0|, m g h
// N), the scale of deep water is its height and that of shallow water a kernel radius; without gravity it is the
// initial kinetic energy (the definition of the stability study, postprocess/study.py). The scale of supplied water is
// the largest energy that it has or was given. As a fraction of the moving part, the initial energy above that of the
// same water at rest, the scale of a wave is its own energy. A compressed initial state may well push the water apart:
// the account begins with the first row that is not compressed in the mean. Not collective; the same rows give the same
// fractions on all ranks. May be copied as bytes.
#pragma once

#include <cmath>

#include "trevi/observer.hpp"

namespace trevi {

class EnergyRise {
 public:
  /// `mass`: of the water that a particle represents, kg; g, m/s², h, m, and the step dt, s. No rise is reported for
  /// water that was supplied with no more energy than moves all of it by 1e-10 h in a step: that is rounding.
  EnergyRise(Real mass, Real g, Real h, Real dt = INFINITY)
      : mass_(mass), g_(g), h_(h), rounding_(mass / 2 * std::pow(1e-10 * h / dt, 2)) {}
  /// Water at rest is level in a closed box with this floor area, m², and nothing in it; particles are `spacing` apart.
  void set_tank(Real floor, Real spacing) { floor_ = floor, spacing_ = spacing; }

  /// Adds the next row; the first whose mean compression is at most 1 % is the start. `of_bodies`: the kinetic energy of
  /// bodies, J, whose changes count as supplied: exact to a fraction of that energy alone.
  void add(const Diagnostics& row, Real supplied = 0, Real of_bodies = 0);

  /// The highest rise so far; nan without a start, and for a start at rest without gravity.
  Real fraction() const { return (highest_ - start_) / scale_; }
  /// The same as a fraction of the moving part; nan without set_tank(), without gravity, and where hardly anything
  /// moves: if this part, or the rise, is less than what lifts all of the water by a thousandth of the spacing.
  Real fraction_of_motion() const;

 private:
  Real mass_, g_, h_;
  Real rounding_;  // J, per particle
  Real floor_ = NAN, spacing_ = NAN;
  Real start_ = NAN, highest_ = NAN, scale_ = NAN;  // J
  Real motion_ = NAN, least_ = NAN;                 // J
};

}  // namespace trevi
