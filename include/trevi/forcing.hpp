// What changes velocities before the prediction (report, Algorithm 1, line 2): a Forcing is called once per substep for
// all the particles of a rank. For the same bits on any rank count it looks at one particle at a time, and draws random
// numbers from what does not depend on the ranks: uniform(seed, id, step, substep).
// Collective: prepare() only, which a source that one rank alone can hear (live sound) shares with all ranks.
#pragma once

#include <cmath>
#include <memory>
#include <optional>
#include <vector>

#include "trevi/particles.hpp"

namespace trevi {

/// The part of a step that is about to be made.
struct StepInfo {
  std::int64_t step = 0;  ///< steps done before
  int substep = 0;
  Real time = 0;  ///< at the start of the substep, s
  Real dt = 0;    ///< of the substep, s
};

/// Times t with begin ≤ t < end, s.
struct TimeSpan {
  Real begin = 0, end = 0;
};

/// State of a fountain at a time, as series.csv reports it.
struct FountainState {
  Real note = NAN;  ///< MIDI number of the note that sounds, fractional for a voice; nan when none
  Real speed = 0;   ///< pump speed without jitter, m/s; 0 when off
};

class Forcing {
 public:
  virtual ~Forcing() = default;
  /// Once before each step, all its substeps in one. Collective.
  virtual void prepare(const StepInfo&) {}
  virtual void apply(Particles& particles, const StepInfo& info) = 0;
  /// Highest speed it may give a particle within the times, m/s; for the choice of substeps.
  virtual Real fastest(const TimeSpan&) const { return 0; }
  /// What a fountain does at a time; nothing for a forcing that is no fountain.
  virtual std::optional<FountainState> state(Real) const { return std::nullopt; }
};

/// Uniform in [0, 1), a pure function of its arguments (Random123's Philox); `stream` tells its users apart.
Real uniform(std::uint64_t seed, GlobalId id, const StepInfo& info, int stream);

}  // namespace trevi
