#include "fluid/forcings/inlet.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "base/threads.hpp"

namespace trevi {

namespace {

constexpr Real rounding = 1e-9;

Real whole(Real length, Real spacing) { return std::max<Real>(1, std::round(length / spacing)); }

// The edges of the rectangle around an opening, the horizontal edge first.
std::array<Real, 2> edges_of(const InletSettings& settings) {
  if (settings.shape == InletShape::rectangle) return {settings.size[0], settings.size[1]};
  return {2 * settings.radius, 2 * settings.radius};
}

// The horizontal direction perpendicular to `d`; x if `d` is vertical.
Vec3 level_across(const Vec3& d) {
  const Vec3 level = Vec3::UnitZ().cross(d);
  return level.norm() > rounding ? Vec3(level / level.norm()) : Vec3::UnitX();
}

}  // namespace

InletLattice::InletLattice(const InletSettings& settings, Real spacing)
    : settings_(settings),
      spacing_(spacing),
      level_(level_across(settings.direction)),
      across_(settings.direction.cross(level_)) {
  const std::array<Real, 2> edges = edges_of(settings);
  for (const std::size_t a : {0U, 1U}) count_[a] = static_cast<GlobalId>(whole(edges[a], spacing));
  for (GlobalId place = 0; place < places(); ++place) open_ += is_open(place) ? 1 : 0;
}

Real InletLattice::places_of(const InletSettings& settings, Real spacing) {
  const std::array<Real, 2> edges = edges_of(settings);
  return whole(edges[0], spacing) * whole(edges[1], spacing);
}

bool InletLattice::is_open(GlobalId place) const {
  if (settings_.shape == InletShape::rectangle) return true;
  const Real x = static_cast<Real>(place % count_[0]) - static_cast<Real>(count_[0] - 1) / 2;
  const Real y = static_cast<Real>(place / count_[0]) - static_cast<Real>(count_[1] - 1) / 2;
  const Real r = settings_.radius / spacing_;
  return x * x + y * y <= r * r * (1 + rounding);
}

Vec3 InletLattice::position(GlobalId place, Real ahead) const {
  const Real x = static_cast<Real>(place % count_[0]) - static_cast<Real>(count_[0] - 1) / 2;
  const Real y = static_cast<Real>(place / count_[0]) - static_cast<Real>(count_[1] - 1) / 2;
  return settings_.center + spacing_ * (x * level_ + y * across_) + ahead * settings_.direction;
}

Vec3 InletLattice::reach() const {
  const Vec3 d = settings_.direction;
  if (settings_.shape == InletShape::disc) return settings_.radius * (1 - d.array().square()).max(0).sqrt();
  return settings_.size[0] / 2 * level_.cwiseAbs() + settings_.size[1] / 2 * across_.cwiseAbs();
}

InletLattice::Seen InletLattice::seen(const Vec3& p) const {
  const Vec3 off = p - settings_.center;
  return {off.dot(settings_.direction), off.dot(across_) / spacing_ + static_cast<Real>(count_[1] - 1) / 2,
          off.dot(level_) / spacing_ + static_cast<Real>(count_[0] - 1) / 2};
}

GlobalId InletLattice::place(Real row, Real column) const {
  const bool inside =
      row >= 0 && column >= 0 && row < static_cast<Real>(count_[1]) && column < static_cast<Real>(count_[0]);
  return inside ? static_cast<GlobalId>(row) * count_[0] + static_cast<GlobalId>(column) : -1;
}

std::array<GlobalId, 4> InletLattice::around(const Seen& seen) const {
  const Real row = std::floor(seen.row), column = std::floor(seen.column);
  return {place(row, column), place(row, column + 1), place(row + 1, column), place(row + 1, column + 1)};
}

bool InletLattice::in_nozzle(const Vec3& p) const {
  const Seen at = seen(p);
  if (at.ahead < 0 || at.ahead >= spacing_) return false;
  const GlobalId nearest = place(std::floor(at.row + 0.5), std::floor(at.column + 0.5));
  return nearest >= 0 && is_open(nearest);
}

Real speed_of_flow(Real flow, const InletLattice& lattice, Real spacing) {
  return flow / (static_cast<Real>(lattice.open_places()) * spacing * spacing);
}

Inlet::Inlet(const InletSettings& settings, std::unique_ptr<Pump> pump, Real spacing, std::uint64_t seed, int index)
    : PumpedForcing(settings, std::move(pump), seed, index, "Inlet"),
      lattice_(settings, spacing),
      recycles_(settings.recycle),
      spacing_(spacing),
      direction_(settings.direction) {}

bool Inlet::reaches(const Vec3& p) const {
  return lattice_.in_nozzle(p) && !(covers_ && covers_(p, p + spacing_ * direction_));
}

Real Inlet::leaves_after(const Vec3& p, const Vec3& velocity) const {
  const Real speed = velocity.dot(direction_);
  return speed > 0 ? (spacing_ - lattice_.seen(p).ahead) / speed : INFINITY;
}

// The part of a substep in which the pump may work, so that the amount does not depend on how time is divided.
TimeSpan Inlet::working(const StepInfo& info) const {
  return {std::max(info.time, pump().start), std::min(info.time + info.dt, pump().stop)};
}

Real Inlet::speed(const StepInfo& info) const {
  const TimeSpan times = working(info);
  const auto now = times.begin < times.end ? pumped(times.begin) : std::nullopt;
  return now ? now->speed : 0;
}

Real Inlet::path_length(const StepInfo& info) const {
  const TimeSpan times = working(info);
  return times.begin < times.end ? speed(info) * (times.end - times.begin) : 0;
}

bool drains(const DrainSettings& drain, const Vec3& p) {
  const Vec3 off = p - drain.center;
  const Real along = off.dot(drain.axis);
  switch (drain.shape) {
    case DrainShape::box:
      return (p.array() >= drain.min.array()).all() && (p.array() <= drain.max.array()).all();
    case DrainShape::cylinder:
      return along >= 0 && along <= drain.height &&
             (off - along * drain.axis).squaredNorm() <= drain.radius * drain.radius;
    default:
      return along > 0;
  }
}

Box bounds_of(const DrainSettings& drain) {
  if (drain.shape == DrainShape::box) return {drain.min, drain.max};
  constexpr Real far = 1e300;
  if (drain.shape == DrainShape::plane) return {Vec3::Constant(-far), Vec3::Constant(far)};
  const Vec3 end = drain.center + drain.height * drain.axis, around = Vec3::Constant(drain.radius);
  return {drain.center.cwiseMin(end) - around, drain.center.cwiseMax(end) + around};
}

}  // namespace trevi
