#include "projection/cut_cells.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

#include "parallel/reductions.hpp"

namespace trevi {

CutCells::CutCells(const Obstacles& obstacles)
    : obstacles_(obstacles), all_bodies_(obstacles.count()), excess_(obstacles.count()) {
  std::iota(all_bodies_.begin(), all_bodies_.end(), std::size_t{0});
}

// Cells are counted from the start of the box first, which is exact: the position is the same on every rank.
Real CutCells::place(std::size_t a, Real in_cells) const {
  const auto b = static_cast<Eigen::Index>(a);
  return origin_[b] + (in_cells + (a == 0 ? first_ - 1 : a == 1 ? first_row_ : 0)) * size_[b];
}

Vec3 CutCells::place(const Vec3& in_cells) const {
  Vec3 p;
  for (std::size_t a = 0; a < 3; ++a) p[axis_[a]] = place(a, in_cells[static_cast<Eigen::Index>(a)]);
  return p;
}

Vec3 CutCells::middle(LocalId k, LocalId r, LocalId c) const { return place(Vec3(k + 0.5, r + 0.5, c + 0.5)); }

// A multiple of 2⁻³⁰, to which whole cells can be added without rounding: the position is the same on every rank.
Real CutCells::countable(Real in_cell) {
  constexpr Real parts = 1U << 30U;
  return std::rint(in_cell * parts) / parts;
}

Vec3 CutCells::middle_in(const std::array<LocalId, 3>& cell, const InCell& in_cell) const {
  Vec3 middle;
  for (std::size_t a = 0; a < 3; ++a) middle[static_cast<Eigen::Index>(a)] = cell[a] + countable(in_cell[a]);
  return place(middle);
}

Vec3 CutCells::middle_of_closed(std::size_t a, const std::array<LocalId, 3>& cell, const Cell& measured) const {
  Vec3 corner(cell[0], cell[1], cell[2]);
  const Real open = measured.face[a];
  for (std::size_t i = 0; i < 2; ++i) {
    const Real middle = open < 1 ? (0.5 - open * measured.middle[a][i]) / (1 - open) : 0.5;
    corner[static_cast<Eigen::Index>((a + 1 + i) % 3)] += open > 0 ? countable(std::clamp(middle, 0.0, 1.0)) : 0.5;
  }
  return place(corner);
}

CutCells::Nearest CutCells::nearest_at(const Vec3& p, const Bodies& bodies) const {
  Nearest nearest{INFINITY, 0};
  const Vec3 inside = in_box(p);
  for (const std::size_t k : bodies) {
    const Real d = distance_to(obstacles_.body(k), inside);
    if (d < nearest.distance) nearest = {d, k};
  }
  return nearest;
}

// `far`: the nearest of these solids. A moving one counts in its zone only, because other cells are not measured again
// when it moves: what they knew of it depended on when the window of the rank had last changed.
void CutCells::find_nearest(const Vec3& corner, const Nearest& far, const Bodies& bodies, Cell& cell) const {
  const std::array<Real, 3> place_of_cell = from_box(corner);
  const auto counts = [&](std::size_t k) {
    if (!obstacles_.body(k).moves()) return true;
    const Zone zone = zone_of(obstacles_.body(k));
    for (std::size_t a = 0; a < 3; ++a)
      if (place_of_cell[a] < zone.low[a] || place_of_cell[a] > zone.high[a]) return false;
    return true;
  };
  Nearest nearest = far;
  if (!counts(far.body)) {
    Bodies some;
    std::copy_if(bodies.begin(), bodies.end(), std::back_inserter(some), counts);
    nearest = nearest_at(place(corner + Vec3::Constant(0.5)), some);
  }
  cell.nearest = static_cast<std::uint32_t>(nearest.body) & Cell::max_nearest;
  cell.has_nearest = nearest.distance < INFINITY;
  cell.is_beside = nearest.distance <= beside_body * size_.maxCoeff();
}

// All solids that may be the nearest one somewhere within `reach` of p, or be met there: a distance changes by no more
// than the length of the path. Approximate distances may change by more, so these solids are kept.
void CutCells::keep_near(const Vec3& p, Real reach, const Bodies& all, Bodies& kept,
                         std::vector<Real>& distance) const {
  const Vec3 inside = in_box(p);
  Real nearest = INFINITY;
  distance.clear();
  for (const std::size_t k : all) {
    const Body& body = obstacles_.body(k);
    distance.push_back(body.is_rough() ? -INFINITY : distance_to(body, inside));
    if (!body.is_rough()) nearest = std::min(nearest, distance.back());
  }
  const Real most = std::max(nearest, 0.0) + 2 * reach;
  kept.clear();
  for (std::size_t n = 0; n < all.size(); ++n) {
    if (distance[n] <= most) kept.push_back(all[n]);
  }
}

// The cells of which any point that is examined may lie in the solid: no such point is further than 1.6 cells from the
// centre of its cell, and at walls in_box() moves it closer by less than 0.7. A cell that the margin leaves out is half
// a cell further away.
CutCells::Zone CutCells::zone_of(const Body& body) const {
  const Box place = body.surface_box();
  const Vec3 far = Vec3::Constant(3 * size_.maxCoeff());
  const bool inside = box_.contains(place.min - far) && box_.contains(place.max + far);
  const Vec3 margin = Vec3::Constant((inside ? 1.25 : 2) * size_.maxCoeff());
  Zone zone = everywhere;
  for (std::size_t a = 0; a < 3 && !body.is_vessel(); ++a) {
    const auto b = static_cast<Eigen::Index>(a);
    const auto cell = [&](Real x) {
      return static_cast<LocalId>(std::clamp(std::floor((x - origin_[b]) / size_[b]), -0x1p30, 0x1p30));
    };
    zone.low[a] = cell(place.min[axis_[a]] - margin.x());
    zone.high[a] = cell(place.max[axis_[a]] + margin.x());
  }
  return zone;
}

// The columns of a row that lie in the zones, as disjoint ranges.
void CutCells::find_ranges(const Row& row, const std::vector<Zone>& zones, std::vector<Range>& ranges) const {
  ranges.clear();
  for (const Zone& zone : zones) {
    if (row.plane < zone.low[0] || row.plane > zone.high[0] || row.row < zone.low[1] || row.row > zone.high[1])
      continue;
    const Range range{std::max(zone.low[2], 0), std::min(zone.high[2], row.columns - 1) + 1};
    if (range.begin < range.end) ranges.push_back(range);
  }
  std::sort(ranges.begin(), ranges.end(), [](const Range& a, const Range& b) { return a.begin < b.begin; });
  std::size_t last = 0;
  for (std::size_t n = 1; n < ranges.size(); ++n) {
    if (ranges[n].begin <= ranges[last].end) {
      ranges[last].end = std::max(ranges[last].end, ranges[n].end);
    } else {
      ranges[++last] = ranges[n];
    }
  }
  if (!ranges.empty()) ranges.resize(last + 1);
}

// For a ghost cell beyond the end of a periodic box, the corner of the cell at the other end, of which it is a copy.
Vec3 CutCells::corner_of(const ProjectionGrid& grid, LocalId k, LocalId r, Real c) const {
  const LocalId planes = grid.count(0), rows = grid.count(1);
  if (grid.repeats()[0]) k = (k - 1 + first_ + planes) % planes - first_ + 1;
  if (grid.repeats()[1]) r = (r + first_row_ + rows) % rows - first_row_;
  return Vec3(k, r, c);
}

void CutCells::find_ranges_near(const ProjectionGrid& grid, const std::vector<Zone>& zones) {
  near_.clear();
  std::vector<Range> ranges;
  const CellRows rows = grid.rows_and_ghosts_of({0, grid.planes() + 2});
  for (LocalId k = 0; k < grid.planes() + 2; ++k) {
    for (LocalId r = rows.first_row; r < rows.first_row + rows.rows; ++r) {
      if (!grid.has_row(r)) continue;
      const Vec3 first = corner_of(grid, k, r, 0);
      find_ranges(
          {static_cast<LocalId>(first[0]) - 1 + first_, static_cast<LocalId>(first[1]) + first_row_, grid.columns()},
          zones, ranges);
      for (const Range& columns : ranges) near_.push_back({k, r, columns, {}, false});
    }
  }
  for_each_part(static_cast<LocalId>(near_.size()), [&](LocalId n) {
    RangeNear& one = near_[static_cast<std::size_t>(n)];
    const Vec3 first = corner_of(grid, one.k, one.r, 0);
    const Real reach = (0.5 * one.columns.size() + looked_at) * size_.maxCoeff();
    const Vec3 middle(first[0] + 0.5, first[1] + 0.5, 0.5 * (one.columns.begin + one.columns.end));
    keep_near(place(middle), reach, all_bodies_, one.bodies, candidates_.mine().distance);
    one.clear = are_clear(one.bodies);
  });
}

void CutCells::measure_cells(const ProjectionGrid& grid, std::vector<Cell>& cells) {
  cells.resize(grid.cells());
  store_shares(grid.cells());
  find_whole_shares(grid);
  for_each_row_near([&](LocalId k, LocalId r, Candidates& near, Range columns) {
    for (LocalId c = columns.begin; c < columns.end; ++c) {
      const std::size_t at = grid.index(k, r, c);
      const Vec3 corner = corner_of(grid, k, r, c);
      cells[at] = cell_at(corner, near);
      for_each_upper_wall(grid, k, r, c, [&](std::size_t a, std::size_t beyond) {
        cells[beyond] = {};
        cells[beyond].face[a] = cells[at].open;
        if (near.near) measure_face(a, corner + Vec3::Unit(static_cast<Eigen::Index>(a)), near, cells[beyond]);
      });
      if (cells[at].has_shares) shares_[at] = near.shares;
    }
  });
  grid.repeat(cells);
  for_each_range_near([&](LocalId k, LocalId r, Range columns) {
    for (LocalId c = columns.begin; c < columns.end; ++c) {
      const std::size_t at = grid.index(k, r, c);
      for (std::size_t a = 0; a < 3; ++a) {
        const bool low_closed = ProjectionGrid::has_below(a, k, r) && cells[at - grid.step(a)].open == 0;
        if (low_closed || cells[at].open == 0) cells[at].face[a] = 0;
      }
      note_cut(cells[at]);
      for_each_upper_wall(grid, k, r, c, [&](std::size_t a, std::size_t beyond) {
        if (cells[at].open == 0) cells[beyond].face[a] = 0;
        note_cut(cells[beyond]);
      });
    }
  });
  grid.repeat(cells);
  measure_capacities(grid, cells);
}

// The motion of the solids that close each face, and what each of them closes beside freely moving bodies.
void CutCells::measure_motion(const ProjectionGrid& grid) {
  moved_.resize(grid.cells());
  PerThread<SolidParts::Found> found;
  const bool any_float = any_floats();
  for_each_row_near([&](LocalId k, LocalId r, const Candidates& near, Range columns) {
    SolidParts::Found& parts = found.mine();
    const auto measure_face = [&](std::size_t a, const std::array<LocalId, 3>& cell, std::size_t at) {
      if (cells_[at].face[a] == 1 || (a == 1 && grid.is_layer())) return;  // nothing moves across a layer
      const AtFace face{a, at, cell, corner_of(grid, cell[0], cell[1], cell[2]), grid.step(a)};
      const std::size_t first = parts.of_faces.size();
      if (any_float) find_parts_of_face(face, near.of_row, parts.of_faces);
      Real sum = 0;
      for (std::size_t n = first; n < parts.of_faces.size(); ++n) sum += displacement(parts.of_faces[n]);
      const bool has_parts = parts.of_faces.size() > first;
      moved_[at][a] = static_cast<float>(has_parts ? sum : displacement_of_closed(face, near.of_row));
    };
    for (LocalId c = columns.begin; c < columns.end; ++c) {
      const std::size_t at = grid.index(k, r, c);
      moved_[at] = {0, 0, 0};
      for (std::size_t a = 0; a < 3; ++a) measure_face(a, {k, r, c}, at);
      for_each_upper_wall(grid, k, r, c, [&](std::size_t a, std::size_t beyond) {
        moved_[beyond] = {0, 0, 0};
        measure_face(a, {k, r + (a == 1), c + (a == 2)}, beyond);
      });
      if (any_float) find_parts_of_cell(corner_of(grid, k, r, c), at, near.of_row, parts.of_cells);
    }
  });
  grid.repeat(moved_);
  if (!any_float) return;
  parts_.collect(found);
  for (std::size_t n = parts_.of_faces().size(); n-- > 0;)
    cells_[parts_.of_faces()[n].at].parts = static_cast<std::uint32_t>(n + 1);
}

void CutCells::find_columns(const ProjectionGrid& grid) {
  ProjectionGrid whole = grid;
  whole.resize(grid.window(), grid.count(2));
  cells_.resize(grid.cells());
  const auto length = static_cast<std::ptrdiff_t>(grid.columns()) + 2;
  for_each_part((grid.planes() + 2) * (grid.rows() + 2), [&](LocalId row) {
    const LocalId k = row / (grid.rows() + 2), r = row % (grid.rows() + 2) - 1;
    const auto from = static_cast<std::ptrdiff_t>(whole.index(k, r, 0)) - 1;
    std::copy_n(all_.begin() + from, length, cells_.begin() + static_cast<std::ptrdiff_t>(grid.index(k, r, 0)) - 1);
  });
}

// The faces that a row shares with the next row and the next plane count as its own, too.
void CutCells::find_cut_rows(const ProjectionGrid& grid) {
  columns_ = grid.columns();
  cut_columns_.assign(row_index(grid.planes() + 2, -1), {0, 0});
  for_each_row(grid.rows_and_ghosts_of({0, grid.planes() + 2}), [&](LocalId k, LocalId r) {
    const std::size_t floor = grid.index(k, r, 0);
    const bool has_row_after = r < grid.rows(), has_plane_after = k <= grid.planes();
    const auto is_cut_here = [&](LocalId c) {
      const std::size_t at = floor + static_cast<std::size_t>(c);
      return cells_[at].cut || (has_row_after && cells_[at + grid.step(1)].cut) ||
             (has_plane_after && cells_[at + grid.step(0)].cut);
    };
    LocalId begin = 0, end = grid.columns();  // the last column is beyond the cells
    while (begin <= end && !is_cut_here(begin)) ++begin;
    while (end >= begin && !is_cut_here(end)) --end;
    if (begin <= end) cut_columns_[row_index(k, r)] = {std::max(begin - 1, 0), std::min(end + 1, grid.columns())};
  });
  if (grid.rows_wrap()) {
    for (LocalId k = 0; k < grid.planes() + 2; ++k) {
      cut_columns_[row_index(k, -1)] = cut_columns_[row_index(k, rows_ - 1)];
      cut_columns_[row_index(k, rows_)] = cut_columns_[row_index(k, 0)];
    }
  }
}

void CutCells::measure(MPI_Comm comm, const ProjectionGrid& grid, const Box& box, const CellFrame& frame) {
  const bool stays = grid.first_plane() == first_ && grid.planes() == planes_ && grid.first_row() == first_row_ &&
                     grid.rows() == rows_;
  for (std::size_t a = 0; a < 3; ++a) {
    const auto b = static_cast<Eigen::Index>(a);
    axis_[a] = static_cast<int>(grid.axis(a));
    size_[b] = grid.size()[b];
    origin_[b] = box.min[axis_[a]];
  }
  step_ = {grid.step(0), grid.step(1), grid.step(2)};
  box_ = box;
  const Real gap = size_.maxCoeff() / (2 * samples);
  inner_ = {box.min.array() + gap, box.max.array() - gap};
  use(frame);
  first_ = grid.first_plane();
  planes_ = grid.planes();
  first_row_ = grid.first_row();
  rows_ = grid.rows();
  if (obstacles_.moves()) {
    const bool known = stays && cells_.size() == grid.cells();
    std::vector<Zone> zones = known ? std::move(zones_) : std::vector<Zone>{everywhere};
    zones_.clear();
    for (const std::size_t k : all_bodies_)
      if (obstacles_.body(k).moves()) zones_.push_back(zone_of(obstacles_.body(k)));
    const std::size_t before = zones.size();
    for (std::size_t n = 0; n < zones_.size(); ++n)
      if (n >= before || !(zones[n] == zones_[n])) zones.push_back(zones_[n]);
    if (!known) cells_.clear(), moved_.clear();
    find_ranges_near(grid, zones);
    measure_cells(grid, cells_);
    measure_motion(grid);
    find_cut_rows(grid);
    if (obstacles_.floating() != nullptr) measure_excess(comm, grid);
    if (obstacles_.floating() != nullptr) find_gaps(grid);
    return;
  }
  if (!stays) {
    ProjectionGrid whole = grid;
    whole.resize(grid.window(), grid.count(2));
    all_.clear();
    find_ranges_near(whole, {everywhere});
    measure_cells(whole, all_);
    store_shares(0);
  }
  if (stays && cells_.size() == grid.cells()) return;
  find_columns(grid);
  find_cut_rows(grid);
}

}  // namespace trevi
