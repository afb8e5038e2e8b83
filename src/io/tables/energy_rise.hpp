// How far the total energy of a run has risen above its start, from the rows of its series: kinetic and potential
// energy as they are there, less what it was supplied with (solver/supplied_energy.hpp). Water by itself can only lose
// energy, so a rise is the method's own. It is told twice. As a fraction of max(|E0|, m g h N) deep water counts by its
// height and shallow water by a kernel radius; without gravity that is the kinetic energy of the start (the definition
// of the stability study, postprocess/study.py). Water that is supplied counts by what it has or has been given most
// of. As a fraction of the moving part, what the start has above the same water at rest, a wave counts by itself. A
// start that is compressed may well push the water apart: it begins with the first row that is not. Not collective; the
// same rows give the same fractions on all ranks. May be copied as bytes.
#pragma once

#include <cmath>

#include "trevi/observer.hpp"

namespace trevi {

class EnergyRise {
 public:
  /// Of a particle the water that it stands for, kg; g, m/s², h, m, and the step dt, s. Of water supplied with no more
  /// energy than takes all of it by 1e-10 h in a step nothing is told: that is rounding.
  EnergyRise(Real mass, Real g, Real h, Real dt = INFINITY)
      : mass_(mass), g_(g), h_(h), rounding_(mass / 2 * std::pow(1e-10 * h / dt, 2)) {}
  /// Water at rest is level in a closed box of that floor, m², with nothing in it; its particles are `spacing` apart.
  void set_tank(Real floor, Real spacing) { floor_ = floor, spacing_ = spacing; }

  /// The next row; the first that is compressed by at most 1 % is the start. `of_bodies`: the kinetic energy of bodies,
  /// J, whose changes count as supplied: exact to a part of that alone.
  void add(const Diagnostics& row, Real supplied = 0, Real of_bodies = 0);

  /// The highest rise so far; nan without a start, and for one at rest without gravity.
  Real fraction() const { return (highest_ - start_) / scale_; }
  /// The same of the moving part; nan without set_tank(), without gravity, and where hardly anything moves: where it,
  /// or the rise, is less than to lift all of the water by a thousandth of the spacing.
  Real fraction_of_motion() const;

 private:
  Real mass_, g_, h_;
  Real rounding_;  // J, of a particle
  Real floor_ = NAN, spacing_ = NAN;
  Real start_ = NAN, highest_ = NAN, scale_ = NAN;  // J
  Real motion_ = NAN, least_ = NAN;                 // J
};

}  // namespace trevi
