// Which ranks exchange cells with each other on the levels of a multigrid; level 0 is the cells themselves. A rank
// needs the cells around its window. They lie in eight zones: the planes before and after its own, the rows before and
// after, and four corners. Planes 2m and 2m + 1 of a level form plane m of the next, counted from the start of the box,
// and so do rows, so that levels do not depend on the ranks. The owner of cell (2m, 2n) owns (m, n). On coarse levels
// some ranks own no cells. A rank that still owned cells on the previous level takes part: it receives the cells around
// the place where its own would be. Not collective.
#pragma once

#include <vector>

#include "domain/cell_cuts.hpp"

namespace trevi {

/// The part of a zone that one other rank owns: cells of one plane, or of one row of each owned plane.
struct CellPiece {
  int rank;
  int plane, row;  ///< the zone as seen by the receiver: −1 before its own planes or rows, 1 after, 0 beside these
  Range rows;      ///< counted from the first row of the rank that holds this object
  int tag() const { return 3 * (plane + 1) + row + 1; }
};

struct CellPeers {
  std::vector<CellPiece> from, to;
  LocalId rows = 0;           ///< owned rows
  bool rows_are_cut = false;  ///< if not, planes are sent whole, including the cells around their rows
};

/// Only the peers of the zones at the upper sides.
CellPeers upper_zones(const CellPeers& peers);

/// The plane or row of `level` that begins at `place` of level 0, or the first one after it.
inline LocalId first_on_level(LocalId place, int level) {
  return static_cast<LocalId>((GlobalId{place} + (GlobalId{1} << level) - 1) >> level);
}
inline CellWindow window_on_level(const CellWindow& window, int level) {
  const auto on_level = [level](const Range& range) {
    return Range{first_on_level(range.begin, level), first_on_level(range.end, level)};
  };
  return {on_level(window.planes), on_level(window.rows)};
}

/// `repeats`: whether the first plane, or row, is next to the last.
CellPeers cell_peers(const CellCuts& cuts, int rank, int level, const std::array<bool, 2>& repeats);

}  // namespace trevi
