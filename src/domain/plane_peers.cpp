#include "domain/plane_peers.hpp"

namespace trevi {

namespace {

bool owns_planes(std::span<const LocalId> cuts, int rank, int level) {
  const auto r = static_cast<std::size_t>(rank);
  return first_on_level(cuts[r], level) < first_on_level(cuts[r + 1], level);
}

bool takes_part(std::span<const LocalId> cuts, int rank, int level) {
  return level == 0 || owns_planes(cuts, rank, level - 1);
}

}  // namespace

// Of two neighbours that own planes there is at most one between them that takes part without any. In a ring the search
// ends at this rank itself at the latest, or where it owns none at another one.
PlanePeers peers_on_level(std::span<const LocalId> cuts, int rank, int level, bool ring) {
  PlanePeers peers;
  if (!takes_part(cuts, rank, level)) return peers;
  const int ranks = static_cast<int>(cuts.size()) - 1;
  const bool owns = owns_planes(cuts, rank, level);
  for (const int side : {0, 1}) {
    const auto s = static_cast<std::size_t>(side);
    const int step = side == 0 ? -1 : 1;
    std::size_t found = 0;
    for (int next = rank + step; ring || (next >= 0 && next < ranks); next += step) {
      const int other = (next + ranks) % ranks;
      if (owns && takes_part(cuts, other, level)) peers.to[s][found++] = other;
      if (!owns_planes(cuts, other, level)) continue;
      peers.from[s] = other;
      break;
    }
  }
  return peers;
}

}  // namespace trevi
