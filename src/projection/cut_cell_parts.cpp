// What each of several solids closes of a face and fills of a cell, and how it moves the face.
#include <algorithm>
#include <cmath>

#include "projection/cut_cells.hpp"

namespace trevi {

namespace {

// Of a face or a cell: a solid that closes less of it, by rounding, closes none of it.
constexpr Real min_share = 1e-6;
// Distance from a face within which solids may close some of it, in cells.
constexpr Real max_distance = 1.2;

}  // namespace

Real CutCells::displacement(const PartOfFace& part) const {
  if (!obstacles_.floating()->holds(part.solid)) return part.share * part.given;
  return part.share * obstacles_.body(part.solid).displacement_at(part.middle)[axis_[part.a]];
}

// Those within `reach` of a place. Of floating bodies, the nearest ones.
CutCells::SolidsNear CutCells::solids_near(const Vec3& p, Real reach, const Bodies& near) const {
  SolidsNear found;
  std::vector<Nearest> bodies;
  const Vec3 inside = in_box(p);
  for (const std::size_t k : near) {
    const Real d = distance_to(obstacles_.body(k), inside);
    if (d > reach) continue;
    if (obstacles_.floating()->holds(k)) {
      // Not of a cell beyond its zone (zone_of()), which is not measured in each substep.
      const Box place = obstacles_.body(k).surface_box();
      const Vec3 margin = Vec3::Constant(max_distance * size_.maxCoeff());
      if (!Box{place.min - margin, place.max + margin}.contains(inside)) continue;
      bodies.push_back({d, k});
    } else {
      found.others.push_back(k);
    }
  }
  if (bodies.size() > SolidParts::max_bodies) {
    std::stable_sort(bodies.begin(), bodies.end(),
                     [](const Nearest& one, const Nearest& other) { return one.distance < other.distance; });
    bodies.resize(SolidParts::max_bodies);
  }
  for (const Nearest& one : bodies) found.bodies.push_back(one.body);
  return found;
}

// Where several solids are near, each is measured by itself. If there is a solid cell on one side of the face, what
// closes it on the other side is in front of it, and only the rest of the face belongs to what fills the solid cell: of
// a box that lies on a wider one, the upper one has the part beneath it. With each face given to the nearest body, one
// of two boxes on each other missed a third of its buoyancy, and a body half a spacing above a slab was pressed onto
// it.
void CutCells::find_parts_of_face(const AtFace& face, const Bodies& near, std::vector<PartOfFace>& parts) const {
  const std::size_t a = face.a, at = face.at;
  const Vec3 half = Vec3::Constant(0.5) - Vec3::Unit(static_cast<Eigen::Index>(a)) / 2, p = place(face.corner + half);
  const SolidsNear solids = solids_near(p, max_distance * size_.maxCoeff(), near);
  const Bodies &bodies = solids.bodies, &others = solids.others;
  if (bodies.empty()) return;
  const Vec3 middle = middle_of_closed(a, face.cell, at);
  if (bodies.size() == 1 && others.empty()) {
    parts.push_back({at, a, bodies.front(), 1, middle});
    return;
  }
  struct Part {
    std::size_t solid;
    Real front, behind;
    Vec3 middle;
  };
  std::array<Part, SolidParts::max_solids> all;
  std::size_t count = 0;
  const Real side = side_of_solid(face);
  Real in_front = 0, behind = 0;
  const auto measure = [&](const Bodies& of, std::size_t solid) {
    const Cell front = closed_by(of, a, face.corner, -side);
    const Cell back = side == 0 ? front : closed_by(of, a, face.corner, side);
    const Real first = 1 - front.face[a], more = std::max<Real>(front.face[a] - back.face[a], 0);
    if (first + more < min_share) return;
    const Vec3 sum = first * middle_of_closed(a, face.cell, front) + more * middle_of_closed(a, face.cell, back);
    all[count++] = {solid, first, more, sum / (first + more)};
    in_front += first;
    behind += more;
  };
  for (const std::size_t k : bodies) measure({k}, k);
  const std::size_t other = others.empty() ? 0 : nearest_at(p, others).body;
  if (!others.empty()) measure(others, other);
  const auto given_by = [&](std::size_t solid) {
    const bool alone = count == 0 || (count == 1 && all[0].solid == other);
    return obstacles_.floating()->holds(solid) ? 0
           : alone                             ? displacement_of_closed(face, others)
                                               : obstacles_.body(other).displacement_at(p)[axis_[a]];
  };
  if (count <= 1) {
    const std::size_t solid = count == 1 ? all[0].solid : nearest_at(p, near).body;
    parts.push_back({at, a, solid, 1, middle, given_by(solid)});
    return;
  }
  const Real closed = 1 - this->face(a, at);
  const Real of_front = in_front == 0 ? 0 : behind == 0 ? 1 : std::min(in_front / closed, 1.0);
  const auto share = [&](const Part& part) {
    const Real front = in_front > 0 ? of_front * part.front / in_front : 0;
    return behind > 0 ? front + (1 - of_front) * part.behind / behind : front;
  };
  // The largest part is what the others leave, so that all of them together are the closed part of the face.
  std::size_t largest = 0;
  for (std::size_t n = 1; n < count; ++n)
    if (share(all[n]) > share(all[largest])) largest = n;
  Real rest = 1;
  Vec3 moment = middle;
  for (std::size_t n = 0; n < count; ++n) {
    const Real own = share(all[n]);
    if (n == largest || own < min_share) continue;
    parts.push_back({at, a, all[n].solid, own, all[n].middle, given_by(all[n].solid)});
    rest -= own;
    moment -= own * all[n].middle;
  }
  const Vec3 low = place(face.corner), high = place(face.corner + 2 * half);
  parts.push_back(
      {at, a, all[largest].solid, rest, (moment / rest).cwiseMax(low).cwiseMin(high), given_by(all[largest].solid)});
}

void CutCells::find_parts_of_cell(const Vec3& corner, std::size_t at, const Bodies& near,
                                  std::vector<PartOfCell>& parts) const {
  if (open(at) == 1) return;
  const Vec3 middle = place(corner + Vec3::Constant(0.5));
  const SolidsNear solids = solids_near(middle, size_.norm() / 2, near);
  if (solids.bodies.empty() || solids.bodies.size() + solids.others.size() < 2) return;
  const std::size_t first = parts.size();
  Real sum = 0;
  const auto measure = [&](const Bodies& of, std::size_t solid) {
    const Cell alone = filled_by(of, corner);
    const Real volume = 1 - alone.open;
    if (volume < min_share) return;
    parts.push_back({at, solid, volume, alone.solid_middle});
    sum += volume;
  };
  for (const std::size_t k : solids.bodies) measure({k}, k);
  if (!solids.others.empty()) measure(solids.others, nearest_at(middle, solids.others).body);
  for (std::size_t n = first; n < parts.size(); ++n) parts[n].volume *= (1 - open(at)) / sum;
}

CutCells::Cell CutCells::filled_by(const Bodies& solids, const Vec3& corner) const {
  Samples at;
  Cell alone;
  alone.nearest = static_cast<std::uint32_t>(obstacles_.floating()->first()) & Cell::max_nearest;  // as if they floated
  alone.open = static_cast<float>(open_at(corner, solids, at, alone));
  return alone;
}

// Area of the surface of one of several solids in a cell, in faces.
Real CutCells::area_of(std::size_t solid, std::size_t at) const {
  const auto closed = [&](std::size_t a, std::size_t face_at) {
    Real share = 0;
    for (const PartOfFace& part : parts_of_face(a, face_at)) share += part.solid == solid ? part.share : 0;
    return share * (1 - face(a, face_at));
  };
  Real sum = 0;
  for (std::size_t a = 0; a < 3; ++a) {
    const Real rise = closed(a, at + step_[a]) - closed(a, at);
    sum += rise * rise;
  }
  return std::sqrt(sum);
}

// The side of a face on which there is a solid cell, 1 or -1; 0 if neither or both of the cells are solid.
Real CutCells::side_of_solid(const AtFace& face) const {
  const bool below =
      ProjectionGrid::has_below(face.a, face.cell[0], face.cell[1]) && cells_[face.at - face.stride].open == 0;
  const bool above = cells_[face.at].open == 0;
  return below == above ? 0 : above ? 1 : -1;
}

// The face of a cell as some solids close it by themselves, measured slightly to one side of it, where their surface
// may lie on the face.
CutCells::Cell CutCells::closed_by(const Bodies& solids, std::size_t a, const Vec3& corner, Real side) const {
  constexpr Real off = 0.01;
  Candidates own;
  own.of_cell = solids;
  own.thick = are_thick(place(corner + Vec3::Constant(0.5)), own.of_cell);
  Cell alone;
  measure_face(a, corner + side * off * Vec3::Unit(static_cast<Eigen::Index>(a)), own, alone);
  return alone;
}

// The displacement of the closed part of a face, from that of each solid by what it closes. Where solids overlap, the
// part is that of those that move: what one of them moves through the faces of a cell then adds up to what its surface
// in the cell displaces. With the solid nearest to the centre of the face, a lid that slid over the walls of a cavity
// pumped water into the cells at one of its ends and out of those at the other.
Real CutCells::displacement_of_closed(const AtFace& face, const Bodies& near) const {
  const std::size_t a = face.a;
  const Vec3 p = place(face.corner + Vec3::Constant(0.5) - Vec3::Unit(static_cast<Eigen::Index>(a)) / 2);
  const auto displacement = [&](std::size_t k) { return obstacles_.body(k).displacement_at(p)[axis_[a]]; };
  constexpr Real rounding = 1e-12;  // cells, for solids that move as one
  const std::size_t nearest = nearest_at(p, near).body;
  if (near.size() == 1) return displacement(nearest);
  const Vec3 inside = in_box(p);
  Bodies at_face;
  bool alike = true;
  for (const std::size_t k : near) {
    if (distance_to(obstacles_.body(k), inside) > 0.75 * size_.maxCoeff()) continue;
    at_face.push_back(k);
    alike = alike && std::abs(displacement(k) - displacement(nearest)) <= rounding * size_.maxCoeff();
  }
  if (alike) return displacement(nearest);
  const Real side = side_of_solid(face);
  Real sum = 0, moving = 0, still = 0;
  for (const std::size_t k : at_face) {
    const Real closed = 1 - closed_by({k}, a, face.corner, side).face[a];
    (obstacles_.body(k).moves() ? moving : still) += closed;
    sum += closed * displacement(k);
  }
  return moving == 0 ? 0 : sum / std::max(moving, std::min(moving + still, 1 - this->face(a, face.at)));
}

}  // namespace trevi
