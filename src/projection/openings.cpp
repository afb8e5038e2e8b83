#include "projection/openings.hpp"

#include <algorithm>

namespace trevi {

namespace {

Real overlap(Real from, Real to, Real other_from, Real other_to) {
  return std::max<Real>(0, std::min(to, other_to) - std::max(from, other_from));
}

template <class Visit>
void for_each_cell_in(const ProjectionGrid& grid, const Box& bounds, const Visit& visit) {
  std::array<LocalId, 3> from{}, to{};
  for (std::size_t a = 0; a < 3; ++a) {
    const auto b = static_cast<Eigen::Index>(grid.axis(a));
    const Real last = grid.count(a) - 1;
    from[a] = static_cast<LocalId>(std::clamp(grid.cells_to(bounds.min, a), 0.0, last));
    to[a] = static_cast<LocalId>(std::clamp(grid.cells_to(bounds.max, a), 0.0, last));
    if (bounds.max[b] < grid.low(a)) return;
  }
  for (LocalId k = from[0]; k <= to[0]; ++k) {
    for (LocalId r = from[1]; r <= to[1]; ++r) {
      for (LocalId c = from[2]; c <= to[2]; ++c) visit({k, r, c});
    }
  }
}

// Whether row r of plane k belongs to this rank or is adjacent to one that does.
bool is_known(const ProjectionGrid& grid, LocalId k, LocalId r) {
  return k >= 0 && k <= grid.planes() + 1 && r >= -1 && r <= grid.rows();
}

// The number of samples of a cell, two along each axis, that lie in a drain's region.
int taken_of(const std::function<bool(const Vec3&)>& takes, const Vec3& corner, const Vec3& size) {
  int taken = 0;
  for (int n = 0; n < 8; ++n) {
    const Vec3 sample(n % 2 + 0.5, n / 2 % 2 + 0.5, n / 4 + 0.5);
    taken += takes(corner + size.cwiseProduct(sample) / 2) ? 1 : 0;
  }
  return taken;
}

}  // namespace

// A drain consists of the cells of which it takes at least half. If there are none, it consists of the cells of which
// it takes the largest part. A drain that is not a hole keeps the cells that it takes completely empty by itself. Of
// these only the cells adjacent to others are recorded, because a plane may take most of the box.
void Openings::find_drained(const ProjectionGrid& grid) {
  constexpr int half = 4, whole = 8;
  Vec3 size = Vec3::Zero(), low = size;
  for (std::size_t a = 0; a < 3; ++a) {
    const auto b = static_cast<Eigen::Index>(grid.axis(a));
    size[b] = grid.size()[static_cast<Eigen::Index>(a)];
    low[b] = grid.low(a);
  }
  for (const Drain& drain : drains_) {
    const auto corner_of = [&](const Cell& cell) {
      Vec3 corner;
      for (std::size_t a = 0; a < 3; ++a) {
        const auto b = static_cast<Eigen::Index>(grid.axis(a));
        corner[b] = low[b] + cell[a] * size[b];
      }
      return corner;
    };
    const auto taken_in = [&](const Cell& cell) { return taken_of(drain.takes, corner_of(cell), size); };
    // The outermost samples of the surrounding cells are then in the region, which is convex.
    const auto is_inner = [&](const Cell& cell) {
      return taken_of(drain.takes, corner_of(cell) - 2 * size, 5 * size) == whole;
    };
    const std::size_t first = drained_cells_.size();
    int taken = 1;
    for_each_cell_in(grid, drain.bounds, [&](const Cell& cell) {
      const int here = std::min(taken_in(cell), half);
      if (here > taken) drained_cells_.resize(first);
      if (here >= taken) drained_cells_.push_back({cell});
      taken = std::max(taken, here);
    });
    find_wall(grid, first);
    const auto begin = drained_cells_.begin() + static_cast<std::ptrdiff_t>(first);
    std::for_each(begin, drained_cells_.end(), [&](Drained& one) { one.whole = taken_in(one.cell) == whole; });
    const auto inner = [&](const Drained& one) { return one.is_empty() && is_inner(one.cell); };
    drained_cells_.erase(std::remove_if(begin, drained_cells_.end(), inner), drained_cells_.end());
  }
}

// For the cells of a drain, those from number `first` on: a hole in a wall is one cell thick and has exactly one wall
// of the box behind it.
void Openings::find_wall(const ProjectionGrid& grid, std::size_t first) {
  int walls = 0, out = -1;
  bool up = false, layer = false;
  for (std::size_t a = 0; a < 3; ++a) {
    if (grid.repeats()[a] || (a == 1 && grid.is_layer())) continue;
    LocalId least = grid.count(a), most = 0;
    for (std::size_t n = first; n < drained_cells_.size(); ++n) {
      least = std::min(least, drained_cells_[n].cell[a]);
      most = std::max(most, drained_cells_[n].cell[a]);
    }
    layer = a == 2 && least == most;
    const bool low = least == 0, high = most + 1 == grid.count(a);
    if (low == high) continue;  // no wall, or from wall to wall
    ++walls;
    if (least != most) continue;
    out = static_cast<int>(a);
    up = low;
  }
  for (std::size_t n = first; n < drained_cells_.size(); ++n) {
    drained_cells_[n].layer = walls == 0 && layer;
    if (walls != 1) continue;
    drained_cells_[n].out = out;
    drained_cells_[n].up = up;
  }
}

void Openings::close_sides(const ProjectionGrid& grid, const Borrowed<char>& wet) {
  for (const std::size_t at : closed_at_) closed_[at] = 0;
  closed_at_.clear();
  for (const Drained& drained : drained_cells_) {
    const Cell& cell = drained.cell;
    const int out = drained.out;
    const bool up = drained.up;
    const LocalId k = grid.own_plane(cell[0]), r = grid.own_row(cell[1]), towards = up ? 1 : -1;
    if (out < 0 || !is_known(grid, k, r) || cell[2] >= grid.columns()) continue;
    if (!is_known(grid, k + (out == 0 ? towards : 0), r + (out == 1 ? towards : 0))) continue;
    const std::size_t at = grid.index(k, r, cell[2]), step = grid.step(static_cast<std::size_t>(out));
    if (wet[up ? at + step : at - step] == 0) continue;
    for (std::size_t a = 0; a < 3; ++a) {
      const std::size_t side = grid.step(a);
      if (static_cast<int>(a) == out) continue;
      if (at >= side && !is_drained(at - side)) close(a, at);
      if (at + side < grid.cells() && !is_drained(at + side)) close(a, at + side);
    }
  }
}

void Openings::close(std::size_t a, std::size_t at) {
  closed_[at] = static_cast<unsigned char>(closed_[at] | (1U << a));
  closed_at_.push_back(at);
}

// The obstacle below a drained cell, or above it if it is not the highest one.
void Openings::find_obstacle(const CutCells& cuts, std::size_t at, bool is_highest, Drained& drained) {
  const bool below = cuts.is_filled_at_rest(at - 1), above = !is_highest && cuts.is_filled_at_rest(at + 1);
  drained.out = below == above ? -1 : 2;
  drained.up = below;
}

void Openings::measure(const ProjectionGrid& grid, const CutCells* cuts) {
  if (!found_) find_drained(grid);
  found_ = true;
  if (drained_.size() != grid.cells()) {
    drained_.assign(grid.cells(), 0);
    crossed_.assign(grid.cells(), 0);
    crossed_cells_.clear();
    closed_.assign(grid.cells(), 0);
    closed_at_.clear();
    for (auto& of_axis : through_) of_axis.assign(grid.cells(), 0.0);
  } else {
    for (const std::size_t at : marked_) drained_[at] = 0;
    for (const Face& face : faces_) through_[face.a][face.at] = 0;
    for (const Gain& gain : gains_) through_[gain.a][gain.face] = 0;
  }
  marked_.clear();
  faces_.clear();
  for (Drained& drained : drained_cells_) {
    const auto [plane, row, c] = drained.cell;
    const LocalId k = grid.own_plane(plane), r = grid.own_row(row);
    if (!is_known(grid, k, r) || c >= grid.columns()) continue;
    const std::size_t at = grid.index(k, r, c);
    if (cuts != nullptr && drained.layer && c > 0) find_obstacle(*cuts, at, c + 1 == grid.columns(), drained);
    marked_.push_back(at);
    if (drained_[at] != open_to_air) drained_[at] = drained.is_empty() ? emptied : open_to_air;
  }
  for (const WallOpening& wall : walls_) measure_wall(grid, wall);
  gains_.clear();
  for (const Source& source : sources_) measure_source(grid, source);
  find_crossed(grid);
}

// Of cells and ghost cells alike, copies beyond the ends of a periodic box included.
void Openings::find_crossed(const ProjectionGrid& grid) {
  for (const std::size_t at : crossed_cells_) crossed_[at] = 0;
  crossed_cells_.clear();
  const auto cross = [&](const Cell& cell) {
    const LocalId around = grid.repeats()[0] ? grid.count(0) : 0, aside = grid.repeats()[1] ? grid.count(1) : 0;
    for (const LocalId plane : {cell[0], cell[0] - around, cell[0] + around}) {
      for (const LocalId row : {cell[1], cell[1] - aside, cell[1] + aside}) {
        const LocalId k = grid.own_plane(plane), r = grid.own_row(row);
        if (!is_known(grid, k, r) || cell[2] >= grid.columns()) continue;
        const std::size_t at = grid.index(k, r, cell[2]);
        if (crossed_[at] == 0) crossed_cells_.push_back(at);
        crossed_[at] = 1;
      }
    }
  };
  const Vec3 rounding = Vec3::Constant(1e-6 * grid.size().minCoeff());  // not the cell that begins at an upper end
  for (const Source& source : sources_) {
    const Vec3 half = Vec3::Constant(spacing_ / 2) - rounding;
    for_each_cell_in(grid, {source.place - half, source.place + half}, cross);
  }
  for (const WallOpening& wall : walls_) {
    Box opening;
    opening.min[1 - wall.axis] = wall.across[0];
    opening.max[1 - wall.axis] = wall.across[1];
    opening.min.z() = wall.bottom;
    opening.max.z() = wall.bottom + static_cast<Real>(wall.displacement.size()) * wall.row_height;
    opening = {opening.min + rounding, opening.max - rounding};
    opening.min[wall.axis] = opening.max[wall.axis] =
        wall.at_max ? INFINITY : grid.low(grid.axis(0) == static_cast<std::size_t>(wall.axis) ? 0 : 1);
    for_each_cell_in(grid, opening, cross);
  }
}

// The cube around the source is filled, as far as it lies in the box.
void Openings::measure_source(const ProjectionGrid& grid, const Source& source) {
  std::array<LocalId, 3> from{}, to{};
  std::array<Real, 3> low{}, high{}, place{};  // in cells
  Real volume = 1;
  for (std::size_t a = 0; a < 3; ++a) {
    const Real half = spacing_ / 2 / grid.size()[static_cast<Eigen::Index>(a)];
    place[a] = grid.cells_to(source.place, a);
    low[a] = std::max(place[a] - half, Real{0});
    high[a] = std::min(place[a] + half, static_cast<Real>(grid.count(a)));
    from[a] = std::clamp(static_cast<LocalId>(low[a]), 0, grid.count(a) - 1);
    to[a] = std::clamp(static_cast<LocalId>(high[a]), 0, grid.count(a) - 1);
    volume *= high[a] - low[a];
  }
  for (LocalId k = from[0]; k <= to[0]; ++k) {
    for (LocalId r = from[1]; r <= to[1]; ++r) {
      for (LocalId c = from[2]; c <= to[2]; ++c) {
        const Cell cell{k, r, c};
        Real share = source.volume / grid.size().prod() / volume, ahead = 0;
        for (std::size_t a = 0; a < 3; ++a) {
          share *= overlap(cell[a], cell[a] + 1, low[a], high[a]);
          ahead += source.direction[static_cast<Eigen::Index>(grid.axis(a))] * (cell[a] + 0.5 - place[a]);
        }
        if (share > 0) add_gain(grid, source, cell, {share, ahead});
      }
    }
  }
}

// `cell` of the box, with its share and the distance of its centre ahead of the opening, in cells.
void Openings::add_gain(const ProjectionGrid& grid, const Source& source, const Cell& cell,
                        const std::pair<Real, Real>& share_ahead) {
  constexpr Real whole = -0.25;  // a cell this far behind the opening is itself the water behind it
  const auto [share, ahead] = share_ahead;
  const LocalId k = grid.own_plane(cell[0]), r = grid.own_row(cell[1]);
  if (k < 1 || k > grid.planes() || r < 0 || r >= grid.rows() || cell[2] >= grid.columns()) return;
  const std::size_t at = grid.index(k, r, cell[2]);
  const auto along = [&](std::size_t a) { return source.direction[static_cast<Eigen::Index>(grid.axis(a))]; };
  std::size_t main = 0;
  for (std::size_t a = 1; a < 3; ++a) main = std::abs(along(a)) > std::abs(along(main)) ? a : main;
  const bool up = along(main) > 0, wall = cell[main] == (up ? 0 : grid.count(main) - 1);
  const std::size_t before = up ? at - grid.step(main) : at + grid.step(main);
  const std::size_t behind = ahead < whole ? at : before;
  const auto same = [&](const Gain& gain) { return gain.cell == at && gain.behind == behind; };
  const auto known = std::find_if(gains_.rbegin(), gains_.rend(), same);
  const Real path = source.volume / (spacing_ * spacing_) / grid.size()[static_cast<Eigen::Index>(main)] * along(main);
  if (known != gains_.rend()) {
    known->share += share;
    if (std::abs(path) > std::abs(known->path)) known->path = path;
  } else {
    gains_.push_back(
        {k, r, cell[2], at, behind, wall && behind != at, share, main, up ? at : at + grid.step(main), path});
  }
}

void Openings::measure_wall(const ProjectionGrid& grid, const WallOpening& wall) {
  const std::size_t a = grid.axis(0) == static_cast<std::size_t>(wall.axis) ? 0 : 1;
  const LocalId last = a == 0 ? grid.planes() : grid.rows() - 1, first = a == 0 ? 1 : 0;
  const LocalId end = a == 0 ? grid.rows() : grid.planes() + 1;
  for (LocalId other = a == 0 ? 0 : 1; other < end; ++other) {
    for (LocalId c = 0; c < grid.columns(); ++c) {
      const LocalId along = wall.at_max ? last : first;
      measure_face(grid, wall, a == 0 ? Cell{along, other, c} : Cell{other, along, c});
    }
  }
}

void Openings::measure_face(const ProjectionGrid& grid, const WallOpening& wall, const Cell& cell) {
  const auto [k, r, c] = cell;
  const std::size_t a = grid.axis(0) == static_cast<std::size_t>(wall.axis) ? 0 : 1;
  const LocalId beyond = wall.at_max ? 1 : 0;
  if (!grid.is_wall(a, k + (a == 0 ? beyond : 0), r + (a == 1 ? beyond : 0), c)) return;
  const CellPlace place = grid.place_of(k, r, c);
  const auto from = [&](std::size_t b) {
    return place.origin[grid.axis(b)] + place.corner[grid.axis(b)] * grid.size()[static_cast<Eigen::Index>(b)];
  };
  const Real width = grid.size()[static_cast<Eigen::Index>(1 - a)], height = grid.size()[2];
  const Real left = from(1 - a), low = from(2);
  Real covered = 0, flux = 0;
  for (std::size_t n = 0; n < wall.displacement.size(); ++n) {
    const Real bottom = wall.bottom + static_cast<Real>(n) * wall.row_height;
    const Real part = overlap(low, low + height, bottom, bottom + wall.row_height) / height;
    covered += part;
    flux += part * wall.displacement[n];
  }
  const Real beside = overlap(left, left + width, wall.across[0], wall.across[1]) / width;
  constexpr Real rounding = 1e-9;
  if (covered * beside <= rounding) return;
  const std::size_t at = grid.index(k, r, c), face = at + (wall.at_max ? grid.step(a) : 0);
  through_[a][face] = flux / covered;
  faces_.push_back({at, a, face, wall.at_max, std::min(covered * beside, 1.0), wall.takes_all});
}

std::size_t Openings::bytes() const {
  return drained_.capacity() + crossed_.capacity() + closed_.capacity() + 3 * through_[0].capacity() * sizeof(Real) +
         faces_.capacity() * sizeof(Face) + drained_cells_.capacity() * sizeof(Drained);
}

}  // namespace trevi
