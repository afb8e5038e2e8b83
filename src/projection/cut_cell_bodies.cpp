// The part of solids in the cells: the effect of the pressure of a cell on the solid in it, and the volume and centroid
// of a freely moving body, which the samples of a round surface would otherwise not reproduce exactly.
#include <algorithm>
#include <cmath>

#include "parallel/reductions.hpp"
#include "projection/cut_cells.hpp"

namespace trevi {

Real CutCells::area(std::size_t at) const {
  Real sum = 0;
  for (std::size_t a = 0; a < 3; ++a) {
    const Real rise = face(a, at + step_[a]) - face(a, at);
    sum += rise * rise;
  }
  return std::sqrt(sum);
}

const CutCells::BodyFace* CutCells::body_face(std::size_t a, std::size_t at) const {
  const std::size_t first = cells_[at].body_faces;
  if (first == 0) return nullptr;
  for (std::size_t n = first - 1; n < body_faces_.size() && body_faces_[n].at == at; ++n)
    if (body_faces_[n].a == a) return &body_faces_[n];
  return nullptr;
}

// The part of the face (a, at), with a share of 0 if no floating body closes any of it. Where another solid closes some
// of it, too, the part that the body closes by itself is measured: when the body was given all of it, a body half a
// spacing above a slab was pressed onto the slab by the weight of the water around it.
CutCells::BodyFace CutCells::body_face_beside(std::size_t a, const std::array<LocalId, 3>& cell, const Vec3& corner,
                                              std::size_t at, const Bodies& near, std::size_t stride) const {
  const RigidBodies& floating = *obstacles_.floating();
  const Vec3 along = Vec3::Unit(static_cast<Eigen::Index>(a)), half = Vec3::Constant(0.5) - along / 2;
  const Vec3 p = place(corner + half), inside = in_box(p);
  Bodies others;
  Nearest nearest{INFINITY, 0};
  for (const std::size_t k : near) {
    const Real d = distance_to(obstacles_.body(k), inside);
    if (d > 1.5 * size_.maxCoeff()) continue;
    if (!floating.holds(k)) {
      others.push_back(k);
    } else if (d < nearest.distance) {
      nearest = {d, k};
    }
  }
  if (nearest.distance == INFINITY) return {at, a, 0, p, 0, 0};
  std::erase_if(others, [&](std::size_t k) { return !closes(k, a, corner); });
  if (others.empty()) return {at, a, nearest.body, middle_of_closed(a, cell, at), 1, 0};
  // Towards the body or away from any other solid there, on whose surface the body may lie.
  const bool has_below = ProjectionGrid::has_below(a, cell[0], cell[1]);
  Real side = 0;
  for (const Real below : {1, -1}) {
    if (below > 0 && !has_below) continue;
    if (cells_[below > 0 ? at - stride : at].open > 0) continue;
    const Vec3 middle = place(corner + half - below / 2 * along);
    side = floating.holds(nearest_at(middle, near).body) ? -below : below;
  }
  const Cell alone = closed_by(nearest.body, a, corner, side);
  const Real share = std::min((1 - alone.face[a]) / (1 - face(a, at)), 1.0);
  if (!(share > 0)) return {at, a, 0, p, 0, 0};
  const Body& other = obstacles_.body(nearest_at(p, others).body);
  const Vec3 path = other.displacement_at(p);
  return {at, a, nearest.body, middle_of_closed(a, cell, alone), share, (1 - share) * path[axis_[a]]};
}

// The side of a face on which there is a solid cell, 1 or -1; 0 if neither or both of the cells are solid.
Real CutCells::side_of_solid(std::size_t a, const std::array<LocalId, 3>& cell, std::size_t at,
                             std::size_t stride) const {
  const bool below = ProjectionGrid::has_below(a, cell[0], cell[1]) && cells_[at - stride].open == 0;
  const bool above = cells_[at].open == 0;
  return below == above ? 0 : above ? 1 : -1;
}

// The face of a cell as a solid closes it by itself, measured slightly to one side of it, where its surface may lie on
// the face.
CutCells::Cell CutCells::closed_by(std::size_t body, std::size_t a, const Vec3& corner, Real side) const {
  constexpr Real off = 0.01;
  Candidates own;
  own.of_cell = {body};
  own.thick = are_thick(place(corner + Vec3::Constant(0.5)), own.of_cell);
  Cell alone;
  measure_face(a, corner + side * off * Vec3::Unit(static_cast<Eigen::Index>(a)), own, alone);
  return alone;
}

// Whether a solid by itself closes any of a face, or of what is next to it on either side, where its surface may lie on
// the face.
bool CutCells::closes(std::size_t body, std::size_t a, const Vec3& corner) const {
  return closed_by(body, a, corner, 1).face[a] < 1 || closed_by(body, a, corner, -1).face[a] < 1;
}

// The displacement of the closed part of a face, from that of each solid by what it closes. Where solids overlap, the
// part is that of those that move: what one of them moves through the faces of a cell then adds up to what its surface
// in the cell displaces. With the solid nearest to the centre of the face, a lid that slid over the walls of a cavity
// pumped water into the cells at one of its ends and out of those at the other.
Real CutCells::displacement_of_closed(std::size_t a, const std::array<LocalId, 3>& cell, const Vec3& corner,
                                      std::size_t at, const Bodies& near, std::size_t stride) const {
  const Vec3 p = place(corner + Vec3::Constant(0.5) - Vec3::Unit(static_cast<Eigen::Index>(a)) / 2);
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
  const Real side = side_of_solid(a, cell, at, stride);
  Real sum = 0, moving = 0, still = 0;
  for (const std::size_t k : at_face) {
    const Real closed = 1 - closed_by(k, a, corner, side).face[a];
    (obstacles_.body(k).moves() ? moving : still) += closed;
    sum += closed * displacement(k);
  }
  return moving == 0 ? 0 : sum / std::max(moving, std::min(moving + still, 1 - face(a, at)));
}

bool CutCells::is_pushed(std::size_t at) const {
  if (floats(at)) return true;
  for (std::size_t a = 0; a < 3 && any_floats(); ++a)
    if (body_face(a, at) != nullptr || body_face(a, at + step_[a]) != nullptr) return true;
  return false;
}

namespace {

// For each body: volume, area, volume in cells that contain water, and the moments of the first two about its centre.
constexpr std::size_t sums_of_body = 9;
constexpr Real fine = 1U << 30U;

}  // namespace

// Sums in integers, in cells, so the result does not depend on the order.
std::vector<GlobalId> CutCells::sums_of_bodies(MPI_Comm comm, const ProjectionGrid& grid) const {
  const RigidBodies& bodies = *obstacles_.floating();
  PerThread<std::vector<GlobalId>> sums;
  sums.for_each([&](auto& of) { of.assign(sums_of_body * bodies.count(), 0); });
  for_each_row(grid.rows_of({1, grid.planes() + 1}), [&](LocalId k, LocalId r) {
    const Range cut = cut_columns(k, r);
    for (LocalId c = cut.begin; c < cut.end; ++c) {
      const std::size_t at = grid.index(k, r, c), nearest = cells_[at].nearest;
      if (open(at) == 1 || !bodies.holds(nearest)) continue;
      const std::size_t body = nearest - bodies.first();
      const Vec3 arm = (middle_of_solid({k, r, c}, at) - bodies.body(body).midway_position()) / size_.maxCoeff();
      const Real volume = 1 - open(at), surface = area(at);
      GlobalId* sum = &sums.mine()[sums_of_body * body];
      for (const Real one : {volume, surface, open(at) > 0 ? volume : 0, volume * arm.x(), volume * arm.y(),
                             volume * arm.z(), surface * arm.x(), surface * arm.y(), surface * arm.z()})
        *sum++ += std::llrint(one * fine);
    }
  });
  return sum_over_threads_and_ranks(comm, sums);
}

void CutCells::measure_excess(MPI_Comm comm, const ProjectionGrid& grid) {
  const RigidBodies& bodies = *obstacles_.floating();
  excess_.assign(obstacles_.count(), {});
  const std::vector<GlobalId> all = sums_of_bodies(comm, grid);
  const Real cell = size_.prod(), ceiling = box_.min.z() + grid.columns() * size_[2];
  for (std::size_t k = 0; k < bodies.count(); ++k) {
    const Box place = obstacles_.body(bodies.first() + k).surface_box();
    std::array<Real, sums_of_body> sum{};
    for (std::size_t n = 0; n < sums_of_body; ++n) sum[n] = static_cast<Real>(all[sums_of_body * k + n]) / fine;
    if (!box_.contains(place.min) || !box_.contains(place.max) || place.max.z() > ceiling || !(sum[1] > 0)) continue;
    Excess& excess = excess_[bodies.first() + k];
    excess.volume = (sum[0] - bodies.body(k).volume() / cell) / sum[1];
    const Vec3 moment = Vec3(sum[3], sum[4], sum[5]) - excess.volume * Vec3(sum[6], sum[7], sum[8]);
    const Real cut = sum[2] - excess.volume * sum[1];
    // Not where next to none of the body is in cells with water, as on the faces of cells beside another body.
    if (cut > 0 && moment.norm() < cut / 2) excess.middle = moment * size_.maxCoeff() / cut;
  }
}

// In a gap of up to a fifth of a cell the inner cells are dry, and those around them have a part of the pressure only:
// a wide body that rose by a hair fell back.
void CutCells::find_gaps(const ProjectionGrid& grid) {
  constexpr Real thin = 0.2;
  PerThread<std::vector<std::size_t>> found;
  for_each_row(grid.rows_of({1, grid.planes() + 1}), [&](LocalId k, LocalId r) {
    const Range cut = cut_columns(k, r);
    for (LocalId c = cut.begin; c < std::min(cut.end, grid.columns()); ++c) {
      const std::size_t at = grid.index(k, r, c);
      if (open(at) == 0 || open(at) >= thin) continue;
      const auto touches = [&](bool upper) {  // the body at this face something beyond the other one
        const BodyFace* const own = body_face(2, upper ? at + 1 : at);
        if (own == nullptr || grid.is_wall({2, !upper}, k, r, c)) return own != nullptr;
        const std::size_t beyond = upper ? at - 1 : at + 1;
        return cells_[beyond].open == 0 && nearest(beyond) != own->body;
      };
      if (touches(false) || touches(true)) found.mine().push_back(at);
    }
  });
  gaps_.clear();
  found.for_each([&](const auto& some) { gaps_.insert(gaps_.end(), some.begin(), some.end()); });
  std::sort(gaps_.begin(), gaps_.end());
}

CutCells::Pushes CutCells::pushes(const std::array<LocalId, 3>& cell, std::size_t at,
                                  const CellPressure& pressure) const {
  Pushes pushes;
  const Real level = middle(cell[0], cell[1], cell[2]).z();
  for_each_closed(cell, at, [&](std::size_t body, std::size_t a, bool upper, Real closed, const Vec3& arm) {
    const Real push = (pressure.phi + pressure.fall * (arm.z() - level)) / size_[static_cast<Eigen::Index>(a)] * closed;
    pushes.add(body, (upper ? push : -push) * Vec3::Unit(axis_[a]), arm);
  });
  if (pushes.count > 0 && !(is_gap(at) && floats(at)))
    pushes.add(nearest(at), -pressure.fall * solid(at) * Vec3::UnitZ(), middle_of_solid(cell, at));
  return pushes;
}

namespace {

// The integral from 0 to `height` of a quadratic function with the values q0 at 0, q1 at 1 and `mean` on average
// between them.
Real integral(Real q0, Real q1, Real mean, Real height) {
  return height * (q0 + height * ((3 * mean - 2 * q0 - q1) + height * (q0 + q1 - 2 * mean)));
}

// The part below a given height of the closed part of a side face, and its first moment. Its width is linear in height,
// as determined by its area and centroid. Where the centroid is less than a third of the height from an end, the width
// grows from zero, or falls to zero, within the face: a body that comes down from above closes only the upper end.
struct Strip {
  Real area, moment;
  Strip(Real closed, Real middle, Real height) {
    const bool upper = middle > 0.5;
    const Real from_end = std::clamp(upper ? 1 - middle : middle, 0.0, 0.5);
    const Real length = std::min(3 * from_end, 1.0);  // over which it has width
    if (!(length > 0)) {
      area = upper && height < 1 ? 0 : closed;
      moment = upper ? area : 0;
      return;
    }
    // From the end where it is widest, in units of length: w(t) = wide (1 − fall t).
    const Real fall = length < 1 ? 1 : 6 * (1 - 2 * from_end) / (4 - 6 * from_end), wide = closed / (1 - fall / 2);
    const auto below = [=](Real t) {
      return std::pair(wide * t * (1 - fall * t / 2), wide * t * t * (0.5 - fall * t / 3));
    };
    if (upper) {
      const auto [rest, rest_moment] = below(std::clamp((1 - height) / length, 0.0, 1.0));
      const auto [all, all_moment] = below(1);
      area = all - rest;
      moment = area - length * (all_moment - rest_moment);
    } else {
      const auto [all, all_moment] = below(std::min(height / length, 1.0));
      area = all;
      moment = length * all_moment;
    }
  }
};

}  // namespace

CutCells::Pushes CutCells::pushes_below(const std::array<LocalId, 3>& cell, std::size_t at, Real height,
                                        const CellPressure& pressure) const {
  Pushes pushes;
  const Vec3 corner = place(Vec3(cell[0], cell[1], cell[2]));
  const Real floor = corner.z(), fall = pressure.fall * size_[2];
  Vec3 low = Vec3::Zero(), high = Vec3::Zero();  // closed areas of the lower and upper face times their centroids
  Real low_area = 0, high_area = 0;
  for_each_closed(cell, at, [&](std::size_t body, std::size_t a, bool upper, Real closed, const Vec3& arm) {
    const Vec3 out = (upper ? 1 : -1) / size_[static_cast<Eigen::Index>(a)] * Vec3::Unit(axis_[a]);
    if (pressure.phi != 0) pushes.add(body, (a < 2 ? height : 1) * pressure.phi * closed * out, arm);
    if (a == 2) {
      if (body == nearest(at) || floats(at)) {
        (upper ? high : low) += closed * (arm - corner);
        (upper ? high_area : low_area) += closed;
      }
      if (!upper) pushes.add(body, -fall * height * closed * out, arm);
      return;
    }
    const Strip wet(closed, (arm.z() - floor) / size_[2], height);
    if (!(wet.area > 0)) return;
    const Vec3 middle(arm.x(), arm.y(), floor + size_[2] * wet.moment / wet.area);
    pushes.add(body, fall * (wet.moment - height * wet.area) * out, middle);
  });
  const Real all = solid(at), volume = integral(low_area, high_area, all, height);
  if (pushes.count == 0 || volume == 0 || (is_gap(at) && floats(at))) return pushes;
  const Vec3 moment = all * (middle_of_solid(cell, at) - corner);
  Vec3 middle = corner;
  for (const Eigen::Index i : {0, 1}) middle[i] += integral(low[i], high[i], moment[i], height) / volume;
  pushes.add(nearest(at), -pressure.fall * volume * Vec3::UnitZ(), middle);
  return pushes;
}

}  // namespace trevi
