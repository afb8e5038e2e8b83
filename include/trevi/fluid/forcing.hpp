// What changes velocities before the prediction: gravity, friction and fountains, each called once per particle set.
// Only the forcings a scene names are built. A forcing is the same on any rank count: it looks at one particle at a
// time and draws its random numbers from (seed, id, step, substep) with a counter-based generator (Random123's Philox).
// Collective: prepare() only, which a source that one rank alone can hear (live sound) shares with all ranks.
#pragma once

#include <cmath>
#include <memory>
#include <optional>
#include <vector>

#include "trevi/fluid/settings.hpp"
#include "trevi/parallel/log.hpp"
#include "trevi/particles/particles.hpp"

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

/// v += a dt.
class Gravity : public Forcing {
 public:
  explicit Gravity(const Vec3& acceleration) : event_("Gravity"), acceleration_(acceleration) {}
  void apply(Particles& particles, const StepInfo& info) override;

 private:
  Event event_;
  Vec3 acceleration_;
};

/// Skin friction of the floor: a shear stress c_f/2 rho |u| u against the horizontal velocity u, with c_f the
/// coefficient of a flat plate (White, Fluid Mechanics, 7.4). The stress acts on the water within h of the floor with
/// the weight w(d) = 2/h (1 − d/h) at height d, whose integral is 1, so that the force per area does not depend on the
/// spacing: du/dt = −c_f/2 w(d) |u| u, solved exactly over a step. It never adds energy, nor turns a particle around.
class FloorFriction : public Forcing {
 public:
  /// `floor` is the height of the floor, m; h the kernel radius, m.
  FloorFriction(Real coefficient, Real floor, Real h)
      : event_("FloorFriction"), coefficient_(coefficient), floor_(floor), h_(h) {}
  void apply(Particles& particles, const StepInfo& info) override;

 private:
  Event event_;
  Real coefficient_, floor_, h_;
};

/// What sets the speed of a fountain: a constant, or music (fluid/music.hpp).
class Pump {
 public:
  virtual ~Pump() = default;
  /// As Forcing::prepare. Collective.
  virtual void prepare(const StepInfo&) {}
  /// Note and speed at a time; nothing while the pump is off.
  virtual std::optional<FountainState> at(Real time) const = 0;
  /// Highest speed within the times, m/s; nothing while the pump is off throughout.
  virtual std::optional<Real> fastest(const TimeSpan& times) const = 0;
};

class ConstantPump : public Pump {
 public:
  explicit ConstantPump(Real speed) : speed_(speed) {}
  std::optional<FountainState> at(Real) const override { return FountainState{NAN, speed_}; }
  std::optional<Real> fastest(const TimeSpan&) const override { return speed_; }

 private:
  Real speed_;
};

/// Pumps the particles inside an upright cylinder on the floor: v = direction (speed + jitter u) in place of gravity.
/// While the pump is off it leaves them alone.
class Fountain : public Forcing {
 public:
  /// `index` tells fountains apart in the random numbers; `floor` is the height of the floor, m.
  Fountain(const FountainSettings& settings, std::unique_ptr<Pump> pump, Real floor, std::uint64_t seed, int index);
  void prepare(const StepInfo& step) override { pump_->prepare(step); }
  void apply(Particles& particles, const StepInfo& info) override;
  Real fastest(const TimeSpan& times) const override;
  std::optional<FountainState> state(Real time) const override { return pumped(time).value_or(FountainState{}); }

 private:
  bool contains(const Vec3& p) const;
  std::optional<FountainState> pumped(Real time) const;

  Event event_;
  FountainSettings settings_;
  std::unique_ptr<Pump> pump_;
  Real floor_;
  std::uint64_t seed_;
  int index_;
};

/// Uniform in [0, 1), a pure function of its arguments.
Real uniform(std::uint64_t seed, GlobalId id, const StepInfo& info, int stream);

}  // namespace trevi
