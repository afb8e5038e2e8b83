#include "projection/cut_cells.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "parallel/reductions.hpp"

namespace trevi {

namespace {

constexpr int samples = 4;  // in each direction of a cell
// A cell with less open volume has no water: no particle comes nearer to a wall than half a spacing, a quarter of a
// cell, which leaves at least 0.0135 where it is in the corner of a cell.
constexpr Real least_open = 0.013;

// How far from the middle of a cell one looks for it, in cells: from a face of it a cell further, 1.66.
constexpr Real looked_at = 1.7;

Real sample(int k) { return (k + 0.5) / samples; }

}  // namespace

CutCells::CutCells(const Obstacles& obstacles) : obstacles_(obstacles), all_bodies_(obstacles.count()) {
  std::iota(all_bodies_.begin(), all_bodies_.end(), std::size_t{0});
}

Vec3 CutCells::place(const Vec3& in_cells) const {
  Vec3 p;
  for (std::size_t a = 0; a < 3; ++a) {
    const auto b = static_cast<Eigen::Index>(a);
    // Counted from the start of the box first, which is exact: the same place on whatever rank.
    p[axis_[a]] = origin_[b] + (in_cells[b] + (a == 0 ? first_ - 1 : 0)) * size_[b];
  }
  return p;
}

Vec3 CutCells::middle(LocalId k, LocalId r, LocalId c) const { return place(Vec3(k + 0.5, r + 0.5, c + 0.5)); }

Vec3 CutCells::in_box(const Vec3& p) const {
  const Vec3 gap = Vec3::Constant(size_.maxCoeff() / (2 * samples));
  return p.cwiseMax(box_.min + gap).cwiseMin(box_.max - gap);
}

CutCells::Nearest CutCells::nearest_at(const Vec3& p, const Bodies& bodies) const {
  Nearest nearest{INFINITY, 0};
  const Vec3 inside = in_box(p);
  for (const std::size_t k : bodies) {
    const Body& body = obstacles_.body(k);
    const Real d = body.rough_distance(body.now().into_body(inside));
    if (d < nearest.distance) nearest = {d, k};
  }
  return nearest;
}

// All that may be the nearest somewhere within `reach` of p, or be met there: a distance changes by no more than one
// goes. Rough ones may change by more, and are kept.
void CutCells::keep_near(const Vec3& p, Real reach, const Bodies& all, Bodies& kept,
                         std::vector<Real>& distance) const {
  const Vec3 inside = in_box(p);
  Real nearest = INFINITY;
  distance.clear();
  for (const std::size_t k : all) {
    const Body& body = obstacles_.body(k);
    distance.push_back(body.is_rough() ? -INFINITY : body.rough_distance(body.now().into_body(inside)));
    if (!body.is_rough()) nearest = std::min(nearest, distance.back());
  }
  const Real most = std::max(nearest, 0.0) + 2 * reach;
  kept.clear();
  for (std::size_t n = 0; n < all.size(); ++n) {
    if (distance[n] <= most) kept.push_back(all[n]);
  }
}

// visit(k, r, candidates) for each row of owned and ghost planes.
template <class Visit>
void CutCells::for_each_row_near(const ProjectionGrid& grid, const Visit& visit) {
  const Real reach = (0.5 * grid.columns() + looked_at) * size_.maxCoeff();
  for_each_part((grid.planes() + 2) * grid.rows(), [&](LocalId row) {
    const LocalId k = row / grid.rows(), r = row % grid.rows();
    Candidates& own = candidates_.mine();
    keep_near(place(Vec3(plane_of(grid, k) + 0.5, r + 0.5, 0.5 * grid.columns())), reach, all_bodies_, own.of_row,
              own.distance);
    visit(k, r, own);
  });
}

// Behind the surface of a sheet there is no more solid a cell further in; a line that just grazes a thick solid is
// open.
bool CutCells::meets_sheet(const Vec3& from, const Vec3& to, const Bodies& bodies) const {
  for (const std::size_t k : bodies) {
    const Body& body = obstacles_.body(k);
    const Vec3 begin = body.now().into_body(from), end = body.now().into_body(to);
    if (!body.may_cross(begin, end)) continue;
    const auto part = body.first_contact({{begin, from}, {end, to}});
    if (!part) continue;
    const Vec3 contact = begin + *part * (end - begin);
    if (body.shape().distance(contact - size_.maxCoeff() * body.shape().normal(contact)) > 0) return true;
  }
  return false;
}

// Whether one can go through a face at a point of it from the middle of one cell to that of the other; where a middle
// is in a solid, from the far side of its cell, so that a sheet in the very middle of a cell is noticed.
bool CutCells::is_passage(std::size_t a, const Vec3& on_face, const Bodies& bodies) const {
  const Vec3 step = Vec3::Unit(static_cast<Eigen::Index>(a));
  Vec3 low = place(on_face - step / 2), high = place(on_face + step / 2);
  if (nearest_at(low, bodies).distance < 0) low = place(on_face - step);
  if (nearest_at(high, bodies).distance < 0) high = place(on_face + step);
  if (nearest_at(low, bodies).distance < 0 || nearest_at(high, bodies).distance < 0) return true;
  return !meets_sheet(low, high, bodies);
}

// `corner` of the cell, in cells; its lower face in direction a.
void CutCells::measure_face(std::size_t a, const Vec3& corner, const Bodies& bodies, Cell& cell) const {
  const auto b = static_cast<Eigen::Index>(a), u = (b + 1) % 3, v = (b + 2) % 3;
  const Real width = size_.maxCoeff() / samples;
  Vec3 middle = corner;
  middle[u] += 0.5;
  middle[v] += 0.5;
  const Real far = nearest_at(place(middle), bodies).distance;
  const Real reach = 1.5 * size_.maxCoeff();  // to where is_passage() looks
  if (std::abs(far) > reach) {
    cell.face[a] = far > 0 ? 1 : 0;
    return;
  }
  Real sum = 0;
  std::array<Real, 2> moment{};
  for (int i = 0; i < samples; ++i) {
    for (int j = 0; j < samples; ++j) {
      Vec3 on_face = corner;
      on_face[u] += sample(i);
      on_face[v] += sample(j);
      const Real share = std::clamp(0.5 + nearest_at(place(on_face), bodies).distance / width, 0.0, 1.0);
      if (share <= 0 || !is_passage(a, on_face, bodies)) continue;
      sum += share;
      moment[0] += share * sample(i);
      moment[1] += share * sample(j);
    }
  }
  cell.face[a] = static_cast<float>(sum / (samples * samples));
  for (std::size_t i = 0; i < 2 && sum > 0; ++i) cell.middle[a][i] = static_cast<float>(moment[i] / sum);
}

// From each sample near the surface straight to it; each counts as far as the surface there lies flat, since it is the
// upward pressure that needs the height.
Real CutCells::surface_at(const Vec3& corner, const Bodies& bodies) const {
  const Real width = size_.maxCoeff() / samples, step = width / 100;
  Real sum = 0, weight = 0;
  for (int i = 0; i < samples * samples * samples; ++i) {
    const Vec3 in_cell(sample(i % samples), sample(i / samples % samples), sample(i / samples / samples));
    const Vec3 p = place(corner + in_cell), up = step * Vec3::UnitZ();
    const Real d = nearest_at(p, bodies).distance, w = std::max(1 - std::abs(d) / width, 0.0);
    if (w == 0) continue;
    const Real slope = (nearest_at(p + up, bodies).distance - nearest_at(p - up, bodies).distance) / (2 * step);
    sum += w * std::abs(slope) * ((in_cell.z() - 0.5) * size_.z() - d * slope);
    weight += w * std::abs(slope);
  }
  return weight > 0 ? sum / weight : 0;
}

Real CutCells::open_at(const Vec3& corner, const Bodies& bodies) const {
  const Real width = size_.maxCoeff() / samples;
  Real sum = 0;
  for (int i = 0; i < samples * samples * samples; ++i) {
    const Vec3 in_cell(sample(i % samples), sample(i / samples % samples), sample(i / samples / samples));
    sum += std::clamp(0.5 + nearest_at(place(corner + in_cell), bodies).distance / width, 0.0, 1.0);
  }
  return sum / (samples * samples * samples);
}

CutCells::Cell CutCells::cell_at(const Vec3& corner, Candidates& candidates) const {
  Cell cell;
  const Vec3 middle = place(corner + Vec3::Constant(0.5));
  const Nearest far = nearest_at(middle, candidates.of_row);
  cell.nearest = static_cast<std::uint32_t>(far.body);
  if (std::abs(far.distance) > 2 * size_.maxCoeff()) {  // no face of it comes within reach of is_passage()
    cell.open = far.distance > 0 ? 1 : 0;
    cell.face.fill(cell.open);
    return cell;
  }
  const Bodies& bodies = candidates.of_cell;
  keep_near(middle, looked_at * size_.maxCoeff(), candidates.of_row, candidates.of_cell, candidates.distance);
  for (std::size_t a = 0; a < 3; ++a) measure_face(a, corner, bodies, cell);
  // Surfaces a little outside of the cell count where a face of it is closed.
  if (std::abs(far.distance) < 0.75 * size_.norm()) cell.surface = static_cast<float>(surface_at(corner, bodies));
  if (std::abs(far.distance) > size_.norm() / 2) {
    cell.open = far.distance > 0 ? 1 : 0;
    return cell;
  }
  const Real open = open_at(corner, bodies);
  cell.open = open < least_open ? 0 : static_cast<float>(open);
  return cell;
}

// The plane whose cells those of plane k are like: for a ghost plane beyond the end of a periodic box, that at its
// other end.
LocalId CutCells::plane_of(const ProjectionGrid& grid, LocalId k) const {
  const LocalId all = grid.count(0);
  return grid.repeats()[0] ? (k - 1 + first_ + all) % all - first_ + 1 : k;
}

void CutCells::measure_cells(const ProjectionGrid& grid, std::vector<Cell>& cells) {
  cells.assign(grid.cells(), Cell{});
  for_each_row_near(grid, [&](LocalId k, LocalId r, Candidates& near) {
    for (LocalId c = 0; c < grid.columns(); ++c)
      cells[grid.index(k, r, c)] = cell_at(Vec3(plane_of(grid, k), r, c), near);
  });
  grid.repeat(cells);
  for_each_part({0, grid.planes() + 2}, 1, [&](Range plane) {
    const LocalId k = plane.begin;
    for (LocalId r = 0; r < grid.rows(); ++r) {
      for (LocalId c = 0; c < grid.columns(); ++c) {
        const std::size_t at = grid.index(k, r, c);
        for (std::size_t a = 0; a < 3; ++a) {
          const bool low_closed = (a > 0 || k > 0) && cells[at - grid.step(a)].open == 0;
          if (low_closed || cells[at].open == 0) cells[at].face[a] = 0;
        }
      }
    }
  });
  grid.repeat(cells);
}

// Of the solid that is nearest to the middle of each face.
void CutCells::measure_motion(const ProjectionGrid& grid) {
  moved_.assign(grid.cells(), {0, 0, 0});
  for_each_row_near(grid, [&](LocalId k, LocalId r, const Candidates& near) {
    for (LocalId c = 0; c < grid.columns(); ++c) {
      const std::size_t at = grid.index(k, r, c);
      for (std::size_t a = 0; a < 3; ++a) {
        if (cells_[at].face[a] == 1) continue;
        const Vec3 p =
            place(Vec3(plane_of(grid, k) + 0.5, r + 0.5, c + 0.5) - Vec3::Unit(static_cast<Eigen::Index>(a)) / 2);
        const Body& body = obstacles_.body(nearest_at(p, near.of_row).body);
        const Vec3 way = p - body.before().into_world(body.now().into_body(p));
        moved_[at][a] = static_cast<float>(way[axis_[a]]);
      }
    }
  });
  grid.repeat(moved_);
}

void CutCells::take_columns(const ProjectionGrid& grid) {
  ProjectionGrid whole = grid;
  whole.resize(planes_, grid.count(2));
  cells_.resize(grid.cells());
  const auto length = static_cast<std::ptrdiff_t>(grid.columns()) + 2;
  for_each_part((grid.planes() + 2) * (grid.rows() + 2), [&](LocalId row) {
    const LocalId k = row / (grid.rows() + 2), r = row % (grid.rows() + 2) - 1;
    const auto from = static_cast<std::ptrdiff_t>(whole.index(k, r, 0)) - 1;
    std::copy_n(all_.begin() + from, length, cells_.begin() + static_cast<std::ptrdiff_t>(grid.index(k, r, 0)) - 1);
  });
}

// Faces of a row's upper neighbours are its own, too.
void CutCells::find_cut_rows(const ProjectionGrid& grid) {
  rows_ = grid.rows();
  cuts_row_.assign(row_index(grid.planes() + 2, 0), 0);
  for_each_row(grid.rows_of({0, grid.planes() + 2}), [&](LocalId k, LocalId r) {
    const auto is_cut = [&](std::size_t at) {
      const Cell& cell = cells_[at];
      return cell.open < 1 || cell.face[0] < 1 || cell.face[1] < 1 || cell.face[2] < 1;
    };
    bool cut = false;
    for (LocalId c = 0; c <= grid.columns(); ++c) {
      const std::size_t at = grid.index(k, r, c);
      cut = cut || is_cut(at) || is_cut(at + grid.step(1)) || (k <= grid.planes() && is_cut(at + grid.step(0)));
    }
    cuts_row_[row_index(k, r)] = cut ? 1 : 0;
  });
}

void CutCells::measure(MPI_Comm comm, const ProjectionGrid& grid, const Box& box) {
  const auto first = static_cast<LocalId>(sum_over_lower_ranks(comm, grid.planes()));
  const bool stays = first == first_ && grid.planes() == planes_;
  for (std::size_t a = 0; a < 3; ++a) {
    const auto b = static_cast<Eigen::Index>(a);
    axis_[a] = static_cast<int>(grid.axis(a));
    size_[b] = grid.size()[b];
    origin_[b] = box.min[axis_[a]];
  }
  box_ = box;
  first_ = first;
  planes_ = grid.planes();
  if (obstacles_.moves()) {
    measure_cells(grid, cells_);
    measure_motion(grid);
    find_cut_rows(grid);
    return;
  }
  if (!stays) {
    ProjectionGrid whole = grid;
    whole.resize(planes_, grid.count(2));
    measure_cells(whole, all_);
  }
  if (stays && cells_.size() == grid.cells()) return;
  take_columns(grid);
  find_cut_rows(grid);
}

}  // namespace trevi
