#include "domain/cell_peers.hpp"

#include <algorithm>
#include <iterator>
#include <numeric>
#include <span>

namespace trevi {

namespace {

Range overlap(const Range& a, const Range& b) {
  const LocalId begin = std::max(a.begin, b.begin);
  return {begin, std::max(begin, std::min(a.end, b.end))};
}

bool is_empty(const CellWindow& window) { return window.planes.size() == 0 || window.rows.size() == 0; }

// The numbers of the pieces between cuts of planes or rows that may be adjacent to `own` on a level, in ascending
// order. The search starts at `own` and does not go through all pieces.
std::vector<int> near_pieces(std::span<const LocalId> cuts, int level, const Range& own, bool repeats) {
  const LocalId all = first_on_level(cuts.back(), level);
  // The first cut at or after a place.
  const auto cut_at = [&](LocalId place) {
    const auto before = [&](LocalId cut) { return first_on_level(cut, level) < place; };
    return static_cast<int>(std::partition_point(cuts.begin(), cuts.end(), before) - cuts.begin());
  };
  const int pieces = static_cast<int>(cuts.size()) - 1;
  const int first = std::max(cut_at(own.begin - 1) - 1, 0), end = std::min(cut_at(own.end + 2), pieces);
  std::vector<int> near(static_cast<std::size_t>(std::max(end - first, 0)));
  std::iota(near.begin(), near.end(), first);
  if (!repeats || (own.begin > 0 && own.end < all)) return near;
  for (int k = 0; k < std::min(cut_at(1), pieces); ++k) near.push_back(k);
  for (int k = std::max(cut_at(all) - 1, 0); k < pieces; ++k) near.push_back(k);
  std::sort(near.begin(), near.end());
  near.erase(std::unique(near.begin(), near.end()), near.end());
  return near;
}

// The cuts on one level.
class Level {
 public:
  Level(const CellCuts& cuts, int level, const std::array<bool, 2>& repeats)
      : cuts_(cuts), level_(level), repeats_(repeats) {
    const LocalId planes = cuts.planes.back(), rows = cuts.parts == 1 ? 1 : cuts.all_rows();
    all_ = {first_on_level(planes, level), first_on_level(rows, level)};
  }

  CellWindow window(int rank) const { return window_on_level(cuts_.window(rank), level_); }
  bool takes_part(int rank) const { return level_ == 0 || !is_empty(window_on_level(cuts_.window(rank), level_ - 1)); }
  // Calls visit(other) for the ranks whose windows may be adjacent to this one, in ascending order.
  template <class Visit>
  void for_each_near(const CellWindow& own, const Visit& visit) const {
    const std::size_t cuts_of_slab = static_cast<std::size_t>(cuts_.parts) + 1;
    for (const int slab : near_pieces(cuts_.planes, level_, own.planes, repeats_[0])) {
      const std::span rows = std::span(cuts_.rows).subspan(static_cast<std::size_t>(slab) * cuts_of_slab, cuts_of_slab);
      for (const int part : near_pieces(rows, level_, own.rows, repeats_[1])) visit(slab * cuts_.parts + part);
    }
  }
  // Calls visit(plane, row, planes, rows) for the existing zones around a window, with the cells of the box in them.
  template <class Visit>
  void for_each_zone(const CellWindow& own, const Visit& visit) const {
    for (const int plane : {-1, 0, 1}) {
      for (const int row : {-1, 0, 1}) {
        if ((plane == 0 && row == 0) || (row != 0 && cuts_.parts == 1)) continue;
        const Range planes = cells_of(0, plane, own.planes), rows = cells_of(1, row, own.rows);
        if (planes.size() > 0 && rows.size() > 0) visit(plane, row, planes, rows);
      }
    }
  }

 private:
  Range cells_of(std::size_t a, int side, const Range& own) const {
    if (side == 0) return own;
    LocalId cell = side < 0 ? own.begin - 1 : own.end;
    if (repeats_[a]) cell = (cell + all_[a]) % all_[a];
    return cell < 0 || cell >= all_[a] ? Range{} : Range{cell, cell + 1};
  }

  const CellCuts& cuts_;
  int level_;
  std::array<bool, 2> repeats_;
  std::array<LocalId, 2> all_;
};

}  // namespace

CellPeers cell_peers(const CellCuts& cuts, int rank, int level, const std::array<bool, 2>& repeats) {
  const Level on(cuts, level, repeats);
  const CellWindow own = on.window(rank);
  CellPeers peers;
  peers.rows = own.rows.size();
  peers.rows_are_cut = cuts.parts > 1;
  // Calls visit(plane, row, rows of the box) for the data that `receiver` needs from `sender`.
  const auto for_each_piece = [&](const CellWindow& receiver, const CellWindow& sender, const auto& visit) {
    on.for_each_zone(receiver, [&](int plane, int row, const Range& planes, const Range& rows) {
      const Range common = overlap(rows, sender.rows);
      if (overlap(sender.planes, planes).size() > 0 && common.size() > 0) visit(plane, row, common);
    });
  };
  const bool takes_part = on.takes_part(rank);
  on.for_each_near(own, [&](int other) {
    const CellWindow theirs = on.window(other);
    if (takes_part && !is_empty(theirs)) {
      for_each_piece(own, theirs, [&](int plane, int row, const Range& rows) {
        const LocalId first = row == 0 ? rows.begin - own.rows.begin : row < 0 ? -1 : own.rows.size();
        peers.from.push_back({other, plane, row, {first, first + rows.size()}});
      });
    }
    if (!is_empty(own) && on.takes_part(other)) {
      for_each_piece(theirs, own, [&](int plane, int row, const Range& rows) {
        const LocalId first = rows.begin - own.rows.begin;
        peers.to.push_back({other, plane, row, {first, first + rows.size()}});
      });
    }
  });
  return peers;
}

CellPeers upper_zones(const CellPeers& peers) {
  CellPeers upper = peers;
  for (auto* pieces : {&upper.from, &upper.to})
    std::erase_if(*pieces, [](const CellPiece& piece) { return piece.plane < 0 || piece.row < 0; });
  return upper;
}

}  // namespace trevi
