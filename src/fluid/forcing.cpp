#include "trevi/fluid/forcing.hpp"

#include <Random123/philox.h>

#include <algorithm>

namespace trevi {

void Gravity::apply(Particles& particles, const StepInfo& info) {
  const ScopedEvent timed(event_);
  const Vec3 change = acceleration_ * info.dt;
  for (Vec3& v : particles.velocity) v += change;
}

void FloorFriction::apply(Particles& particles, const StepInfo& info) {
  const ScopedEvent timed(event_);
  for (std::size_t i = 0; i < particles.id.size(); ++i) {
    const Real d = particles.position[i].z() - floor_;
    if (d >= h_) continue;
    Vec3& v = particles.velocity[i];
    const Real rate = coefficient_ / h_ * (1 - d / h_) * std::hypot(v.x(), v.y());
    v.head<2>() /= 1 + rate * info.dt;
  }
}

Fountain::Fountain(const FountainSettings& settings, std::unique_ptr<Pump> pump, Real floor, std::uint64_t seed,
                   int index)
    : event_("Fountain"), settings_(settings), pump_(std::move(pump)), floor_(floor), seed_(seed), index_(index) {}

std::optional<FountainState> Fountain::pumped(Real time) const {
  if (time < settings_.start || time >= settings_.stop) return std::nullopt;
  return pump_->at(time);
}

Real Fountain::fastest(const TimeSpan& times) const {
  const TimeSpan running{std::max(times.begin, settings_.start), std::min(times.end, settings_.stop)};
  if (running.begin >= running.end) return 0;
  const std::optional<Real> speed = pump_->fastest(running);
  return speed ? *speed + settings_.jitter : 0;
}

bool Fountain::contains(const Vec3& p) const {
  const Real x = p.x() - settings_.center[0], y = p.y() - settings_.center[1], r = settings_.diameter / 2;
  return x * x + y * y <= r * r && p.z() - floor_ <= settings_.height;
}

void Fountain::apply(Particles& particles, const StepInfo& info) {
  const ScopedEvent timed(event_);
  const std::optional<FountainState> now = pumped(info.time);
  if (!now) return;
  for (std::size_t i = 0; i < particles.id.size(); ++i) {
    if (!contains(particles.position[i])) continue;
    const Real u = uniform(seed_, particles.id[i], info, index_);
    particles.velocity[i] = settings_.direction * (now->speed + settings_.jitter * u);
  }
}

Real uniform(std::uint64_t seed, GlobalId id, const StepInfo& info, int stream) {
  using Generator = r123::Philox4x32;
  const auto low = [](std::uint64_t v) { return static_cast<std::uint32_t>(v); };
  const auto high = [](std::uint64_t v) { return static_cast<std::uint32_t>(v >> 32); };
  const auto particle = static_cast<std::uint64_t>(id), step = static_cast<std::uint64_t>(info.step);
  // 12 bits of stream, 20 of substep, of which a step has a million at most. A step past 2^32 would touch the latter's.
  const auto place =
      static_cast<std::uint32_t>(static_cast<unsigned>(info.substep) << 12U | (static_cast<unsigned>(stream) & 0xfffU));
  const Generator::ctr_type counter = {{low(particle), high(particle), low(step), place | high(step) << 24U}};
  const Generator::key_type key = {{low(seed), high(seed)}};
  const Generator::ctr_type random = Generator()(counter, key);
  const std::uint64_t bits = (static_cast<std::uint64_t>(random[0]) << 32U | random[1]) >> 11U;
  return static_cast<Real>(bits) * 0x1p-53;
}

}  // namespace trevi
