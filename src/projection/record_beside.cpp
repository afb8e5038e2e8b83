#include "projection/record_beside.hpp"

#include <algorithm>
#include <vector>

namespace trevi {

// The displacement by the faces, less the part that bears the weight; without damping, which acts between water and
// water.
TotalImpulse RecordBeside::of_particles(const CellDisplacement& by, const Motion& motion, const CellParticles& cell,
                                        bool across) const {
  static thread_local std::vector<Vec4<double>> displaced;
  displaced.resize(cell.end - cell.begin);
  displace_cell(from_.frame, motion, cell, by, displaced.data());
  TotalImpulse sum;
  for (std::size_t i = cell.begin; i < cell.end; ++i) {
    Vec3 shift = vector_of(displaced[i - cell.begin]);
    shift.z() = across ? 0 : shift.z() - g_dt2_;
    sum += obstacles_.about_middle(shift, motion.x[i]);
  }
  return sum;
}

// The same for a full cell, that is, for water that fills the open part of the cell up to the surface and moves as at
// the centroid of the open part; without what pulling back adds. With the particles that happened to be there, a light
// body was thrown about, and one with the density of water lagged behind sloshing water.
Vec3 RecordBeside::of_full(const CellDisplacement& by, LocalId k, LocalId r, LocalId c, bool across) const {
  const FreeSurface& surface = from_.surface;
  const ProjectionGrid& grid = surface.grid();
  const CutCells& cuts = *surface.cuts();
  const std::size_t here = grid.index(k, r, c);
  const Real open = cuts.open(here);
  if (open == 0) return Vec3::Zero();
  const Vec3 to_solid = cuts.middle_of_solid({k, r, c}, here) - cuts.middle(k, r, c);
  Vec3 shift;
  for (std::size_t a = 0; a < 3; ++a) {
    const std::size_t b = grid.axis(a);
    const auto axis = static_cast<Eigen::Index>(b);
    const Real off = -to_solid[axis] / grid.size()[static_cast<Eigen::Index>(a)] * (1 - open) / open;
    shift[axis] = by.low[b] + by.rise[b] * (0.5 + std::clamp(off, -0.5, 0.5));
  }
  shift.z() = across ? 0 : shift.z() - g_dt2_;
  return surface.filled_height(here) * open * grid.size().prod() / (spacing_ * spacing_ * spacing_) * shift;
}

// Centroid of the open part of the face, m.
Vec3 RecordBeside::middle_of(const CellFace& face, LocalId k, LocalId r, LocalId c) const {
  const auto [a, upper] = face;
  const ProjectionGrid& grid = from_.surface.grid();
  const CutCells& cuts = *from_.surface.cuts();
  const ByAxis middle = cuts.middle_of_face(a, grid.index_of(face, grid.index(k, r, c)));
  Vec3 place = cuts.middle(k, r, c);
  for (std::size_t b = 0; b < 3; ++b) {
    const auto axis = static_cast<Eigen::Index>(grid.axis(b));
    const Real off = b == a ? (upper ? 0.5 : -0.5) : middle[grid.axis(b)] - 0.5;
    place[axis] += off * grid.size()[static_cast<Eigen::Index>(b)];
  }
  return place;
}

// The excess of the pressure on the open part of a face over the cell's own pressure, whose contributions on open and
// closed parts add up to zero, except for the weight of the water in the cell. The pressure at the face is the mean of
// the cells on both sides.
Real RecordBeside::beyond_own(const CellFace& face, LocalId k, LocalId r, LocalId c) const {
  const auto [a, upper] = face;
  const FreeSurface& surface = from_.surface;
  const ProjectionGrid& grid = surface.grid();
  if (grid.is_wall(face, k, r, c)) return 0;
  const std::size_t here = grid.index(k, r, c), at = grid.index_of(face, here);
  const std::size_t beyond = upper ? at : here - grid.step(a);
  if (a < 2) return (from_.forces.on_side(beyond) - from_.forces.on_side(here)) / 2;
  const Real beside = from_.pressure.phi_so_far(beyond) - from_.pressure.phi_so_far(here);
  return (beside - (upper ? g_dt2_ : -g_dt2_) * grid.size()[2]) / 2;
}

// Where the surface lies in the cell or below it, horizontally only.
TotalImpulse RecordBeside::of_pressure(LocalId k, LocalId r, LocalId c, bool across) const {
  const ProjectionGrid& grid = from_.surface.grid();
  const std::size_t here = grid.index(k, r, c);
  const Real particles = grid.size().prod() / (spacing_ * spacing_ * spacing_);
  TotalImpulse sum;
  for (std::size_t a = 0; a < (across ? 2 : 3); ++a) {
    if (a == 1 && grid.is_layer()) continue;
    for (const bool upper : {false, true}) {
      const CellFace face{a, upper};
      const Real open = from_.surface.face(a, grid.index_of(face, here));
      if (open == 0) continue;
      const Real push = beyond_own(face, k, r, c) * open * particles / grid.size()[static_cast<Eigen::Index>(a)];
      const Vec3 normal = Vec3::Unit(static_cast<Eigen::Index>(grid.axis(a)));
      sum += obstacles_.about_middle((upper ? push : -push) * normal, middle_of(face, k, r, c));
    }
  }
  return sum;
}

void RecordBeside::of_row(LocalId k, LocalId r, const CellOrder& order, const Motion& motion) const {
  const CutCells& cuts = *from_.surface.cuts();
  const Range cut = cuts.cut_columns(k, r);
  for (LocalId c = cut.begin; c < cut.end; ++c) {
    const std::size_t here = from_.surface.grid().index(k, r, c);
    const TotalImpulse given =
        cuts.floats(here) ? TotalImpulse{of_body(k, r, c, order), Vec3::Zero()} : of_obstacle(k, r, c, order, motion);
    if (!given.shift.isZero(0) || !given.moment.isZero(0)) obstacles_.take_from_rest(cuts.nearest(here), given);
  }
}

// Whether water more than a cell deep stands above the body that cuts the cell.
bool RecordBeside::is_under_water(LocalId k, LocalId r, LocalId c) const {
  const FreeSurface& surface = from_.surface;
  if (!surface.upright()) return true;
  const std::size_t floor = surface.grid().index(k, r, 0);
  for (LocalId n = c + 1; n < surface.grid().columns(k, r); ++n) {
    const std::size_t at = floor + static_cast<std::size_t>(n);
    if (!surface.is_solid(at) && !surface.is_cut(at)) return surface.is_wet(at) && !surface.is_top(at);
  }
  return false;
}

CellParticles RecordBeside::particles_of(LocalId k, LocalId r, LocalId c, const CellOrder& order) const {
  const LocalId row = r * order.grid().columns(), ghosts = order.low_ghosts();
  return {static_cast<std::size_t>(order.start(k, row + c) - ghosts),
          static_cast<std::size_t>(order.start(k, row + c + 1) - ghosts), from_.surface.grid().place_of(k, r, c)};
}

// Whether there is a closed face and the cell's particles are displaced.
bool RecordBeside::gives(std::size_t here) const {
  return from_.surface.cuts()->closes_any(from_.surface.grid(), here) && from_.transfer.displaces(here);
}

bool RecordBeside::is_at_surface(std::size_t here) const {
  return from_.surface.upright() && (!from_.surface.is_wet(here) || from_.surface.is_top(here));
}

// Includes cells without particles: the pressure on the solid in them moves no particles.
TotalImpulse RecordBeside::of_obstacle(LocalId k, LocalId r, LocalId c, const CellOrder& order,
                                       const Motion& motion) const {
  const std::size_t here = from_.surface.grid().index(k, r, c);
  if (!gives(here)) return {};
  const CellParticles cell = particles_of(k, r, c, order);
  const bool across = is_at_surface(here);
  TotalImpulse given;
  if (cell.begin < cell.end)
    given = of_particles(from_.transfer.displacement_by_faces(from_.pressure, k, r, c), motion, cell, across);
  given -= of_pressure(k, r, c, across);
  return given;
}

// Vertically only under water: a body that heaves at the surface would otherwise swing ever higher. A cell without
// particles has no water, whatever its pressure.
Vec3 RecordBeside::of_body(LocalId k, LocalId r, LocalId c, const CellOrder& order) const {
  const std::size_t here = from_.surface.grid().index(k, r, c);
  if (!gives(here)) return Vec3::Zero();
  const CellParticles cell = particles_of(k, r, c, order);
  const bool across = is_at_surface(here) || !is_under_water(k, r, c);
  Vec3 given = Vec3::Zero();
  if (cell.begin < cell.end) given = of_full(from_.transfer.between_faces(from_.pressure, k, r, c), k, r, c, across);
  return given - of_pressure(k, r, c, across).shift;
}

}  // namespace trevi
