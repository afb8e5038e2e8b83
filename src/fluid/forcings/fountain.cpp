#include "fluid/forcings/fountain.hpp"

#include <algorithm>

#include "base/threads.hpp"

namespace trevi {

PumpedForcing::PumpedForcing(const PumpSettings& settings, std::unique_ptr<Pump> pump, std::uint64_t seed, int index,
                             const char* event)
    : event_(event), settings_(settings), pump_(std::move(pump)), seed_(seed), index_(index) {}

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

void PumpedForcing::apply(Particles& particles, const StepInfo& info) {
  const ScopedEvent timed(event_);
  const std::optional<FountainState> now = pumped(info.time);
  if (!now) return;
  for_each_index({0, particles.size()}, [&](std::size_t i) {
    const Vec3& p = particles.position[i];
    if (!reaches(p)) return;
    const Vec3 out = jet(now->speed, particles.id[i], info);
    particles.velocity[i] = out + std::max(info.dt - leaves_after(p, out), 0.0) * gravity_;
  });
}

Real PumpedForcing::holds_for(GlobalId id, const Vec3& p, const StepInfo& info) const {
  const std::optional<FountainState> now = pumped(info.time);
  return now && reaches(p) ? std::clamp(leaves_after(p, jet(now->speed, id, info)), 0.0, info.dt) : 0;
}

Fountain::Fountain(const FountainSettings& settings, std::unique_ptr<Pump> pump, Real floor, std::uint64_t seed,
                   int index)
    : PumpedForcing(settings, std::move(pump), seed, index, "Fountain"), settings_(settings), floor_(floor) {}

bool Fountain::reaches(const Vec3& p) const {
  const Real x = p.x() - settings_.center[0], y = p.y() - settings_.center[1], r = settings_.diameter / 2;
  return x * x + y * y <= r * r && p.z() - floor_ <= settings_.height;
}

// The time until it leaves through the top, or through the side, where |r + t v|² is the square of the radius.
Real Fountain::leaves_after(const Vec3& p, const Vec3& velocity) const {
  const Real top = velocity.z() > 0 ? (floor_ + settings_.height - p.z()) / velocity.z() : INFINITY;
  const Real x = p.x() - settings_.center[0], y = p.y() - settings_.center[1], r = settings_.diameter / 2;
  const Real a = velocity.x() * velocity.x() + velocity.y() * velocity.y(), b = x * velocity.x() + y * velocity.y();
  if (a == 0) return top;
  return std::min(top, (std::sqrt(b * b + a * (r * r - x * x - y * y)) - b) / a);
}

}  // namespace trevi
