#include "solver/check_flow.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "fluid/forcings/inlet.hpp"
#include "fluid/forcings/music_kind.hpp"
#include "solver/demand.hpp"
#include "solver/density_solver.hpp"
#include "solver/wall_flows.hpp"

namespace trevi {

namespace {

constexpr Real highest_speed = 1e4;  // m/s, as in scenes
constexpr Real max_places = 1e8;     // of an opening
constexpr int channels = 16, max_rate = 1'000'000;

void demand_in_wall(const std::optional<WallRefusal>& refusal, const std::string& name) {
  if (refusal) demand(false, name + refusal->key + ": " + refusal->why);
}

void check_music(const MusicSettings& music, const std::string& name) {
  demand(music.kind.given(), name + "music.source must end in one of " + endings_of_music() + ", or be \"-\"");
  demand(music.track >= 0 && music.channel >= 0 && music.channel <= channels,
         name + "music.track must not be negative, music.channel from 0 to 16");
  demand(music.rate >= 1000 && music.rate <= max_rate, name + "music.rate must be from 1000 to 1000000 Hz");
  const auto [low, high] = music.speed_range;
  demand(low >= 0 && low < high && high <= highest_speed,
         name + "music.speed_range must increase, from 0 m/s on to 10000 m/s");
}

void check_pump(const PumpSettings& pump, const std::string& name) {
  demand(is_direction(pump.direction), name + "direction must have a length");
  demand(pump.speed >= 0 && pump.speed <= highest_speed && pump.jitter >= 0 && pump.jitter <= highest_speed,
         name + "speed and jitter must be from 0 to 10000 m/s");
  demand(pump.start >= 0 && pump.stop > pump.start, name + "start must not be negative, and stop later");
  if (pump.music) check_music(*pump.music, name);
}

void check_live_sound(const Settings& all) {
  int rate = 0;
  const auto look = [&](const PumpSettings& pump) {
    if (!pump.music || pump.music->kind != MusicKind::live) return;
    demand(rate == 0 || rate == pump.music->rate, "music.rate must be the same for all that follow standard input");
    rate = pump.music->rate;
  };
  std::for_each(all.fountains.begin(), all.fountains.end(), look);
  std::for_each(all.inlets.begin(), all.inlets.end(), look);
}

void check_fountain(const Settings& all, const FountainSettings& one, const std::string& name) {
  check_pump(one, name);
  demand(all.domain.contains({one.center[0], one.center[1], all.domain.min.z()}), name + "center must be on the floor");
  demand(is_positive(one.diameter) && is_positive(one.height), name + "diameter and height must be positive");
}

// The inlet does not see water beyond the ends of a periodic axis, and makes none there.
void check_room(const Settings& all, const InletSettings& inlet, const std::string& name) {
  const Vec3 reach = InletLattice(inlet, all.fluid.spacing).reach();
  demand(all.domain.contains(inlet.center - reach) && all.domain.contains(inlet.center + reach),
         name + "center: the opening must be in the box");
  for (int a = 0; a < 3; ++a) {
    const Real low = inlet.center[a] - all.domain.min[a], high = all.domain.max[a] - inlet.center[a];
    demand(!all.periodic[static_cast<std::size_t>(a)] || std::min(low, high) - reach[a] >= 2 * all.fluid.kernel_radius,
           name + "center: the opening must be two kernel radii from the ends of a periodic axis");
  }
}

void check_inlet(const Settings& all, const InletSettings& one, const std::string& name) {
  check_pump(one, name);
  demand(one.center.allFinite(), name + "center must be finite");
  demand(one.shape != InletShape::disc || is_positive(one.radius), name + "radius must be positive");
  demand(one.shape != InletShape::rectangle || (is_positive(one.size[0]) && is_positive(one.size[1])),
         name + "size must be positive");
  demand(InletLattice::places_of(one, all.fluid.spacing) <= max_places, name + "radius or size is too large");
  demand(!one.flow || is_amount(*one.flow), name + "flow must not be negative");
  demand(!one.recycle || !all.drains.empty(), name + "recycle needs a drain");
  InletSettings unit = one;
  unit.direction.stableNormalize();
  check_room(all, unit, name);
  demand_in_wall(why_not_in_wall(unit, all), name);
}

void check_drain(const Settings& all, const DrainSettings& one, const std::string& name) {
  demand_in_wall(why_not_in_wall(one, all), name);
  if (one.shape == DrainShape::box) {
    demand(one.min.allFinite() && one.max.allFinite() && (one.max.array() > one.min.array()).all(),
           name + "max must be greater than min on every axis");
    return;
  }
  demand(one.center.allFinite(), name + "center must be finite");
  demand(is_direction(one.axis), name + "axis must have a length");
  demand(one.shape != DrainShape::cylinder || (is_positive(one.radius) && is_positive(one.height)),
         name + "radius and height must be positive");
}

// A vector whose length is 1 up to rounding is not changed, so that a scene keeps its bits.
void normalise(Vec3& direction) {
  constexpr Real rounding = 1e-12;
  if (std::abs(direction.squaredNorm() - 1) > rounding) direction.stableNormalize();
}

}  // namespace

void check_flow(const Settings& all) {
  for (std::size_t k = 0; k < all.fountains.size(); ++k)
    check_fountain(all, all.fountains[k], fmt::format("fountains[{}].", k));
  for (std::size_t k = 0; k < all.inlets.size(); ++k) {
    const std::string name = fmt::format("inlets[{}].", k);
    check_inlet(all, all.inlets[k], name);
    demand_in_wall(why_not_beside(all.inlets[k], std::span(all.inlets).first(k), all), name);
  }
  for (std::size_t k = 0; k < all.drains.size(); ++k) {
    const std::string name = fmt::format("drains[{}].", k);
    check_drain(all, all.drains[k], name);
    demand_in_wall(why_not_beside(all.drains[k], std::span(all.drains).first(k), all), name);
  }
  check_live_sound(all);
  const auto in_wall = [](const auto& one) { return one.is_in_wall(); };
  demand((std::none_of(all.inlets.begin(), all.inlets.end(), in_wall) &&
          std::none_of(all.drains.begin(), all.drains.end(), in_wall)) ||
             (all.density.coarse_grid && is_downward(all.gravity.value_or(Vec3::Zero()))),
         "a profile or a level of an inlet, and a level or a flow of a drain, need density.coarse_grid and gravity "
         "along -z");
}

void resolve_flow(Settings& all) {
  const Real spacing = all.fluid.spacing;
  for (FountainSettings& fountain : all.fountains) normalise(fountain.direction);
  for (DrainSettings& drain : all.drains) normalise(drain.axis);
  for (InletSettings& inlet : all.inlets) {
    normalise(inlet.direction);
    if (inlet.profile)
      inlet.speed = mean_speed(inlet, static_cast<Real>(InletLattice(inlet, spacing).rows()), spacing, 0);
    if (inlet.flow) inlet.speed = speed_of_flow(*inlet.flow, InletLattice(inlet, spacing), spacing);
  }
}

}  // namespace trevi
