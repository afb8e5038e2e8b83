// Whom a rank exchanges cells with, against a look at every cell around its window, on all levels; and that what one
// expects is what the other sends.
#include <gtest/gtest.h>

#include <map>
#include <random>
#include <set>
#include <tuple>

#include "domain/cell_peers.hpp"

namespace trevi::test {
namespace {

constexpr int slab_count = 9;
constexpr LocalId all_planes = 31, all_rows = 17;

std::vector<LocalId> random_cuts(LocalId cells, int pieces, std::mt19937& random) {
  std::set<LocalId> cuts{0, cells};
  while (cuts.size() <= static_cast<std::size_t>(pieces))
    cuts.insert(static_cast<LocalId>(random() % static_cast<unsigned>(cells)));
  return {cuts.begin(), cuts.end()};
}

CellCuts random_slabs(int parts, unsigned seed) {
  std::mt19937 random(seed);
  CellCuts cuts{random_cuts(all_planes, slab_count, random), parts, {}};
  for (int k = 0; k < slab_count; ++k) {
    const auto rows = parts == 1 ? std::vector<LocalId>{0, 1} : random_cuts(all_rows, parts, random);
    cuts.rows.insert(cuts.rows.end(), rows.begin(), rows.end());
  }
  return cuts;
}

using Cell = std::tuple<int, LocalId, LocalId>;  // zone, plane, row of a level

LocalId wrapped(LocalId cell, LocalId all, bool repeats) {
  return repeats ? (cell + all) % all : cell < 0 || cell >= all ? -1 : cell;
}

/// Cells around the window of a rank on a level, and their owners.
std::map<Cell, int> cells_around(const CellCuts& cuts, int rank, int level, const std::array<bool, 2>& repeats) {
  const CellWindow own = window_on_level(cuts.window(rank), level);
  const LocalId planes = first_on_level(all_planes, level), rows = first_on_level(cuts.all_rows(), level);
  std::map<Cell, int> cells;
  for (LocalId k = own.planes.begin - 1; k <= own.planes.end; ++k) {
    for (LocalId r = own.rows.begin - 1; r <= own.rows.end; ++r) {
      const int plane = k < own.planes.begin ? -1 : k >= own.planes.end ? 1 : 0;
      const int row = r < own.rows.begin ? -1 : r >= own.rows.end ? 1 : 0;
      const LocalId at = wrapped(k, planes, repeats[0]), in = wrapped(r, rows, repeats[1]);
      if ((plane == 0 && row == 0) || at < 0 || in < 0 || (row != 0 && cuts.parts == 1)) continue;
      for (int other = 0; other < cuts.ranks(); ++other) {
        const CellWindow theirs = window_on_level(cuts.window(other), level);
        if (at >= theirs.planes.begin && at < theirs.planes.end && in >= theirs.rows.begin && in < theirs.rows.end)
          cells[{3 * (plane + 1) + row + 1, k, r}] = other;
      }
    }
  }
  return cells;
}

std::map<Cell, int> cells_of(const CellPeers& peers, const CellWindow& own) {
  std::map<Cell, int> cells;
  for (const CellPiece& piece : peers.from) {
    const Range planes = piece.plane < 0   ? Range{own.planes.begin - 1, own.planes.begin}
                         : piece.plane > 0 ? Range{own.planes.end, own.planes.end + 1}
                                           : own.planes;
    for (LocalId k = planes.begin; k < planes.end; ++k) {
      for (LocalId r = piece.rows.begin; r < piece.rows.end; ++r)
        EXPECT_TRUE(cells.insert({{piece.tag(), k, own.rows.begin + r}, piece.rank}).second) << "twice";
    }
  }
  return cells;
}

TEST(CellPeers, HaveTheCellsAround) {
  for (const int parts : {1, 2, 4}) {
    for (unsigned seed = 0; seed < 6; ++seed) {
      const CellCuts cuts = random_slabs(parts, seed);
      const std::array<bool, 2> repeats{seed % 2 == 1, parts > 1 && seed % 3 == 1};
      for (int level = 0; level < 6; ++level) {
        for (int rank = 0; rank < cuts.ranks(); ++rank) {
          const CellWindow own = window_on_level(cuts.window(rank), level);
          const CellWindow before = window_on_level(cuts.window(rank), std::max(level - 1, 0));
          const bool takes_part = before.planes.size() > 0 && before.rows.size() > 0;
          const auto expected = takes_part ? cells_around(cuts, rank, level, repeats) : std::map<Cell, int>{};
          EXPECT_EQ(cells_of(cell_peers(cuts, rank, level, repeats), own), expected)
              << parts << " parts, seed " << seed << ", level " << level << ", rank " << rank;
        }
      }
    }
  }
}

TEST(CellPeers, SendWhatTheOthersExpect) {
  const CellCuts cuts = random_slabs(4, 1);
  for (int level = 0; level < 6; ++level) {
    std::multiset<std::array<int, 4>> sent, expected;  // from, to, zone, rows
    for (int rank = 0; rank < cuts.ranks(); ++rank) {
      const CellPeers peers = cell_peers(cuts, rank, level, {true, true});
      for (const CellPiece& piece : peers.to) sent.insert({rank, piece.rank, piece.tag(), piece.rows.size()});
      for (const CellPiece& piece : peers.from) expected.insert({piece.rank, rank, piece.tag(), piece.rows.size()});
    }
    EXPECT_EQ(sent, expected) << "level " << level;
  }
}

}  // namespace
}  // namespace trevi::test
