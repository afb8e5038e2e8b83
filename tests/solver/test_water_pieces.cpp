// The connected pieces of water that are not touched along all axes against a flood over the cells of all particles:
// which particles are of a piece, along which axes it is touched, and that what the ranks have of a piece together is
// all of it, wherever cuts are and axes repeat.
#include "solver/water_pieces.hpp"

#include <map>
#include <set>

#include "support/distributed.hpp"

namespace trevi::test {
namespace {

using Cell = WaterPieces::Cell;

// Along all axes beside a ball, along one each beyond planes.
WaterPieces::Axes touched(const Vec3& p) {
  if ((p - Vec3(0.5, 0.7, 0.6)).norm() < 0.12) return WaterPieces::all_axes;
  return static_cast<WaterPieces::Axes>((p.x() < 0.3 ? 1 : 0) | (p.y() > 0.75 ? 2 : 0) | (p.z() < 0.3 ? 4 : 0));
}

struct Piece {
  Cell first;
  WaterPieces::Axes touched;
  bool operator==(const Piece&) const = default;
};

/// Of each particle its piece; none where that is touched along all axes.
std::map<GlobalId, std::optional<Piece>> flooded(const Cloud& all, const CellGrid& grid) {
  std::map<Cell, std::vector<std::size_t>> members;
  for (std::size_t i = 0; i < all.id.size(); ++i) {
    const Vec3& p = all.position[i];
    members[{grid.plane_of(p), grid.row_of(p), grid.column_of(p)}].push_back(i);
  }
  std::map<GlobalId, std::optional<Piece>> pieces;
  std::set<Cell> seen;
  for (const auto& [start, unused] : members) {  // in their order, so that it is the first of its piece
    if (!seen.insert(start).second) continue;
    std::vector<Cell> piece{start};
    WaterPieces::Axes axes = 0;
    for (std::size_t n = 0; n < piece.size(); ++n) {
      for (const std::size_t i : members[piece[n]]) axes |= touched(all.position[i]);
      for (int k = 0; k < 27; ++k) {
        Cell beside = piece[n];
        const std::array<int, 3> way{k / 9 - 1, k / 3 % 3 - 1, k % 3 - 1};
        for (std::size_t a = 0; a < 3; ++a) {
          beside[a] += way[a];
          if (grid.is_periodic(a)) beside[a] = (beside[a] + grid.count(a)) % grid.count(a);
        }
        if (members.contains(beside) && seen.insert(beside).second) piece.push_back(beside);
      }
    }
    for (const Cell& cell : piece)
      for (const std::size_t i : members[cell])
        pieces[all.id[i]] = axes != WaterPieces::all_axes ? std::optional(Piece{start, axes}) : std::nullopt;
  }
  return pieces;
}

void expect_pieces(const Cloud& all, const CellGrid& grid, int parts) {
  const auto expected = flooded(all, grid);
  std::map<Cell, GlobalId> sizes;
  for (const auto& [id, first] : expected)
    if (first) ++sizes[first->first];
  const Slabs slabs = even_slabs(grid, parts);
  Particles particles = particles_of(all);
  migrate(world, particles, &Particles::predicted, grid, slabs);
  Neighbourhood<double> near(world, grid, cloud_box.min, radius);
  near.rebuild(particles, slabs);
  WaterPieces pieces;
  const bool any = pieces.find(
      world, near.order(), near.scratch(), [&](std::size_t i) { return touched(particles.predicted[i]); },
      [&](WaterPieces::Labels& labels) { near.exchange(labels); });
  EXPECT_EQ(any, !sizes.empty());
  std::map<GlobalId, std::optional<Piece>> found;
  for (const GlobalId id : particles.id) found[id] = std::nullopt;
  std::vector<GlobalId> own(pieces.count(), 0);
  for (const auto& [range, piece] : pieces.runs()) {
    own[piece] += range.size();
    for (LocalId i = range.begin; i < range.end; ++i)
      found[particles.id[static_cast<std::size_t>(i)]] = Piece{pieces.first_cell(piece), pieces.touched(piece)};
  }
  for (const auto& [id, one] : found) EXPECT_TRUE(one == expected.at(id)) << id;
  std::vector<GlobalId> shared(own.begin(), own.begin() + static_cast<std::ptrdiff_t>(pieces.shared()));
  GlobalId ways[2] = {static_cast<GlobalId>(shared.size()), -static_cast<GlobalId>(shared.size())};
  MPI_Allreduce(MPI_IN_PLACE, ways, 2, MPI_INT64_T, MPI_MIN, world);
  ASSERT_EQ(ways[0], -ways[1]) << "not the same ones on all ranks";
  MPI_Allreduce(MPI_IN_PLACE, shared.data(), static_cast<int>(shared.size()), MPI_INT64_T, MPI_SUM, world);
  std::copy(shared.begin(), shared.end(), own.begin());
  for (std::size_t piece = 0; piece < pieces.count(); ++piece)
    EXPECT_EQ(own[piece], sizes[pieces.first_cell(piece)]) << "piece " << piece;
}

// Sparse ones fall into many pieces, which wind through several slabs; dense ones hang together.
TEST(WaterPieces, AreThoseOfAFlood) {
  for (const std::array<bool, 3>& periodic : {std::array{false, false, false},
                                              {true, false, false},
                                              {false, true, false},
                                              {false, false, true},
                                              {true, true, true}}) {
    for (const int slab_axis : {0, 1}) {
      const std::array<bool, 3> by_direction{periodic[slab_axis == 0 ? 0 : 1], periodic[slab_axis == 0 ? 1 : 0],
                                             periodic[2]};
      const Box box{cloud_box.min, cloud_box.min + radius * Vec3(8, 6, 6)};
      const CellGrid grid(box.min, box.max, radius, slab_axis, periodic);
      for (std::size_t a = 0; a < 3; ++a) ASSERT_EQ(grid.is_periodic(a), by_direction[a]);
      for (const int parts : parts_of_slabs(grid)) {
        for (const int count : {0, 1, 12, 30, 50, 400}) {
          SCOPED_TRACE(testing::PrintToString(periodic) + ", " + std::to_string(count) + " particles, " +
                       std::to_string(parts) + " ranks a slab");
          expect_pieces(random_cloud(count, box, 1), grid, parts);
        }
      }
    }
  }
}

}  // namespace
}  // namespace trevi::test
