#include "domain/cell_peers.hpp"

#include <algorithm>
#include <iterator>

namespace trevi {

namespace {

Range overlap(const Range& a, const Range& b) {
  const LocalId begin = std::max(a.begin, b.begin);
  return {begin, std::max(begin, std::min(a.end, b.end))};
}

bool is_empty(const CellWindow& window) { return window.planes.size() == 0 || window.rows.size() == 0; }

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
  // Whether planes of two slabs may be next to one another.
  bool are_near(const Range& a, const Range& b) const {
    const auto is_at_end = [&](const Range& planes) { return planes.begin == 0 || planes.end == all_[0]; };
    return overlap({a.begin - 1, a.end + 1}, {b.begin - 1, b.end + 1}).size() > 0 ||
           (repeats_[0] && is_at_end(a) && is_at_end(b));
  }
  // visit(plane, row, planes, rows) for the zones around a window that there are: which cells of the box they hold.
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
  // What `receiver` needs of `sender`: visit(plane, row, rows of the box).
  const auto for_each_piece = [&](const CellWindow& receiver, const CellWindow& sender, const auto& visit) {
    on.for_each_zone(receiver, [&](int plane, int row, const Range& planes, const Range& rows) {
      const Range common = overlap(rows, sender.rows);
      if (overlap(sender.planes, planes).size() > 0 && common.size() > 0) visit(plane, row, common);
    });
  };
  const bool takes_part = on.takes_part(rank);
  for (int slab = 0; slab < cuts.slabs(); ++slab) {
    if (!on.are_near(on.window(slab * cuts.parts).planes, own.planes)) continue;
    for (int other = slab * cuts.parts; other < (slab + 1) * cuts.parts; ++other) {
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
    }
  }
  return peers;
}

CellPeers upper_zones(const CellPeers& peers) {
  CellPeers upper = peers;
  for (auto* pieces : {&upper.from, &upper.to})
    std::erase_if(*pieces, [](const CellPiece& piece) { return piece.plane < 0 || piece.row < 0; });
  return upper;
}

}  // namespace trevi
