#include "solver/wall_flows.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "parallel/reductions.hpp"

namespace trevi {

namespace {

constexpr Real share = 0x1p-20;        // of a particle, and of its momentum per m/s
constexpr Real following_time = 20;    // of the means, sqrt(d/g)
constexpr Real apart = 2, strip = 16;  // spacings from an opening to the strip where its level is measured; its length
constexpr Real min_length = 8;         // spacings, of the box of a drain
constexpr Real max_due = 2;            // layers that a drain may still have to take
constexpr Real fastest = 3;            // sqrt(g d): the largest speed that a level may require

// The fraction of a particle's cube along one of its edges that lies between two positions given in spacings.
Real part_between(Real p, Real from, Real to, Real spacing) {
  return std::max<Real>(0, std::min(p / spacing + 0.5, to / spacing) - std::max(p / spacing - 0.5, from / spacing));
}

}  // namespace

std::vector<UprightWall> walls_beside(const DrainSettings& drain, const Settings& settings) {
  std::vector<UprightWall> found;
  for (int a = 0; a < (settings.fluid.dimensions == 2 ? 1 : 2); ++a) {
    const bool low = drain.min[a] <= settings.domain.min[a], high = drain.max[a] >= settings.domain.max[a];
    if (low != high && !settings.periodic[static_cast<std::size_t>(a)]) found.push_back({a, high});
  }
  return found;
}

std::optional<WallRefusal> why_not_in_wall(const InletSettings& inlet, const Settings& settings) {
  if (!inlet.is_in_wall()) return std::nullopt;
  const char* const key = inlet.profile ? "profile" : "level";
  const Real spacing = settings.fluid.spacing;
  const int axis = std::abs(inlet.direction.x()) > std::abs(inlet.direction.y()) ? 0 : 1;
  if (inlet.shape != InletShape::rectangle) return WallRefusal{key, "is for type = \"rectangle\""};
  if (inlet.recycle || inlet.music) return WallRefusal{key, "does not go with recycle or music; leave one of them out"};
  constexpr Real rounding = 1e-6;
  if (std::abs(inlet.direction[axis]) < 1 - rounding || settings.periodic[static_cast<std::size_t>(axis)])
    return WallRefusal{"direction", "must lead straight out of an upright wall where there is a profile or a level"};
  const Real from = inlet.direction[axis] > 0 ? inlet.center[axis] - settings.domain.min[axis]
                                              : settings.domain.max[axis] - inlet.center[axis];
  if (!(from >= (0.5 - rounding) * spacing && from <= (1 + rounding) * spacing))
    return WallRefusal{"center",
                       fmt::format("must be half a spacing to one, {:.6g} to {:.6g} m, from the wall behind it "
                                   "where there is a profile or a level",
                                   spacing / 2, spacing)};
  const Real top = inlet.center.z() + inlet.size[1] / 2, bottom = inlet.center.z() - inlet.size[1] / 2;
  if (inlet.level && !(*inlet.level > bottom + spacing && *inlet.level < top + spacing))
    return WallRefusal{
        "level", fmt::format("must be in the opening, or less than a spacing above it, between {:.6g} and {:.6g} m",
                             bottom + spacing, top + spacing)};
  return std::nullopt;
}

std::optional<WallRefusal> why_not_in_wall(const DrainSettings& drain, const Settings& settings) {
  if (!drain.is_in_wall()) return std::nullopt;
  const char* const key = drain.level ? "level" : "flow";
  if (drain.level && drain.flow) return WallRefusal{"flow", "level is given, too; keep one of them"};
  if (drain.shape != DrainShape::box) return WallRefusal{key, "is for type = \"box\""};
  const std::vector<UprightWall> walls = walls_beside(drain, settings);
  if (walls.size() != 1)
    return WallRefusal{
        key,
        "needs a box that lies on one upright wall; let it end at that wall, or beyond, and at no other, "
        "or reach from wall to wall"};
  const int axis = walls.front().axis;
  const Real length =
      walls.front().at_max ? settings.domain.max[axis] - drain.min[axis] : drain.max[axis] - settings.domain.min[axis];
  const Real least = min_length * settings.fluid.spacing, rounding = 1e-9 * least;
  if (!(length >= least - rounding))
    return WallRefusal{
        key, fmt::format("needs a box that reaches {:.6g} m or more into the water, to see its level", least)};
  if (drain.level && !(*drain.level > drain.min.z() + settings.fluid.spacing && *drain.level < drain.max.z()))
    return WallRefusal{"level", "must be in the box of the drain, between min and max"};
  if (drain.flow && !(*drain.flow >= 0 && std::isfinite(*drain.flow)))
    return WallRefusal{"flow", "must not be negative"};
  const Real opening = (drain.max.z() - drain.min.z()) * (drain.max[1 - axis] - drain.min[1 - axis]);
  if (constexpr Real highest = 1e4; drain.flow && !(*drain.flow <= highest * opening))
    return WallRefusal{"flow", fmt::format("is more than {:g} m/s through all of the box; check the units", highest)};
  return std::nullopt;
}

std::optional<WallRefusal> why_not_beside(const InletSettings& inlet, std::span<const InletSettings> others,
                                          const Settings& settings) {
  if (!inlet.is_in_wall()) return std::nullopt;
  const InletLattice lattice(inlet, settings.fluid.spacing);
  const Real rounding = 1e-6 * settings.fluid.spacing;
  for (std::size_t k = 0; k < others.size(); ++k) {
    if (!others[k].is_in_wall() || why_not_in_wall(others[k], settings)) continue;
    const InletLattice other(others[k], settings.fluid.spacing);
    const Vec3 from = (inlet.center - lattice.reach()).cwiseMax(others[k].center - other.reach());
    const Vec3 to = (inlet.center + lattice.reach()).cwiseMin(others[k].center + other.reach());
    const Eigen::Index axis = std::abs(inlet.direction.x()) > std::abs(inlet.direction.y()) ? 0 : 1;
    const bool same_wall = inlet.direction.dot(others[k].direction) > 0.5;
    if (same_wall && (to - from)[1 - axis] > rounding && (to - from).z() > rounding)
      return WallRefusal{"center", fmt::format("the opening overlaps that of inlet {} in the same wall, which would "
                                               "bring water to the same places; part them, or leave one out",
                                               k)};
  }
  return std::nullopt;
}

std::optional<WallRefusal> why_not_beside(const DrainSettings& drain, std::span<const DrainSettings> others,
                                          const Settings& settings) {
  if (!drain.is_in_wall()) return std::nullopt;
  const UprightWall wall = walls_beside(drain, settings).front();
  const Real rounding = 1e-6 * settings.fluid.spacing;
  for (std::size_t k = 0; k < others.size(); ++k) {
    const DrainSettings& other = others[k];
    if (!other.is_in_wall() || why_not_in_wall(other, settings)) continue;
    const UprightWall its = walls_beside(other, settings).front();
    if (its.axis != wall.axis || its.at_max != wall.at_max) continue;
    if (((drain.max.cwiseMin(other.max) - drain.min.cwiseMax(other.min)).array() > rounding).all())
      return WallRefusal{drain.level ? "level" : "flow",
                         fmt::format("its box overlaps that of drain {} at the same wall, which would take the same "
                                     "water; part their boxes, or leave one out",
                                     k)};
  }
  return std::nullopt;
}

Real mean_speed(const InletSettings& inlet, Real rows, Real spacing, Real time) {
  Real mean = 0;
  for (Real row = 0; row < rows; ++row)
    mean += std::max(0.0, inlet.profile->speed(inlet.center.z() + (row - (rows - 1) / 2) * spacing, time)) / rows;
  return mean;
}

WallFlows::WallFlows(const Settings& settings)
    : inlet_settings_(settings.inlets),
      drain_settings_(settings.drains),
      settings_(settings),
      spacing_(settings.fluid.spacing),
      gravity_(-settings.gravity.value_or(Vec3::Zero()).z()) {
  for (const InletSettings& inlet : inlet_settings_) {
    first_row_.push_back(inlet.is_in_wall() ? static_cast<std::ptrdiff_t>(rows_) : -1);
    of_inlet_.push_back(openings_.size());
    if (!inlet.is_in_wall()) continue;
    const auto own = static_cast<std::size_t>(InletLattice(inlet, spacing_).rows());
    add_inlet(inlet, own);
    rows_ += own;
  }
  for (const DrainSettings& drain : drain_settings_) {
    if (drain.is_in_wall()) add_drain(drain);
  }
  if (openings_.empty()) return;
  const StandingSolids solids(settings_);
  for (Opening& opening : openings_) find_seen(opening, solids);
}

void WallFlows::resize(FlowState& state) const {
  state.openings.resize(openings_.size());
  state.rows.resize(rows_, 0);
}

// For an opening that has its final width, and for which the region where its level is measured is known.
void WallFlows::find_seen(Opening& opening, const StandingSolids& solids) const {
  const int other = 1 - opening.wall.axis;
  opening.seen = opening.across;
  if (opening.seen[0] < settings_.domain.min[other] + spacing_ / 2)
    opening.seen[0] = settings_.domain.min[other] - spacing_;
  if (opening.seen[1] > settings_.domain.max[other] - spacing_ / 2)
    opening.seen[1] = settings_.domain.max[other] + spacing_;
  Box part = settings_.domain;
  part.min[opening.wall.axis] = opening.from;
  part.max[opening.wall.axis] = opening.to;
  part.min[other] = opening.across[0];
  part.max[other] = opening.across[1];
  if (solids.may_reach_into(part)) opening.space.emplace(part, solids, settings_);
}

void WallFlows::add_inlet(const InletSettings& inlet, std::size_t rows) {
  const InletLattice lattice(inlet, spacing_);
  const int axis = std::abs(inlet.direction.x()) > std::abs(inlet.direction.y()) ? 0 : 1;
  const Real sign = inlet.direction[axis], half = static_cast<Real>(lattice.places()) / static_cast<Real>(rows) / 2;
  Opening opening{{axis, sign < 0}};
  const Real near = inlet.center[axis] + sign * apart * spacing_, far = near + sign * strip * spacing_;
  opening.from = std::max(std::min(near, far), settings_.domain.min[axis]);
  opening.to = std::min(std::max(near, far), settings_.domain.max[axis]);
  opening.across = {inlet.center[1 - axis] - half * spacing_, inlet.center[1 - axis] + half * spacing_};
  opening.bottom = inlet.center.z() - static_cast<Real>(rows) * spacing_ / 2;
  opening.top = opening.bottom + static_cast<Real>(rows) * spacing_;
  opening.inlet = &inlet;
  constexpr Real rounding = 1e-6;
  if (inlet.level)
    rows = std::min(rows, static_cast<std::size_t>(
                              std::max(1.0, std::floor((*inlet.level - opening.bottom) / spacing_ + 0.5 + rounding))));
  opening.speeds.assign(rows, 0);
  openings_.push_back(std::move(opening));
}

void WallFlows::add_drain(const DrainSettings& drain) {
  const UprightWall wall = walls_beside(drain, settings_).front();
  const int other = 1 - wall.axis;
  const Box& box = settings_.domain;
  Opening opening{wall};
  opening.from = wall.at_max ? drain.min[wall.axis] : box.min[wall.axis] + apart * spacing_;
  opening.to = wall.at_max ? box.max[wall.axis] - apart * spacing_ : drain.max[wall.axis];
  opening.across = {std::max(drain.min[other], box.min[other]), std::min(drain.max[other], box.max[other])};
  opening.bottom = std::max(drain.min.z(), box.min.z());
  opening.top = drain.max.z();
  opening.drain = &drain;
  opening.speeds.assign(1, 0);
  openings_.push_back(std::move(opening));
  ++drains_;
}

std::vector<WallFlows::Water> WallFlows::look(MPI_Comm comm, const Particles& particles) {
  constexpr LocalId part_size = 4096;
  sums_.for_each([&](auto& sums) { sums.assign(2 * openings_.size(), 0); });
  for_each_part({0, particles.size()}, part_size, [&](Range part) {
    std::vector<GlobalId>& sums = sums_.mine();
    sums.resize(2 * openings_.size(), 0);
    for (LocalId i = part.begin; i < part.end; ++i) {
      const auto at = static_cast<std::size_t>(i);
      const Vec3& p = particles.position[at];
      for (std::size_t n = 0; n < openings_.size(); ++n) {
        const Opening& one = openings_[n];
        const int axis = one.wall.axis;
        const Real along = part_between(p[axis], one.from, one.to, spacing_);
        if (along == 0) continue;
        const Real part_of = along * part_between(p[1 - axis], one.seen[0], one.seen[1], spacing_);
        sums[2 * n] += std::llround(part_of / share);
        sums[2 * n + 1] += std::llround(part_of * particles.velocity[at][axis] / share);
      }
    }
  });
  sums_.mine().resize(2 * openings_.size(), 0);
  const std::vector<GlobalId> all = sum_over_threads_and_ranks(comm, sums_);
  std::vector<Water> found;
  for (std::size_t n = 0; n < openings_.size(); ++n) {
    const Real cubes = static_cast<Real>(all[2 * n]) * share, moved = static_cast<Real>(all[2 * n + 1]) * share;
    const Real volume = cubes * spacing_ * spacing_ * spacing_;
    const Opening& one = openings_[n];
    const Real level = one.space ? one.space->level(volume) : settings_.domain.min.z() + volume / one.area();
    found.push_back({level, cubes > 0 ? moved / cubes : 0});
  }
  return found;
}

void WallFlows::measure(MPI_Comm comm, const Particles& particles, const StepInfo& info, FlowState& state) {
  const std::vector<Water> water = look(comm, particles);
  for (std::size_t n = 0; n < openings_.size(); ++n) {
    if (openings_[n].inlet != nullptr) {
      drive_inlet(openings_[n], water[n], info, state.openings[n]);
    } else {
      drive_drain(openings_[n], water[n], info, state.openings[n]);
    }
  }
}

void WallFlows::drive_inlet(Opening& opening, const Water& water, const StepInfo& info,
                            FlowState::Opening& state) const {
  const InletSettings& inlet = *opening.inlet;
  const auto rows = static_cast<Real>(opening.speeds.size());
  const bool works = info.time >= inlet.start && info.time < inlet.stop;
  Real mean = 0;
  for (std::size_t row = 0; row < opening.speeds.size(); ++row) {
    const Real z = opening.bottom + (static_cast<Real>(row) + 0.5) * spacing_;
    opening.speeds[row] = works ? (inlet.profile ? std::max(inlet.profile->speed(z, info.time), 0.0) : inlet.speed) : 0;
    mean += opening.speeds[row] / rows;
  }
  if (!inlet.level || !works) return;
  const Real depth = std::max(opening.depth(*inlet.level), spacing_), wave = std::sqrt(gravity_ / depth);
  if (!state.known) state = {mean, water.level, 0, true};
  const Real limit = fastest * wave * depth, low = wave * (*inlet.level - water.level);
  const Real speed = std::clamp(state.speed + low, 0.0, limit);
  state.speed = std::clamp(state.speed + low * std::min(1.0, info.dt * wave / following_time), 0.0, limit);
  state.level = water.level;
  for (Real& of_row : opening.speeds) of_row = mean > 0 ? of_row * speed / mean : speed;
}

void WallFlows::drive_drain(Opening& opening, const Water& water, const StepInfo& info,
                            FlowState::Opening& state) const {
  const DrainSettings& drain = *opening.drain;
  const Real out = opening.wall.at_max ? water.speed : -water.speed;
  const Real deep = opening.depth(water.level);
  const Real depth = std::max(drain.level ? opening.depth(*drain.level) : deep, spacing_);
  const Real section = std::max(opening.section(water.level), spacing_ * opening.width());
  const Real wave = std::sqrt(gravity_ / depth);
  const Real limit = fastest * wave * depth + drain.flow.value_or(0) / section;
  const Real follow = std::min(1.0, info.dt * wave / following_time);
  if (!state.known) state = {std::max(out, 0.0), water.level, 0, true};
  const Real high = wave * (water.level - drain.level.value_or(state.level));
  if (drain.flow) {
    const Real particle = spacing_ * spacing_ * spacing_;
    state.owed += *drain.flow * info.dt / particle;
    state.speed = (*drain.flow + state.owed * particle * wave / following_time) / section;
    state.level += (water.level - state.level) * follow;
  }
  opening.speeds[0] = deep > 0 ? std::clamp(state.speed + high, 0.0, limit) : 0;
  if (drain.flow) {  // dropped where there is no water
    const Real layer = section / (spacing_ * spacing_);
    state.due = std::min(state.due + opening.speeds[0] * info.dt / spacing_ * layer, max_due * layer);
  }
  if (drain.level) {
    state.speed = std::clamp(state.speed + high * follow, 0.0, limit);
    state.level = water.level;
  }
}

std::vector<WallOpening> WallFlows::walls(Real dt) const {
  std::vector<WallOpening> walls;
  for (const Opening& one : openings_) {
    const bool inwards = one.inlet != nullptr;
    WallOpening wall{one.wall.axis, one.wall.at_max, one.across, one.bottom, spacing_, one.speeds, !inwards};
    if (!inwards) wall.row_height = one.top - one.bottom;
    for (Real& of_row : wall.displacement) of_row *= (inwards != one.wall.at_max ? 1 : -1) * dt;
    walls.push_back(std::move(wall));
  }
  return walls;
}

}  // namespace trevi
