// What cells beside solids hold when they are full. Particles fill cells as cuboids (particles_to_grid.hpp), which
// reach into a solid beside them, and out of it nothing reaches back. So the fill of a cell is what its particles say
// over what uniform water would say: the integral, over what is open of it and of the cells around, of the share that a
// cuboid there has in it (the normalisation of Shepard, Proc. ACM Nat. Conf. 1968). With the open volume in its place
// the level beside a wall is too low by what lies in the solid.
#include <algorithm>

#include "projection/cut_cells.hpp"

namespace trevi {

namespace {

// The shares along direction a in the cell below (0), itself (1) and the one above (2).
constexpr std::size_t number_of(std::size_t i, std::size_t j, std::size_t k) { return 9 * i + 3 * j + k; }

}  // namespace

// Not cleared: there is memory for those that are written.
void CutCells::store_shares(std::size_t cells) {
  if (shares_size_ == cells) return;
  shares_size_ = cells;
  shares_.reset(cells > 0 ? new Shares[cells] : nullptr);
}

// Of a cuboid at `place`, in cells from the corner of its cell, which is `corner` cells from that of the box.
CutCells::SharesAlong CutCells::shares_along(std::size_t a, Real place, Real corner) const {
  const auto b = static_cast<std::size_t>(axis_[a]);
  const Real low = frame_.half[0][b], high = frame_.half[1][b];
  const Real middle = std::min(std::max(place, frame_.nearest[b] - corner), frame_.farthest[b] - corner);
  const Real below = std::clamp((low - middle) * (0.5 / low), 0.0, 1.0);
  const Real above = std::clamp((middle + (high - 1)) * (0.5 / high), 0.0, 1.0);
  return {below, 1 - below - above, above};
}

// Where the middle of a cuboid that would reach down, or up, into a solid lies when the cuboid lies on it, or beneath,
// in cells upwards, as `height` is; distance of the solid and its slope upwards, in samples.
Real CutCells::off_solid(Real height, Real distance, Real slope) const {
  const Real way = std::max(distance, 0.0), steep = std::abs(slope) * samples;  // the solid is way/steep below or above
  const Real half = frame_.half[slope > 0 ? 0 : 1][2];
  if (way >= half * steep) return height;
  const Real missing = half - way / steep;
  return slope > 0 ? height + missing : height - missing;
}

// In the mean over a cell, in the first cells along each direction, in others and in the last ones.
void CutCells::find_whole_shares(const ProjectionGrid& grid) {
  for (std::size_t a = 0; a < 3; ++a) {
    const std::array<LocalId, 3> corners{0, 1, grid.count(a) - 1};
    for (std::size_t n = 0; n < 3; ++n) {
      whole_shares_[a][n] = {};
      for (int k = 0; k < samples; ++k) {
        const SharesAlong one = shares_along(a, sample(k), corners[n]);
        for (std::size_t i = 0; i < 3; ++i) whole_shares_[a][n][i] += one[i] / samples;
      }
    }
  }
}

CellFrame CutCells::beside_sheets(const CellFrame& frame, const ProjectionGrid& grid,
                                  const std::array<LocalId, 3>& cell) const {
  CellFrame narrowed = frame;
  const std::size_t at = grid.index(cell[0], cell[1], cell[2]);
  const CellPlace place = grid.place_of(cell[0], cell[1], cell[2]);
  for (std::size_t a = 0; a < 3; ++a) {
    const std::size_t b = grid.axis(a), step = grid.step(a);
    const Real corner = place.corner[b];
    if (face(a, at) == 0 && open(at - step) > 0)
      narrowed.nearest[b] = std::max(frame.nearest[b], corner + frame.half[0][b]);
    if (face(a, at + step) == 0 && open(at + step) > 0)
      narrowed.farthest[b] = std::min(frame.farthest[b], corner + (1 - frame.half[1][b]));
  }
  return narrowed;
}

// What is open of a cell, as it is shared among the cells around: the share of the one with that number.
Real CutCells::share_of(const ProjectionGrid& grid, const std::array<LocalId, 3>& cell, std::size_t wanted,
                        const std::vector<Cell>& cells) const {
  const LocalId k = cell[0], r = grid.row_beside(cell[1]), columns = grid.columns();
  const LocalId c = grid.repeats()[2] ? (cell[2] + columns) % columns : cell[2];
  const std::size_t at = grid.index(k, r, c);
  const bool above_columns = c >= columns;
  if (!above_columns && cells[at].open == 0) return 0;
  const bool own = !above_columns && cells[at].has_shares;
  std::array<SharesAlong, 3> mean;
  if (!own) {
    const std::array<Real, 3> place = from_box(corner_of(grid, k, r, c));
    for (std::size_t a = 0; a < 3; ++a)
      mean[a] = whole_shares_[a][place[a] == 0 ? 0 : place[a] == grid.count(a) - 1 ? 2 : 1];
  }
  const auto share = [&](std::size_t n) {
    return own ? shares_[at][n] : static_cast<float>(mean[0][n / 9] * mean[1][n / 3 % 3] * mean[2][n % 3]);
  };
  if (above_columns) return share(wanted);
  // A cuboid that would reach through a sheet stays in its own cell.
  std::array<std::array<bool, 2>, 3> sheet;
  bool any = false;
  for (std::size_t a = 0; a < 3; ++a) {
    const std::size_t step = grid.step(a);
    const bool has_below = (a != 0 || k > 0) && (a != 1 || r >= 0);
    const bool has_above = (a != 0 || k <= grid.planes()) && (a != 1 || r < grid.rows());
    sheet[a] = {has_below && cells[at].face[a] == 0 && cells[at - step].open > 0,
                has_above && cells[at + step].face[a] == 0 && cells[at + step].open > 0};
    any = any || sheet[a][0] || sheet[a][1];
  }
  if (!any) return share(wanted);
  Shares shares;
  for (std::size_t n = 0; n < shares.size(); ++n) shares[n] = share(n);
  constexpr std::array<std::size_t, 3> weight{9, 3, 1};
  for (std::size_t a = 0; a < 3; ++a) {
    for (std::size_t n = 0; n < shares.size(); ++n) {
      const std::size_t side = n / weight[a] % 3;
      if (side == 1 || !sheet[a][side / 2]) continue;
      shares[side == 0 ? n + weight[a] : n - weight[a]] += shares[n];
      shares[n] = 0;
    }
  }
  return shares[wanted];
}

Real CutCells::capacity_of(const ProjectionGrid& grid, const std::array<LocalId, 3>& cell,
                           const std::vector<Cell>& cells) const {
  const auto [k, r, c] = cell;
  const auto is_beyond = [&](std::size_t a, LocalId offset) {
    std::array<LocalId, 3> above = cell;
    if (offset > 0) ++above[a];
    return offset != 0 && grid.is_wall(a, above[0], above[1], above[2]);
  };
  Real sum = 0;
  for (LocalId i = -1; i <= 1; ++i) {
    for (LocalId j = -1; j <= 1; ++j) {
      for (LocalId l = -1; l <= 1; ++l) {
        if (is_beyond(0, i) || is_beyond(1, j) || is_beyond(2, l)) continue;
        const auto side = [](LocalId offset) { return static_cast<std::size_t>(1 - offset); };
        sum += share_of(grid, {k + i, r + j, c + l}, number_of(side(i), side(j), side(l)), cells);
      }
    }
  }
  return sum;
}

void CutCells::measure_capacities(const ProjectionGrid& grid, const std::vector<Zone>& zones,
                                  std::vector<Cell>& cells) {
  find_whole_shares(grid);
  for_each_row_near(grid, zones, [&](LocalId k, LocalId r, const Candidates&, Range columns) {
    if (k < 1 || k > grid.planes() || r < 0 || r >= grid.rows()) return;  // who owns the others knows them
    for (LocalId c = columns.begin; c < columns.end; ++c) {
      const std::size_t at = grid.index(k, r, c);
      bool whole = true;
      for (std::size_t n = 0; n < 27 && whole; ++n) {
        const std::size_t beside =
            at + (n / 9) * grid.step(0) + (n / 3 % 3) * grid.step(1) + n % 3 - grid.step(0) - grid.step(1) - 1;
        const Cell& one = cells[beside];
        whole = one.open == 1 && one.face[0] == 1 && one.face[1] == 1 && one.face[2] == 1;
      }
      cells[at].capacity = whole ? 1 : static_cast<float>(capacity_of(grid, {k, r, c}, cells));
    }
  });
}

}  // namespace trevi
