// The geometry of one cell: the open fractions of its faces and of its volume.
#include <algorithm>
#include <cmath>

#include "projection/cut_cells.hpp"

namespace trevi {

namespace {

// A cell with less open volume than this counts as solid. Such a sliver may hold no particle, but if it is left out of
// a cell at a curved wall, a rigid rotation seems to have a divergence there, which slows the water down.
constexpr Real min_open = 2e-4;
// With less open volume than `sliver`, a cell is open only if one of its corners or midpoints lies outside the solids
// by more than `min_reach`, cells. Beside an edge of a solid whose faces coincide with those of cells, the slopes of
// the samples leave 1e-3 of a solid cell open.
constexpr Real sliver = 3e-3, min_reach = 1e-6;
// The same for what is left between a freely moving body and another solid that it touches: a few such cells, open to
// each other and to hardly any others, had a pressure of sixty times that of their depth as the body moved.
constexpr Real hair = 0.03;
// Square of the slope of the distance below which an edge is near.
constexpr Real flat = 0.9;
// Of a distance of one sample, which is that of places behind which solids touch (depth_below()).
constexpr Real edge_rounding = 1e-6;

}  // namespace

// Behind the surface of a sheet there is no solid any more a cell further in. A line that just grazes a thick solid is
// open.
bool CutCells::meets_sheet(const Vec3& from, const Vec3& to, const Bodies& bodies) const {
  for (const std::size_t k : bodies) {
    const Body& body = obstacles_.body(k);
    const Vec3 begin = body.midway().into_body(from), end = body.midway().into_body(to);
    if (!body.may_cross(begin, end)) continue;
    const auto part = body.first_contact({{begin, from}, {end, to}});
    if (!part) continue;
    const Vec3 contact = begin + *part * (end - begin);
    if (body.shape().distance(contact - size_.maxCoeff() * body.shape().normal(contact)) > 0) return true;
  }
  return false;
}

// Whether one can pass through a face, at a given point of it, from the centre of one cell to that of the other. If a
// centre is inside a solid, the far side of its cell is used instead, so that a sheet right at the centre of a cell is
// noticed.
bool CutCells::is_passage(std::size_t a, const Vec3& on_face, const Bodies& bodies) const {
  const Vec3 step = Vec3::Unit(static_cast<Eigen::Index>(a));
  Vec3 low = place(on_face - step / 2), high = place(on_face + step / 2);
  if (nearest_at(low, bodies).distance < 0) low = place(on_face - step);
  if (nearest_at(high, bodies).distance < 0) high = place(on_face + step);
  if (nearest_at(low, bodies).distance < 0 || nearest_at(high, bodies).distance < 0) return true;
  return !meets_sheet(low, high, bodies);
}

// From the distances at samples that are `stride` apart in memory: central differences, one-sided ones at the ends.
template <std::size_t stride>
void CutCells::find_slopes(std::span<const Real> distance, std::span<Real> slope) {
  for (std::size_t first = 0; first < distance.size(); first += stride * samples) {
    const Real* const d = &distance[first];
    Real* const of = &slope[first];
    for (std::size_t n = 0; n < stride; ++n) of[n] = d[n + stride] - d[n];
    for (std::size_t n = stride; n < (samples - 1) * stride; ++n) of[n] = (d[n + stride] - d[n - stride]) * 0.5;
    for (std::size_t n = (samples - 1) * stride; n < samples * stride; ++n) of[n] = d[n] - d[n - stride];
  }
}

// How deep a place is in the solids; `nearest`: that in which it is deepest, and how deep. Where the surface of this
// one lies on another solid, or in it, there is no water behind it, and the depth is at least that of the place one
// sample further on, where the next surface may lie on a solid as well: `surfaces` of them are looked at, because three
// planes meet in a corner. When the plane in which two solids touch counted as their surface, a crack of cells a few
// hundredths open led out of cavities.
Real CutCells::depth_below(const Vec3& p, const Nearest& nearest, Real width, const Bodies& bodies,
                           int surfaces) const {
  constexpr Real just_outside = 1e-3;  // of a sample
  const Real depth = -nearest.distance;
  if (depth >= width || surfaces == 0) return depth;
  const Body& body = obstacles_.body(nearest.body);
  const Vec3 outwards = body.midway().turn * body.shape().normal(body.midway().into_body(p));
  const Vec3 surface = p + depth * outwards, next = in_box(surface + width * outwards);
  if (nearest_at(surface + just_outside * width * outwards, bodies).distance >= 0) return depth;
  const Nearest there = nearest_at(next, bodies);
  return there.distance >= 0 ? depth : std::max(depth, depth_below(next, there, width, bodies, surfaces - 1));
}

// Distances in samples, at the samples of squares across direction a of a cell, `along` cells from its corner, one
// square after the other.
void CutCells::find_distances(const Vec3& corner, std::size_t a, std::span<const Real> along, const Bodies& bodies,
                              std::span<Real> distance) const {
  std::array<std::array<Real, samples>, 3> coordinate{};  // by direction
  const auto put = [&](std::size_t b, std::size_t k, Real in_cell) {
    coordinate[b][k] = in_box(axis_[b], place(b, corner[static_cast<Eigen::Index>(b)] + in_cell));
  };
  const std::size_t u = (a + 1) % 3, v = (a + 2) % 3, count = along.size() * samples * samples;
  for (std::size_t k = 0; k < along.size(); ++k) put(a, k, along[k]);
  for (std::size_t k = 0; k < samples; ++k) {
    put(u, k, sample_at[k]);
    put(v, k, sample_at[k]);
  }
  // By direction: the number of samples, and their distance from each other in memory.
  std::array<std::size_t, 3> number{samples, samples, samples}, stride{};
  number[a] = along.size();
  stride[a] = samples * samples;
  stride[u] = samples;
  stride[v] = 1;
  std::array<Vec3, samples * samples * samples> there;
  std::array<Real, samples * samples * samples> own;
  std::array<std::size_t, samples * samples * samples> nearest;
  const bool is_alone = bodies.size() == 1;
  if (!is_alone) std::fill(distance.begin(), distance.end(), INFINITY);
  for (const std::size_t body : bodies) {
    const Pose& pose = obstacles_.body(body).midway();
    // The contribution of each world coordinate to those of the body, as in Pose::into_body(), in the same order.
    // Direction 2 is z.
    std::array<std::array<Vec3, samples>, 3> part;
    for (std::size_t b = 0; b < 3; ++b) {
      const Vec3 row = pose.turn.row(axis_[b]).transpose();
      for (std::size_t k = 0; k < number[b]; ++k) part[b][k] = row * (coordinate[b][k] - pose.center[axis_[b]]);
    }
    for (std::size_t i = 0; i < number[0]; ++i) {
      for (std::size_t j = 0; j < number[1]; ++j) {
        const Vec3 level = part[0][i] + part[1][j];
        Vec3* const line = &there[i * stride[0] + j * stride[1]];
        for (std::size_t k = 0; k < number[2]; ++k) line[k * stride[2]] = level + part[2][k];
      }
    }
    obstacles_.body(body).rough_distances({there.data(), count}, is_alone ? distance : std::span<Real>(own));
    for (std::size_t n = 0; n < count && !is_alone; ++n) {
      if (own[n] >= distance[n]) continue;
      distance[n] = own[n];
      nearest[n] = body;
    }
  }
  const Real width = size_.maxCoeff() / samples;
  for (std::size_t n = 0; n < count && !is_alone; ++n) {
    if (!(distance[n] < 0 && distance[n] > -width)) continue;
    Vec3 p;
    for (std::size_t b = 0; b < 3; ++b) p[axis_[b]] = coordinate[b][n / stride[b] % number[b]];
    distance[n] = -depth_below(p, {distance[n], nearest[n]}, width, bodies, 3);
  }
  for (Real& one : distance) one /= width;
}

// From whatever point one looks.
bool CutCells::are_clear(const Bodies& bodies) const {
  const Vec3 margin = Vec3::Constant(size_.maxCoeff());
  const Box within{box_.min + margin, box_.max - margin};
  return std::all_of(bodies.begin(), bodies.end(), [&](std::size_t k) {
    const Body& body = obstacles_.body(k);
    const Box place = body.surface_box();
    return body.shape().min_thickness() > 1.1 * size_.maxCoeff() && !body.is_vessel() && within.contains(place.min) &&
           within.contains(place.max);
  });
}

bool CutCells::are_thick(const Vec3& middle, const Bodies& bodies) const {
  const Real size = size_.maxCoeff();
  const Vec3 margin = Vec3::Constant(size);
  const Box within{box_.min + margin, box_.max - margin};
  const bool far_from_walls = Box{within.min + margin, within.max - margin}.contains(middle);
  return std::all_of(bodies.begin(), bodies.end(), [&](std::size_t k) {
    const Body& body = obstacles_.body(k);
    if (!(body.shape().min_thickness() > 1.1 * size)) return false;
    const Box place = body.surface_box();
    return far_from_walls || (!body.is_vessel() && within.contains(place.min) && within.contains(place.max));
  });
}

// The lower face of the cell in direction a; `corner` of the cell, in cells.
void CutCells::measure_face(std::size_t a, const Vec3& corner, const Candidates& near, Cell& cell) const {
  const Bodies& bodies = near.of_cell;
  const auto b = static_cast<Eigen::Index>(a), u = (b + 1) % 3, v = (b + 2) % 3;
  Vec3 middle = corner;
  middle[u] += 0.5;
  middle[v] += 0.5;
  const Real far = nearest_at(place(middle), bodies).distance;
  // The distance to which is_passage() looks, or without sheets the distance within which the surface may meet the
  // face.
  const Real reach = (near.thick ? 0.75 : 1.5) * size_.maxCoeff();
  if (std::abs(far) > reach) {
    cell.face[a] = far > 0 ? 1 : 0;
    return;
  }
  SquareOfDistances distance, slope_u, slope_v;
  find_distances(corner, a, std::array<Real, 1>{0}, bodies, distance);
  find_slopes<samples>(distance, slope_u);
  find_slopes<1>(distance, slope_v);
  Real sum = 0;
  std::array<Real, 2> moment{};
  for (std::size_t i = 0; i < samples; ++i) {
    for (std::size_t j = 0; j < samples; ++j) {
      const std::size_t n = i * samples + j;
      const SquarePart part = clipped_square(distance[n], {slope_u[n], slope_v[n]});
      if (part.area <= 0) continue;
      if (!near.thick) {
        Vec3 on_face = corner;
        on_face[u] += sample_at[i];
        on_face[v] += sample_at[j];
        if (!is_passage(a, on_face, bodies)) continue;
      }
      sum += part.area;
      moment[0] += part.area * sample_at[i] + part.moment[0] / samples;
      moment[1] += part.area * sample_at[j] + part.moment[1] / samples;
    }
  }
  const Real open = sum / (samples * samples);
  cell.face[a] = open > 0 && open < hair && is_hair_beside_body(place(middle), bodies) ? 0 : static_cast<float>(open);
  for (std::size_t i = 0; i < 2 && sum > 0; ++i) cell.middle[a][i] = static_cast<float>(moment[i] / sum);
}

// The solid fraction of a sample with this corner, from samples of its own.
Real CutCells::solid_part(const Vec3& corner, const Bodies& bodies) const {
  const Real width = size_.maxCoeff() / (samples * samples);
  Real sum = 0;
  for (std::size_t n = 0; n < samples * samples * samples; ++n) {
    const Vec3 in_sample(sample_at[n % samples], sample_at[n / samples % samples], sample_at[n / samples / samples]);
    const Real distance = nearest_at(place(corner + in_sample / samples), bodies).distance;
    sum += std::clamp(0.5 - distance / width, 0.0, 1.0);
  }
  return sum / (samples * samples * samples);
}

// Linear in each sample, as for the faces.
Real CutCells::open_at(const Vec3& corner, const Bodies& bodies, Samples& at, Cell& cell) const {
  find_distances(corner, 2, sample_at, bodies, at.distance);
  find_slopes<samples * samples>(at.distance, at.slope[0]);
  find_slopes<samples>(at.distance, at.slope[1]);
  find_slopes<1>(at.distance, at.slope[2]);
  Real sum = 0;
  for (std::size_t n = 0; n < at.open.size(); ++n) {
    at.open[n] = clipped_cube(at.distance[n], {at.slope[0][n], at.slope[1][n], at.slope[2][n]});
    sum += at.open[n];
  }
  measure_solid(corner, at, bodies, cell);
  return sum / (samples * samples * samples);
}

// The centroid of the solid is that of its parts in the samples, which lie off the centres of these along the slope.
void CutCells::measure_solid(const Vec3& corner, const Samples& at, const Bodies& bodies, Cell& cell) const {
  const bool floats = any_floats() && obstacles_.floating()->holds(cell.nearest);  // its volume is what is not open
  Real solid = 0, whole = 0;
  std::array<Real, 3> moment{};
  for (std::size_t n = 0; n < at.open.size(); ++n) {
    const Real closed = 1 - at.open[n];
    if (closed == 0 && floats) continue;
    const std::array<Real, 3> rise{at.slope[0][n], at.slope[1][n], at.slope[2][n]};
    const bool at_edge = !floats && rise[0] * rise[0] + rise[1] * rise[1] + rise[2] * rise[2] < flat &&
                         std::abs(at.distance[n]) < 1 - edge_rounding;
    if (closed == 0 && !at_edge) continue;
    const std::array<std::size_t, 3> here{n / samples / samples, n / samples % samples, n % samples};
    const auto in_cell = [&](std::size_t a) { return static_cast<Real>(here[a]) / samples; };
    solid += at_edge ? solid_part(corner + Vec3(in_cell(1), in_cell(2), in_cell(0)), bodies) : closed;
    if (closed == 0) continue;
    whole += closed;
    const std::array<Real, 3> off = middle_below(closed, rise);
    for (std::size_t a = 0; a < 3; ++a) moment[(a + 2) % 3] += closed * (sample_at[here[a]] + off[a] / samples);
  }
  for (std::size_t a = 0; a < 3 && whole > 0; ++a) cell.solid_middle[a] = static_cast<float>(moment[a] / whole);
  cell.solid = static_cast<float>(solid / (samples * samples * samples));
}

// The shares of the open part of a sample are those of its centre, except that water is never nearer than half a
// spacing to a solid below or above it.
void CutCells::find_shares(const Vec3& corner, const Samples& at, Candidates& candidates) const {
  constexpr std::size_t lines = samples * samples;
  const std::array<Real, 3> place = from_box(corner);
  std::array<const SharesAlong*, 3> of_samples{};
  for (std::size_t a = 0; a < 3; ++a) of_samples[a] = shares_of_samples(a, place[a], candidates.of_samples[a]);
  // For the open parts of samples above each other: the shares in the cell below, in the cell itself, and in the one
  // above.
  std::array<std::array<Real, lines>, 3> of_lines{};
  for (std::size_t level = 0; level < samples; ++level) {
    std::array<std::array<Real, lines>, 3> w;
    for (std::size_t m = 0; m < 3; ++m) w[m].fill(of_samples[2][level][m]);
    for (std::size_t line = 0; line < lines; ++line) {
      const std::size_t n = level * lines + line;
      const Real height = off_solid(sample_at[level], at.distance[n], at.slope[0][n]);
      if (height == sample_at[level] || at.open[n] == 0) continue;
      const SharesAlong own = shares_along(2, height, place[2]);
      for (std::size_t m = 0; m < 3; ++m) w[m][line] = own[m];
    }
    const Real* const open = &at.open[level * lines];
    for (std::size_t m = 0; m < 3; ++m) {
      for (std::size_t line = 0; line < lines; ++line) of_lines[m][line] += open[line] * w[m][line];
    }
  }
  std::array<Real, 27> shared{};
  for (std::size_t i = 0; i < samples; ++i) {
    std::array<Real, 9> of_plane{};
    for (std::size_t j = 0; j < samples; ++j)
      for (std::size_t n = 0; n < 9; ++n) of_plane[n] += of_samples[1][j][n / 3] * of_lines[n % 3][i * samples + j];
    for (std::size_t k = 0; k < 3; ++k)
      for (std::size_t n = 0; n < 9; ++n) shared[9 * k + n] += of_samples[0][i][k] * of_plane[n];
  }
  for (std::size_t n = 0; n < shared.size(); ++n)
    candidates.shares[n] = static_cast<float>(shared[n] / (samples * samples * samples));
}

// Whether a corner of a cell, the midpoint of one of its edges or faces, or its centre lies outside the solids.
bool CutCells::reaches_open(const Vec3& corner, const Bodies& bodies) const {
  for (int n = 0; n < 27; ++n) {
    const Vec3 p = place(corner + 0.5 * Vec3(n % 3, n / 3 % 3, n / 9));
    if (nearest_at(p, bodies).distance > min_reach * size_.maxCoeff()) return true;
  }
  return false;
}

// In two dimensions there are no walls on both sides of the layer.
bool CutCells::is_at_wall(const Vec3& p) const {
  for (std::size_t a = 0; a < 3; ++a) {
    const Real size = size_[static_cast<Eigen::Index>(a)], low = box_.min[axis_[a]], high = box_.max[axis_[a]];
    if (high - low > 1.5 * size && std::min(p[axis_[a]] - low, high - p[axis_[a]]) < size) return true;
  }
  return false;
}

// Whether a sliver may be what is open between a freely moving body that touches another solid and that.
bool CutCells::is_hair_beside_body(const Vec3& middle, const Bodies& bodies) const {
  if (!any_floats()) return false;
  const bool at_wall = is_at_wall(middle);
  if (bodies.size() < 2 && !at_wall) return false;
  const SolidsNear solids = solids_near(middle, size_.norm() / 2, bodies);
  return !solids.bodies.empty() && (at_wall || solids.bodies.size() + solids.others.size() > 1);
}

CutCells::Cell CutCells::cell_at(const Vec3& corner, Candidates& candidates) const {
  Cell cell;
  const Vec3 middle = place(corner + Vec3::Constant(0.5));
  const Nearest far = nearest_at(middle, candidates.of_row);
  find_nearest(corner, far, candidates.of_row, cell);
  // If the distance is larger, no face is nearer than this less half a cell, which is the distance to which
  // is_passage() looks, or that of the surface where all solids are thick.
  candidates.near = std::abs(far.distance) <= (candidates.clear ? 1.26 : 2) * size_.maxCoeff();
  if (!candidates.near) {
    cell.open = far.distance > 0 ? 1 : 0;
    cell.solid = 1 - cell.open;
    cell.face.fill(cell.open);
    return cell;
  }
  const Bodies& bodies = candidates.of_cell;
  if (candidates.of_row.size() == 1) {
    candidates.of_cell = candidates.of_row;
  } else {
    keep_near(middle, looked_at * size_.maxCoeff(), candidates.of_row, candidates.of_cell, candidates.distance);
  }
  candidates.thick = candidates.clear || are_thick(middle, bodies);
  for (std::size_t a = 0; a < 3; ++a) measure_face(a, corner, candidates, cell);
  if (std::abs(far.distance) > size_.norm() / 2) {
    cell.open = far.distance > 0 ? 1 : 0;
    cell.solid = 1 - cell.open;
    return cell;
  }
  Samples at;
  const Real open = open_at(corner, bodies, at, cell);
  find_shares(corner, at, candidates);
  const bool solid = open < min_open || (open < sliver && !reaches_open(corner, bodies)) ||
                     (open < hair && is_hair_beside_body(middle, bodies));
  cell.open = solid ? 0 : static_cast<float>(open);
  if (cell.open == 0) cell.solid = 1;
  cell.has_shares = cell.open > 0;
  return cell;
}

}  // namespace trevi
