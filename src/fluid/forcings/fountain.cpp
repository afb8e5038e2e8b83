#include "fluid/forcings/fountain.hpp"

#include <algorithm>

#include "base/threads.hpp"

namespace trevi {

PumpedForcing::PumpedForcing(const PumpSettings& settings, std::unique_ptr<Pump> pump, std::uint64_t seed, int index)
    : settings_(settings), pump_(std::move(pump)), seed_(seed), index_(index) {}

std::optional<FountainState> PumpedForcing::pumped(Real time) const {
  if (time < settings_.start || time >= settings_.stop) return std::nullopt;
  return pump_->at(time);
}

Real PumpedForcing::fastest(const TimeSpan& times) const {
  const TimeSpan running{std::max(times.begin, settings_.start), std::min(times.end, settings_.stop)};
  if (running.begin >= running.end) return 0;
  const std::optional<Real> speed = pump_->fastest(running);
  return speed ? *speed + settings_.jitter : 0;
}

Vec3 PumpedForcing::jet(Real speed, GlobalId id, const StepInfo& info) const {
  return settings_.direction * (speed + settings_.jitter * uniform(seed_, id, info, index_));
}

Fountain::Fountain(const FountainSettings& settings, std::unique_ptr<Pump> pump, Real floor, std::uint64_t seed,
                   int index)
    : PumpedForcing(settings, std::move(pump), seed, index), event_("Fountain"), settings_(settings), floor_(floor) {}

bool Fountain::contains(const Vec3& p) const {
  const Real x = p.x() - settings_.center[0], y = p.y() - settings_.center[1], r = settings_.diameter / 2;
  return x * x + y * y <= r * r && p.z() - floor_ <= settings_.height;
}

void Fountain::apply(Particles& particles, const StepInfo& info) {
  const ScopedEvent timed(event_);
  const std::optional<FountainState> now = pumped(info.time);
  if (!now) return;
  for_each_index({0, particles.size()}, [&](std::size_t i) {
    if (!contains(particles.position[i])) return;
    particles.velocity[i] = jet(now->speed, particles.id[i], info);
  });
}

}  // namespace trevi
