// Forcings change velocities before the prediction (Macklin & Müller 2013, Algorithm 1, line 2). A Forcing is called
// once per substep for all particles of a rank. To give the same bits on any rank count, it treats each particle
// independently and draws random numbers from uniform(), whose arguments do not depend on the ranks. Collective:
// prepare() only, in which a source that only one rank can read (live sound) is shared with all ranks.
#pragma once

#include <cmath>
#include <memory>
#include <optional>
#include <vector>

#include "trevi/particles.hpp"

namespace trevi {

/// The substep that is about to be computed.
struct StepInfo {
  std::int64_t step = 0;  ///< steps completed before
  int substep = 0;
  Real time = 0;  ///< at the start of the substep, s
  Real dt = 0;    ///< of the substep, s
};

/// Times t with begin ≤ t < end, s.
struct TimeSpan {
  Real begin = 0, end = 0;
};

/// State of a fountain at a given time, as series.csv reports it.
struct FountainState {
  Real note = NAN;  ///< MIDI number of the note that sounds, fractional for a voice; nan for none
  Real speed = 0;   ///< pump speed without jitter, m/s; 0 when the pump is off
};

class Forcing {
 public:
  virtual ~Forcing() = default;
  /// Called once before each step; `dt` is that of the whole step. Collective.
  virtual void prepare(const StepInfo&) {}
  virtual void apply(Particles& particles, const StepInfo& info) = 0;
  /// For how long from the start of the substep, in s, this forcing alone determines the motion of a particle at p, and
  /// gravity does not. Called by several threads at once; does not throw.
  virtual Real holds_for(GlobalId /*id*/, const Vec3& /*p*/, const StepInfo&) const { return 0; }
  /// Highest speed that it may give a particle within the time span, m/s; determines the number of substeps.
  virtual Real fastest(const TimeSpan&) const { return 0; }
  /// State of a fountain at a given time; no value for a forcing that is not a fountain.
  virtual std::optional<FountainState> state(Real) const { return std::nullopt; }
};

/// A random number, uniform in [0, 1), as a pure function of the arguments (Random123's Philox); `stream` separates
/// different users.
Real uniform(std::uint64_t seed, GlobalId id, const StepInfo& info, int stream);

}  // namespace trevi
