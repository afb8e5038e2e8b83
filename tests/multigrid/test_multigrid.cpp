// The multigrid of the coarse grid: what a cycle leaves of an error does not depend on the depth, and no bit depends on
// the ranks, on where they are cut, on what is gathered or on the threads.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstring>

#include "base/threads.hpp"
#include "multigrid/multigrid.hpp"
#include "support/cloud.hpp"

namespace trevi::test {
namespace {

/// Water in a tank of cells, as uneven as it gets: a surface that slopes or is rough, and holes.
struct Lake {
  LocalId planes, rows, columns;
  LocalId depth, roughness;
  Real holes;
  Repeats repeats{};   // along planes and rows
  Range pocket{0, 0};  // planes whose water has no surface, and hardly any opening to the rest
  Real opening = 1;    // what is open at its two ends

  // A number in [0, 1) for each cell and purpose, whatever the rank.
  static Real chance(LocalId k, LocalId r, LocalId c, int purpose) {
    std::uint64_t x = (static_cast<std::uint64_t>(k) * 1000003 + static_cast<std::uint64_t>(r)) * 1000003 +
                      static_cast<std::uint64_t>(c) * 16 + static_cast<std::uint64_t>(purpose);
    for (int turn = 0; turn < 3; ++turn) x = (x ^ (x >> 31)) * 0x9E3779B97F4A7C15U + 1;
    return static_cast<Real>(x >> 11) * 0x1p-53;
  }
  bool is_inside(LocalId k, LocalId r, LocalId c) const {
    return k >= 0 && k < planes && r >= 0 && r < rows && c >= 0 && c < columns;
  }
  void wrap(LocalId& k, LocalId& r) const {
    if (repeats[0]) k = (k + planes) % planes;
    if (repeats[1]) r = (r + rows) % rows;
  }
  bool is_wet(LocalId k, LocalId r, LocalId c) const {
    wrap(k, r);
    if (!is_inside(k, r, c)) return false;
    const Real top = depth - std::floor(static_cast<Real>(roughness) * (chance(k, r, 0, 1) + k / Real(planes)) / 2);
    return c < top && chance(k, r, c, 2) >= holes;
  }
  Real link(int a, LocalId k, LocalId r, LocalId c) const {
    wrap(k, r);
    LocalId below[] = {k - (a == 0), r - (a == 1), c - (a == 2)};
    wrap(below[0], below[1]);
    if (!is_inside(k, r, c) || !is_inside(below[0], below[1], below[2])) return 0;
    const bool high = is_wet(k, r, c), low = is_wet(below[0], below[1], below[2]);
    const bool at_end = a == 0 && pocket.size() > 0 && (k == pocket.begin || k == pocket.end);
    if (high != low && k >= pocket.begin && k < pocket.end) return 0;
    if (at_end) return high && low ? 25 * opening : 0;
    if (high && low) return a == 2 ? 25 : 25 * (0.2 + chance(k, r, c, 3 + a));
    return high || low ? 25 / (0.05 + chance(k, r, c, 3 + a)) : 0;
  }
};

void fill(MultigridLevel& cells, const Lake& lake, LocalId k, LocalId r, LocalId c) {
  const LevelShape& shape = cells.shape();
  LocalId plane = k - 1 + shape.first;
  const std::size_t at = shape.index(k, r, c);
  r += shape.first_row;
  lake.wrap(plane, r);
  const bool wet = lake.is_wet(plane, r, c);
  cells.phi[at] = wet ? Lake::chance(plane, r, c, 7) - 0.5 : 0;
  cells.rhs[at] = wet ? 100 * (Lake::chance(plane, r, c, 8) - 0.5) : 0;
  cells.dirichlet[at] = 0;
  for (int a = 0; a < 3; ++a) {
    const LocalId step[] = {a == 0, a == 1, a == 2};
    const Real low = lake.link(a, plane, r, c), high = lake.link(a, plane + step[0], r + step[1], c + step[2]);
    const bool low_wet = lake.is_wet(plane - step[0], r - step[1], c - step[2]);
    cells.link[static_cast<std::size_t>(a)][at] = wet && low_wet ? low : 0;
    if (!wet) continue;
    if (!low_wet) cells.dirichlet[at] += low;
    if (!lake.is_wet(plane + step[0], r + step[1], c + step[2])) cells.dirichlet[at] += high;
  }
}

/// Own planes or rows of one of so many pieces: all the same, or as different as can be.
LocalId size_of_piece(LocalId all, int kind, int piece, int pieces) {
  if (kind == 0) return all * (piece + 1) / pieces - all * piece / pieces;
  const int large = kind == 1 ? 0 : pieces - 1;
  return piece == large ? all - (pieces - 1) : 1;
}

/// Slabs that `parts` ranks share, cut elsewhere in each.
CellCuts cuts_of(const Lake& lake, int kind, int ranks, int parts = 1) {
  const int slabs = ranks / parts;
  CellCuts cuts{{0}, parts, {}};
  for (int slab = 0; slab < slabs; ++slab) {
    cuts.planes.push_back(cuts.planes.back() + size_of_piece(lake.planes, kind, slab, slabs));
    cuts.rows.push_back(0);
    for (int part = 0; part < parts; ++part) {
      const LocalId rows = parts == 1 ? 1 : size_of_piece(lake.rows, (kind + slab) % 3, part, parts);
      cuts.rows.push_back(cuts.rows.back() + rows);
    }
  }
  return cuts;
}

/// A solver of a communicator, with its window of the lake.
struct Tank {
  Tank(MPI_Comm comm, const Lake& lake, const CellCuts& cuts, GlobalId gathered = 4096)
      : halo(comm, lake.repeats[0]), multigrid(comm, lake.repeats, gathered) {
    multigrid.resize(cuts, lake.rows, lake.columns, lake.depth);
    MultigridLevel& cells = multigrid.finest();
    // Where rows are cut what is beside the own cells comes from their owners, but for links of the plane above.
    const LocalId first = cells.shape().rows_are_cut() ? 1 : 0;
    for (LocalId k = first; k <= cells.shape().planes + 1; ++k)
      for (LocalId r = 0; r < cells.shape().rows; ++r)
        for (LocalId c = 0; c < lake.columns; ++c) fill(cells, lake, k, r, c);
  }
  /// All of the lake on this rank.
  explicit Tank(const Lake& lake) : Tank(MPI_COMM_SELF, lake, cuts_of(lake, 0, 1)) {}
  Halo halo;
  Multigrid multigrid;
};

/// sqrt(Σ phi A phi) of the equation without right-hand side, on one rank.
Real energy_norm(MultigridLevel& cells) {
  cells.find_residual();
  Real sum = 0;
  for (std::size_t at = 0; at < cells.phi.size(); ++at) sum -= cells.phi[at] * cells.next[at];
  return std::sqrt(sum);
}

/// The largest share of an error that one of six cycles leaves.
Real share_left(const Lake& lake) {
  Tank run(lake);
  MultigridLevel& cells = run.multigrid.finest();
  const bool among_solids = lake.pocket.size() > 0;
  std::fill(cells.rhs.begin(), cells.rhs.end(), 0.0);
  run.multigrid.solve(run.halo, 0, among_solids);
  Real largest = 0;
  for (int cycle = 0; cycle < 6; ++cycle) {
    const Real before = energy_norm(cells);
    run.multigrid.solve(run.halo, 1, among_solids);
    largest = std::max(largest, energy_norm(cells) / before);
  }
  return largest;
}

TEST(Multigrid, ACycleLeavesAFifthOfAnErrorAtAnyDepth) {
  for (const LocalId depth : {2, 8, 64, 512}) {
    SCOPED_TRACE(depth);
    EXPECT_LT(share_left({24, 20, depth + 2, depth, 0, 0}), 0.2);
    EXPECT_LT(share_left({5, 5, depth + 2, depth, 0, 0}), 0.2);
    EXPECT_LT(share_left({90, 2, depth + 2, depth, 0, 0}), 0.2);
    EXPECT_LT(share_left({1, 1, depth + 2, depth, 0, 0}), 1e-9);
    EXPECT_LT(share_left({24, 20, depth + 2, depth, depth / 2 + 1, 0}), 0.4);
    EXPECT_LT(share_left({24, 20, depth + 2, depth, depth / 2 + 1, 0.2}), 0.4);
  }
}

// With an even or an odd number of cells around, or so few that a cell is next to another on both sides.
TEST(Multigrid, ACycleLeavesAQuarterOfAnErrorWhereTheBoxRepeats) {
  for (const LocalId depth : {2, 8, 64}) {
    for (const Repeats repeats : {Repeats{true, false}, Repeats{false, true}, Repeats{true, true}}) {
      SCOPED_TRACE(depth);
      EXPECT_LT(share_left({24, 20, depth + 2, depth, 0, 0, repeats}), 0.2);
      EXPECT_LT(share_left({23, 13, depth + 2, depth, 0, 0, repeats}), 0.25);
      EXPECT_LT(share_left({3, 5, depth + 2, depth, 0, 0, repeats}), 0.25);
      EXPECT_LT(share_left({23, 21, depth + 2, depth, depth / 2 + 1, 0.2, repeats}), 0.4);
    }
  }
}

// Water that is connected to the rest by a small opening: with links that are halved on each level, the error of its
// mean grew by up to six times in a cycle, and now what is left of it falls more slowly than elsewhere.
TEST(Multigrid, NoErrorGrowsInAPocket) {
  for (const Real opening : {0.1, 0.02, 1e-3}) {
    for (const Range pocket : {Range{5, 11}, Range{6, 12}, Range{9, 16}}) {
      for (const LocalId rows : {1, 6}) {
        SCOPED_TRACE(opening);
        EXPECT_LT(share_left({24, rows, 12, 10, 0, 0, {}, pocket, opening}), 1);
      }
    }
  }
}

// Water up to the ceiling: nothing holds phi, and nothing grows.
TEST(Multigrid, AFullBoxIsHarmless) {
  for (const LocalId planes : {1, 9}) {
    const Lake lake{planes, planes, 12, 12, 0, 0};
    Tank run(lake);
    run.multigrid.solve(run.halo, 20);
    for (const Real phi : run.multigrid.finest().phi) EXPECT_LT(std::abs(phi), 1e4);
  }
}

void expect_same_as_alone(const Lake& lake, int kind, GlobalId gathered) {
  Tank many(world, lake, cuts_of(lake, kind, size_of(world)), gathered), one(lake);
  many.multigrid.solve(many.halo, 2, lake.pocket.size() > 0);
  one.multigrid.solve(one.halo, 2, lake.pocket.size() > 0);
  const MultigridLevel& mine = many.multigrid.finest();
  const auto first = static_cast<std::size_t>(mine.shape().first);
  const std::size_t plane = mine.shape().step(0), values = mine.phi.size();
  EXPECT_EQ(std::memcmp(mine.phi.data(), one.multigrid.finest().phi.data() + first * plane, values * sizeof(Real)), 0);
}

void expect_same_in_parts(const Lake& lake, int kind, GlobalId gathered, int parts) {
  const CellCuts cuts = cuts_of(lake, kind, size_of(world), parts);
  const LocalId planes = cuts.window(rank_of(world)).planes.size();
  const Range rows = cuts.window(rank_of(world)).rows;
  Tank many(world, lake, cuts, gathered), one(lake);
  many.multigrid.solve(many.halo, 2, lake.pocket.size() > 0);
  one.multigrid.solve(one.halo, 2, lake.pocket.size() > 0);
  const MultigridLevel &mine = many.multigrid.finest(), &all = one.multigrid.finest();
  for (LocalId k = 0; k < planes + 2; ++k) {
    for (LocalId r = -1; r <= rows.size(); ++r) {
      const Real* found = &mine.phi[mine.shape().index(k, r, 0)];
      const Real* expected = &all.phi[all.shape().index(k + mine.shape().first, r + rows.begin, 0)];
      ASSERT_EQ(std::memcmp(found, expected, static_cast<std::size_t>(lake.columns) * sizeof(Real)), 0)
          << "row " << r << " of plane " << k;
    }
  }
}

TEST(Multigrid, SameBitsWithCutsInSlabs) {
  for (int parts = 2; parts <= size_of(world); ++parts) {
    if (size_of(world) % parts != 0) continue;
    for (const LocalId planes : {5, 8, 23}) {
      for (const int kind : {0, 1, 2}) {
        for (const GlobalId gathered : {0, 100, 4096}) {
          SCOPED_TRACE(std::to_string(planes) + " planes, " + std::to_string(parts) + " parts, cuts " +
                       std::to_string(kind) + ", " + std::to_string(gathered));
          expect_same_in_parts({planes, 7, 14, 11, 6, 0.1}, kind, gathered, parts);
          expect_same_in_parts({planes, 20, 60, 50, 6, 0.1}, kind, gathered, parts);
          expect_same_in_parts({planes, 7, 14, 11, 6, 0.1, {true, true}}, kind, gathered, parts);
          expect_same_in_parts({planes, 12, 60, 50, 6, 0, {false, true}}, kind, gathered, parts);
          expect_same_in_parts({planes, 12, 14, 11, 6, 0, {}, {2, 4}, 0.02}, kind, gathered, parts);
        }
      }
    }
  }
}

TEST(Multigrid, SameBitsOnAnyRanksCutsAndThreads) {
  const int before = thread_count();
  for (const LocalId planes : {5, 8, 23, 64}) {
    for (const int kind : {0, 1, 2}) {
      for (const GlobalId gathered : {0, 100, 4096}) {
        SCOPED_TRACE(std::to_string(planes) + " planes, cuts " + std::to_string(kind) + ", " +
                     std::to_string(gathered));
        use_threads(1 + kind % 2 * 3 + (planes == 8 ? 1 : 0));
        expect_same_as_alone({planes, 7, 14, 11, 6, 0.1}, kind, gathered);
        expect_same_as_alone({planes, 1, 300, 290, 6, 0}, kind, gathered);
        expect_same_as_alone({planes, 7, 14, 11, 6, 0.1, {true, true}}, kind, gathered);
        expect_same_as_alone({planes, 4, 60, 50, 6, 0, {true, false}}, kind, gathered);
        expect_same_as_alone({planes, 7, 14, 11, 6, 0, {}, {2, 4}, 0.02}, kind, gathered);
      }
    }
  }
  use_threads(before);
}

TEST(Multigrid, SameBitsOnOneThreadAndFour) {
  const int before = thread_count();
  const Lake lake{40, 30, 40, 36, 12, 0.1};
  use_threads(1);
  Tank one(lake);
  one.multigrid.solve(one.halo, 2);
  for (const int threads : {2, 4}) {
    use_threads(threads);
    Tank many(lake);
    many.multigrid.solve(many.halo, 2);
    EXPECT_TRUE(std::ranges::equal(many.multigrid.finest().phi, one.multigrid.finest().phi));
  }
  use_threads(before);
}

}  // namespace
}  // namespace trevi::test
