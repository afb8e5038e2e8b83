// The capacity of cells beside solids: what they hold when they are full. The volume of particles is distributed
// (particles_to_grid.hpp) and extends into a solid beside them, out of which nothing extends back. The fill of a cell
// is therefore the contribution of its particles over that of uniform water. The latter is the integral, over the open
// parts of the cell and of the cells around it, of the share that a particle there has in it (the normalisation of
// Shepard, Proc. ACM Nat. Conf. 1968). With the open volume instead, the level beside a wall would be too low by what
// lies in the solid.
#include <algorithm>
#include <utility>

#include "projection/cut_cells.hpp"

namespace trevi {

namespace {

// The shares along direction a in the cell below (0), in the cell itself (1) and in the one above (2).
constexpr std::size_t number_of(std::size_t i, std::size_t j, std::size_t k) { return 9 * i + 3 * j + k; }

template <std::size_t n>
using Constant = std::integral_constant<std::size_t, n>;

}  // namespace

// Not cleared: memory is used only for cells that are written.
void CutCells::store_shares(std::size_t cells) {
  if (shares_size_ == cells) return;
  shares_size_ = cells;
  shares_.reset(cells > 0 ? new Shares[cells] : nullptr);
}

// The shares of a particle at `place`, in cells from the corner of its cell, which is `corner` cells from that of the
// box.
CutCells::SharesAlong CutCells::shares_along(std::size_t a, Real place, Real corner) const {
  const auto b = static_cast<std::size_t>(axis_[a]);
  const Real flat = frame_.flat[b], reach = frame_.reach[b];
  const Real middle = std::min(std::max(place, frame_.nearest[b] - corner), frame_.farthest[b] - corner);
  const auto square_above_zero = [](Real v) { return v > 0 ? v * v : 0; };
  const auto part_beyond = [&](Real way) {
    const Real w = std::max(way, -reach);
    return (square_above_zero(reach - w) - square_above_zero(flat - w) - square_above_zero(-flat - w)) /
           (2 * (reach * reach - flat * flat));
  };
  const auto beyond = [&](Real way) {
    return part_beyond(way) - (a < 2 && way > flat && way < reach ? less_in_layers_[a] : 0);
  };
  const Real below = corner > frame_.floor[b] + 0.5 ? beyond(middle) : 0;
  const Real above = corner + 1.5 < frame_.ceiling[b] ? beyond(1 - middle) : 0;
  return {below, 1 - below - above, above};
}

// The height of the centre of a particle that would extend down, or up, into a solid, once the particle lies on the
// solid, or beneath it, in cells upwards, as is `height`; distance of the solid and its slope upwards, in samples.
Real CutCells::off_solid(Real height, Real distance, Real slope) const {
  const Real way = std::max(distance, 0.0), steep = std::abs(slope) * samples;  // the solid is way/steep below or above
  const Real half = frame_.reach[2] / 2;
  if (way >= half * steep) return height;
  const Real missing = half - way / steep;
  return slope > 0 ? height + missing : height - missing;
}

// At walls water lies in layers one spacing thick, whose shares are those at the centres of the layers. Where a share
// is curved, this is less than its mean over the layer, just as the value at a sample is less than the mean over the
// sample. With the mean, still water beside a box sank by 0.03 spacings.
void CutCells::use(const CellFrame& frame) {
  frame_ = frame;
  const auto up = static_cast<std::size_t>(axis_[2]);
  for (std::size_t a = 0; a < 2; ++a) {
    const auto b = static_cast<std::size_t>(axis_[a]);
    const Real layer = frame.reach[up] * frame.per_length[b] / frame.per_length[up], width = 1.0 / samples;
    const Real curvature = 1 / (frame.reach[b] * frame.reach[b] - frame.flat[b] * frame.flat[b]);
    less_in_layers_[a] = (layer * layer - width * width) / 24 * curvature;
  }
}

// Means over a cell: for the first cells along each direction, for the others, and for the last ones.
void CutCells::find_whole_shares(const ProjectionGrid& grid) {
  std::array<std::array<SharesAlong, 3>, 3> mean{};  // by direction
  for (std::size_t a = 0; a < 3; ++a) {
    count_[a] = grid.count(a);
    const std::array<LocalId, 3> corners{0, 1, count_[a] - 1};
    for (std::size_t n = 0; n < 3; ++n) {
      for (std::size_t k = 0; k < samples; ++k) {
        const SharesAlong one = sample_shares_[a][n][k] = shares_along(a, sample_at[k], corners[n]);
        for (std::size_t i = 0; i < 3; ++i) mean[a][n][i] += one[i] / samples;
      }
    }
  }
  for (std::size_t place = 0; place < whole_shares_.size(); ++place) {
    const SharesAlong &u = mean[0][place / 9], &v = mean[1][place / 3 % 3], &w = mean[2][place % 3];
    for (std::size_t n = 0; n < 27; ++n)
      whole_shares_[place][n] = static_cast<float>(u[n / 9] * v[n / 3 % 3] * w[n % 3]);
  }
}

// For a cell about which nothing else is known yet. Those of a cell outside the box are written to `own`.
const CutCells::SharesAlong* CutCells::shares_of_samples(std::size_t a, Real corner, SharesOfSamples& own) const {
  if (corner >= 0 && corner < count_[a]) return sample_shares_[a][which_of(corner, count_[a])].data();
  for (std::size_t k = 0; k < samples; ++k) own[k] = shares_along(a, sample_at[k], corner);
  return own.data();
}

const CutCells::Shares* CutCells::whole_shares(const ProjectionGrid& grid, LocalId k, LocalId r) const {
  const std::array<Real, 3> place = from_box(corner_of(grid, k, r, 0));
  return &whole_shares_[number_of(which_of(place[0], grid.count(0)), which_of(place[1], grid.count(1)), 0)];
}

// How far a solid that closes the lower face of a cell rises above this face, or one that closes the upper face hangs
// below it, in cells, on average over the open part of the opposite face.
Real CutCells::rise(std::size_t at, bool hangs) const {
  const Real wide = face(2, hangs ? at : at + 1);
  return wide > 0 ? std::max(1 - open(at) / wide, 0.0) : 0;
}

CellFrame CutCells::beside_solids(const CellFrame& frame, const ProjectionGrid& grid,
                                  const std::array<LocalId, 3>& cell) const {
  CellFrame narrowed = frame;
  const LocalId c = cell[2];
  const std::size_t at = grid.index(cell[0], cell[1], c);
  const CellPlace place = grid.place_of(cell[0], cell[1], c);
  for (std::size_t a = 0; a < 3; ++a) {
    const std::size_t b = grid.axis(a);
    if (face(a, at) == 0) narrowed.floor[b] = place.corner[b];
    if (face(a, at + grid.step(a)) == 0) narrowed.ceiling[b] = place.corner[b] + 1;
  }
  const std::size_t up = grid.axis(2);
  const Real half = frame.reach[up] / 2;
  const auto keep_above = [&](Real bottom) {
    narrowed.nearest[up] = std::max(narrowed.nearest[up], place.corner[up] + bottom + half);
  };
  const auto keep_below = [&](Real top) {
    narrowed.farthest[up] = std::min(narrowed.farthest[up], place.corner[up] + top - half);
  };
  const LocalId end = grid.columns();
  const auto rises = [&](LocalId of, std::size_t i) { return of == 0 || open(i - 1) == 0 ? rise(i, false) : 0; };
  const auto hangs = [&](LocalId of, std::size_t i) { return of + 1 == end || open(i + 1) == 0 ? rise(i, true) : 0; };
  if (face(2, at) == 0) {
    keep_above(rises(c, at));
  } else if (c > 0 && open(at - 1) > 0 && face(2, at - 1) == 0) {
    keep_above(rises(c - 1, at - 1) - 1);
  }
  if (face(2, at + 1) == 0) {
    keep_below(1 - hangs(c, at));
  } else if (c + 1 < end && open(at + 1) > 0 && face(2, at + 2) == 0) {
    keep_below(2 - hangs(c + 1, at + 1));
  }
  return narrowed;
}

// What would extend through a face that a solid closes stays in its own cell.
void CutCells::confine_shares(const ProjectionGrid& grid, LocalId k, LocalId r, LocalId c, std::vector<Cell>& cells) {
  const std::size_t at = grid.index(k, r, c);
  if (cells[at].open == 0) return;
  std::array<std::array<bool, 2>, 3> closed;
  bool any = false;
  for (std::size_t a = 0; a < 3; ++a) {
    const bool has_below = ProjectionGrid::has_below(a, k, r);
    const bool has_above = (a != 0 || k <= grid.planes()) && (a != 1 || r < grid.rows());
    closed[a] = {has_below && cells[at].face[a] == 0, has_above && cells[at + grid.step(a)].face[a] == 0};
    any = any || closed[a][0] || closed[a][1];
  }
  if (!any) return;
  Shares& shares = shares_[at];
  if (!cells[at].has_shares) shares = whole_shares(grid, k, r)[which_of(c, grid.count(2))];
  cells[at].has_shares = true;
  constexpr std::array<std::size_t, 3> weight{9, 3, 1};
  for (std::size_t a = 0; a < 3; ++a) {
    for (std::size_t n = 0; n < shares.size(); ++n) {
      const std::size_t side = n / weight[a] % 3;
      if (side == 1 || !closed[a][side / 2]) continue;
      shares[side == 0 ? n + weight[a] : n - weight[a]] += shares[n];
      shares[n] = 0;
    }
  }
}

// The three by three rows around a row, which is in the middle; rows in walls do not exist.
struct CutCells::RowsAround {
  struct One {
    bool exists = false;
    std::size_t floor = 0;
    const Shares* whole = nullptr;
  };
  std::array<One, 9> row;
  LocalId columns, count;
  std::array<bool, 2> ends;  // whether there are walls below the first column and above the last
  bool repeats;
  std::size_t floor() const { return row[4].floor; }
};

// The position in a neighbouring cell of its water that has a share here: near the face, on average a quarter of a cell
// beyond it.
void CutCells::measure_capacity(const RowsAround& rows, LocalId c, std::vector<Cell>& cells) const {
  constexpr Real beyond_face = 0.25;
  constexpr std::array<Real, 3> off{-beyond_face - 0.5, 0, beyond_face + 0.5};  // of the neighbours from the centre
  struct Column {
    std::size_t at, kind;  // kind: which of the shares of whole cells
    bool exists, above;
  };
  std::array<Column, 3> column;
  for (std::size_t l = 0; l < 3; ++l) {
    LocalId beside = c + static_cast<LocalId>(l) - 1;
    const bool in_wall = (rows.ends[0] && beside < 0) || (rows.ends[1] && beside == rows.count);
    if (rows.repeats) beside = (beside + rows.columns) % rows.columns;
    column[l] = {static_cast<std::size_t>(beside), which_of(beside, rows.count), !in_wall, beside >= rows.columns};
  }
  constexpr Cell plain;  // cells above those that are measured
  const Cell* const all = cells.data();
  const Shares* const own = shares_.get();
  const bool are_usual =
      std::all_of(column.begin(), column.end(), [](const Column& one) { return one.exists && !one.above; });
  Real sum = 0;
  std::array<Real, 2> moment{};
  const auto add_row = [&]<std::size_t n, bool usual>(Constant<n>, std::bool_constant<usual>) {
    const RowsAround::One& row = rows.row[n];
    if (!row.exists) return;
    for (std::size_t l = 0; l < 3; ++l) {
      if (!usual && !column[l].exists) continue;
      const std::size_t at = row.floor + column[l].at;
      const Cell& cell = !usual && column[l].above ? plain : all[at];
      if (cell.open == 0) continue;
      const Shares& shares = cell.has_shares ? own[at] : row.whole[column[l].kind];
      const Real share = shares[26 - 3 * n - l];  // its share in the cell in the middle
      sum += share;
      moment[0] += share * (n / 3 == 1 ? static_cast<Real>(cell.middle[2][0]) - 0.5 : off[n / 3]);
      moment[1] += share * (n % 3 == 1 ? static_cast<Real>(cell.middle[2][1]) - 0.5 : off[n % 3]);
    }
  };
  const auto add_all = [&]<std::size_t... n>(std::index_sequence<n...>, auto usual) {
    (add_row(Constant<n>(), usual), ...);
  };
  if (are_usual) {
    add_all(std::make_index_sequence<9>(), std::true_type());
  } else {
    add_all(std::make_index_sequence<9>(), std::false_type());
  }
  Cell& measured = cells[rows.floor() + static_cast<std::size_t>(c)];
  measured.capacity = static_cast<float>(sum);
  for (std::size_t a = 0; a < 2 && sum > 0; ++a) measured.aside[a] = static_cast<float>(-moment[a] / sum);
}

CutCells::RowsAround CutCells::rows_around(const ProjectionGrid& grid, LocalId k, LocalId r) const {
  RowsAround rows{{},
                  grid.columns(),
                  grid.count(2),
                  {grid.is_wall(2, k, r, 0), grid.is_wall(2, k, r, grid.count(2))},
                  grid.repeats()[2]};
  for (std::size_t n = 0; n < 9; ++n) {
    const LocalId i = k + static_cast<LocalId>(n / 3) - 1, j = grid.row_beside(r + static_cast<LocalId>(n % 3) - 1);
    const bool beyond = (n < 3 && grid.is_wall(0, k, r, 0)) || (n >= 6 && grid.is_wall(0, k + 1, r, 0)) ||
                        (n % 3 == 0 && grid.is_wall(1, k, r, 0)) || (n % 3 == 2 && grid.is_wall(1, k, r + 1, 0));
    rows.row[n] = {!beyond, grid.index(i, j, 0), beyond ? nullptr : whole_shares(grid, i, j)};
  }
  return rows;
}

void CutCells::measure_capacities(const ProjectionGrid& grid, std::vector<Cell>& cells) {
  for_each_range_near([&](LocalId k, LocalId r, Range columns) {
    for (LocalId c = columns.begin; c < columns.end; ++c) confine_shares(grid, k, r, c, cells);
  });
  for_each_range_near([&](LocalId k, LocalId r, Range columns) {
    if (k < 1 || k > grid.planes() || r < 0 || r >= grid.rows()) return;  // known to the ranks that own them
    // From the column before the first one to that after the last one: whether one of the nine cells is cut.
    std::vector<unsigned char>& is_cut = candidates_.mine().is_cut;
    is_cut.assign(static_cast<std::size_t>(columns.size()) + 2, 0);
    const std::size_t before = grid.index(k, r, columns.begin) - 1;
    for (std::size_t n = 0; n < 9; ++n) {
      const Cell* const row =
          &cells[before + n / 3 * grid.step(0) + n % 3 * grid.step(1) - grid.step(0) - grid.step(1)];
      for (std::size_t c = 0; c < is_cut.size(); ++c) is_cut[c] |= static_cast<unsigned char>(row[c].cut);
    }
    const RowsAround rows = rows_around(grid, k, r);
    for (LocalId c = columns.begin; c < columns.end; ++c) {
      Cell& cell = cells[rows.floor() + static_cast<std::size_t>(c)];
      cell.capacity = 1;
      cell.aside = {};
      const unsigned char* const around = &is_cut[static_cast<std::size_t>(c - columns.begin)];
      if ((around[0] | around[1] | around[2]) != 0) measure_capacity(rows, c, cells);
    }
  });
}

}  // namespace trevi
