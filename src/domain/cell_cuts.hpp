// The cuts of the cells of the box into windows, one for each rank: into slabs of planes, and each slab, with cuts of
// its own, into the same number of runs of rows. Rank p Q + q owns run q of slab p. Every rank knows all cuts.
#pragma once

#include <vector>

#include "particles/cell_grid.hpp"

namespace trevi {

struct CellCuts {
  std::vector<LocalId> planes;  // the first plane of each slab, and one past the last plane of all
  int parts = 1;                // number of runs of rows of each slab
  std::vector<LocalId> rows;    // for each slab the first row of each run, and the number of rows; 0, 1 if parts is 1

  int slabs() const { return static_cast<int>(planes.size()) - 1; }
  int ranks() const { return slabs() * parts; }
  CellWindow window(int rank) const {
    const auto slab = static_cast<std::size_t>(rank / parts);
    const auto row = slab * (static_cast<std::size_t>(parts) + 1) + static_cast<std::size_t>(rank % parts);
    return {{planes[slab], planes[slab + 1]}, {rows[row], rows[row + 1]}};
  }
  /// The same for planes of `all_rows` rows, all of which are in the window if slabs are not cut.
  CellWindow window(int rank, LocalId all_rows) const {
    const CellWindow cut = window(rank);
    return {cut.planes, parts == 1 ? Range{0, all_rows} : cut.rows};
  }
  LocalId all_rows() const { return rows.back(); }
  bool operator==(const CellCuts&) const = default;
};

}  // namespace trevi
