// Determines which particles leave through the drains in walls.
#include <algorithm>
#include <cmath>
#include <utility>

#include "parallel/reductions.hpp"
#include "solver/wall_flows.hpp"

namespace trevi {

namespace {

constexpr Real taken_before = 0.25;  // spacings from the wall at which a particle leaves by a drain that holds a level
constexpr Real reached = 1;          // spacings: up to here the nearest particles leave by a drain with a flow

}  // namespace

// Distance of the particle from the wall at the end of the substep, m; none if it does not leave through the drain.
std::optional<Real> WallFlows::distance_left(const Opening& one, const Vec3& position, const Vec3& velocity,
                                             Real dt) const {
  const int axis = one.wall.axis, other = 1 - axis;
  const Real sign = one.wall.at_max ? 1 : -1,
             wall = one.wall.at_max ? settings_.domain.max[axis] : settings_.domain.min[axis];
  const Real speed = sign * velocity[axis], left = sign * (wall - position[axis]) - speed * dt;
  const Real reach = (one.drain->flow ? reached : taken_before) * spacing_;
  const bool leaves = one.speeds[0] > 0 && speed > 0 && left < reach && position[other] >= one.across[0] &&
                      position[other] <= one.across[1] && position.z() >= one.bottom && position.z() <= one.top;
  return leaves ? std::optional(left) : std::nullopt;
}

// The first particles over all ranks, up to the number that is due: no rank alone knows which of its own are among
// them.
std::vector<WallFlows::Leaving> WallFlows::first_of_all(MPI_Comm comm, std::vector<Leaving> mine, GlobalId due) {
  const auto sorted_until_due = [&](std::vector<Leaving>& all) {
    std::sort(all.begin(), all.end());
    if (std::cmp_greater(all.size(), due)) all.resize(static_cast<std::size_t>(due));
  };
  sorted_until_due(mine);
  std::vector<Leaving> all = gather_over_ranks(comm, mine);
  sorted_until_due(all);
  return all;
}

std::vector<LocalId> WallFlows::leaving(MPI_Comm comm, const Particles& particles, Real dt, FlowState& state) const {
  std::vector<LocalId> gone;
  for (std::size_t n = openings_.size() - drains_; n < openings_.size(); ++n) {
    const Opening& one = openings_[n];
    const GlobalId due = one.drain->flow ? static_cast<GlobalId>(std::max(0.0, std::floor(state.openings[n].due))) : 0;
    if (one.drain->flow && due == 0) continue;  // on all ranks
    std::vector<Leaving> mine;
    for (std::size_t i = 0; i < particles.id.size(); ++i) {
      const auto left = distance_left(one, particles.position[i], particles.velocity[i], dt);
      if (left && one.drain->flow) mine.push_back({*left, particles.id[i], static_cast<LocalId>(i), rank_of(comm)});
      if (left && !one.drain->flow) gone.push_back(static_cast<LocalId>(i));
    }
    if (!one.drain->flow) continue;
    const std::vector<Leaving> first = first_of_all(comm, std::move(mine), due);
    for (const Leaving& particle : first) {
      if (particle.rank == rank_of(comm)) gone.push_back(particle.local);
    }
    state.openings[n].owed -= static_cast<Real>(first.size());
    state.openings[n].due -= static_cast<Real>(first.size());
  }
  std::sort(gone.begin(), gone.end());
  gone.erase(std::unique(gone.begin(), gone.end()), gone.end());
  return gone;
}

}  // namespace trevi
