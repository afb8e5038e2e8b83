// Fountains and the pumps that drive them (inputs/README.md, Fountains). Collective: prepare() only.
#pragma once

#include <cmath>
#include <memory>
#include <optional>

#include "parallel/log.hpp"
#include "trevi/forcing.hpp"
#include "trevi/settings.hpp"

namespace trevi {

/// Determines the speed of a fountain: a constant, or music (src/music).
class Pump {
 public:
  virtual ~Pump() = default;
  /// Like Forcing::prepare(). Collective.
  virtual void prepare(const StepInfo&) {}
  /// Note and speed at a time; no value while the pump is off.
  virtual std::optional<FountainState> at(Real time) const = 0;
  /// Highest speed within the times, m/s; no value if the pump is off throughout.
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

/// A pump that works from its start to before its stop, and sets the velocity of the particles that it reaches. A
/// particle that leaves it within a substep falls for the rest of the substep, so that a jet has the same path for any
/// dt.
class PumpedForcing : public Forcing {
 public:
  /// `index` distinguishes the random numbers of different pumps; `event` is its name in the log.
  PumpedForcing(const PumpSettings& settings, std::unique_ptr<Pump> pump, std::uint64_t seed, int index,
                const char* event);
  /// Without gravity, nothing falls.
  void let_fall(const Vec3& gravity) { gravity_ = gravity; }
  void apply(Particles& particles, const StepInfo& info) override;
  Real holds_for(GlobalId id, const Vec3& p, const StepInfo& info) const override;
  void prepare(const StepInfo& step) override { pump_->prepare(step); }
  Real fastest(const TimeSpan& times) const override;
  std::optional<FountainState> state(Real time) const override { return pumped(time).value_or(FountainState{}); }

 protected:
  /// No value while the pump is off.
  std::optional<FountainState> pumped(Real time) const;
  /// Of a particle that is pumped at this speed without jitter.
  Vec3 jet(Real speed, GlobalId id, const StepInfo& info) const;
  const PumpSettings& pump() const { return settings_; }
  virtual bool reaches(const Vec3& p) const = 0;
  /// The time, s, after which the pump no longer acts on a particle at this position with this velocity.
  virtual Real leaves_after(const Vec3& p, const Vec3& velocity) const = 0;

 private:
  Event event_;
  PumpSettings settings_;
  std::unique_ptr<Pump> pump_;
  std::uint64_t seed_;
  int index_;
  Vec3 gravity_ = Vec3::Zero();
};

/// Sets the velocity of the particles inside an upright cylinder on the floor: v = direction (speed + jitter u), in
/// place of gravity. While the pump is off the particles are left alone.
class Fountain : public PumpedForcing {
 public:
  /// `floor` is the height of the floor, m.
  Fountain(const FountainSettings& settings, std::unique_ptr<Pump> pump, Real floor, std::uint64_t seed, int index);

 private:
  bool reaches(const Vec3& p) const override;
  Real leaves_after(const Vec3& p, const Vec3& velocity) const override;

  FountainSettings settings_;
  Real floor_;
};

}  // namespace trevi
