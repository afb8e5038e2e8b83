// What changes velocities before the prediction: gravity and fountains, each called once per particle set.
// Only the forcings a scene names are built. A forcing is the same on any rank count: it looks at one particle at a
// time and draws its random numbers from (seed, id, step, substep) with a counter-based generator (Random123's Philox).
// Not collective.
#pragma once

#include <functional>
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

class Forcing {
 public:
  virtual ~Forcing() = default;
  virtual void apply(Particles& particles, const StepInfo& info) = 0;
  /// Speed it may give a particle at a time, m/s; for the choice of substeps.
  virtual Real fastest(Real) const { return 0; }
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

/// Pump speed without jitter at a time, m/s.
using PumpSpeed = std::function<Real(Real time)>;

/// Pumps the particles inside an upright cylinder on the floor: v = direction (speed + jitter u) in place of gravity.
class Fountain : public Forcing {
 public:
  /// `index` tells fountains apart in the random numbers; `floor` is the height of the floor, m.
  Fountain(const FountainSettings& settings, PumpSpeed speed, Real floor, std::uint64_t seed, int index);
  void apply(Particles& particles, const StepInfo& info) override;
  Real fastest(Real time) const override { return running(time) ? speed_(time) + settings_.jitter : 0; }
  bool running(Real time) const { return time >= settings_.start && time < settings_.stop; }

 private:
  bool contains(const Vec3& p) const;

  Event event_;
  FountainSettings settings_;
  PumpSpeed speed_;
  Real floor_;
  std::uint64_t seed_;
  int index_;
};

/// Uniform in [0, 1), a pure function of its arguments.
Real uniform(std::uint64_t seed, GlobalId id, const StepInfo& info, int stream);

}  // namespace trevi
