#include "projection/record_beside.hpp"

#include <algorithm>

#include "projection/parameters.hpp"

namespace trevi {

// By the faces, less their weight: as displace_cell() does without damping, which goes from water to water.
TotalImpulse RecordBeside::of_particles(const CellDisplacement& by, const Motion& motion, const CellParticles& cell,
                                        bool across) const {
  constexpr Real max_half = projection::max_half_path;
  TotalImpulse sum;
  for (std::size_t i = cell.begin; i < cell.end; ++i) {
    Vec3 shift(0, 0, -g_dt2_);
    for (std::size_t a = 0; a < 3; ++a) {
      const auto axis = static_cast<Eigen::Index>(a);
      const Real here = (motion.p[i][axis] - cell.place.origin[a]) * from_.frame.per_length[a] - cell.place.corner[a];
      const Real half = (motion.p[i][axis] - motion.x[i][axis]) * (0.5 * from_.frame.per_length[a]);
      shift[axis] += by.low[a] + by.rise[a] * (here - 2 * std::clamp(half, -max_half, max_half));
    }
    if (across) shift.z() = 0;
    sum += obstacles_.about_middle(shift, motion.x[i]);
  }
  return sum;
}

// Of its open part, m.
Vec3 RecordBeside::middle_of(const Face& face, LocalId k, LocalId r, LocalId c) const {
  const auto [a, upper] = face;
  const ProjectionGrid& grid = from_.surface.grid();
  const CutCells& cuts = *from_.surface.cuts();
  const ByAxis middle = cuts.middle_of_face(a, grid.index(k, r, c) + (upper ? grid.step(a) : 0));
  Vec3 place = cuts.middle(k, r, c);
  for (std::size_t b = 0; b < 3; ++b) {
    const auto axis = static_cast<Eigen::Index>(grid.axis(b));
    const Real off = b == a ? (upper ? 0.5 : -0.5) : middle[grid.axis(b)] - 0.5;
    place[axis] += off * grid.size()[static_cast<Eigen::Index>(b)];
  }
  return place;
}

// By how much the pressure on the open part of a face is above what the cell has by itself, which adds up to nothing
// with that on closed parts, but for the weight of its water: in the mean of the cells on both sides.
Real RecordBeside::beyond_own(const Face& face, LocalId k, LocalId r, LocalId c) const {
  const auto [a, upper] = face;
  const FreeSurface& surface = from_.surface;
  const ProjectionGrid& grid = surface.grid();
  if (grid.is_wall(a, k + (upper && a == 0), r + (upper && a == 1), c + (upper && a == 2))) return 0;
  const std::size_t here = grid.index(k, r, c), at = here + (upper ? grid.step(a) : 0);
  const std::size_t beyond = upper ? at : here - grid.step(a);
  if (a < 2) return (from_.forces.on_side(beyond) - from_.forces.on_side(here)) / 2;
  return (from_.pressure.phi(beyond) - from_.pressure.phi(here) - (upper ? g_dt2_ : -g_dt2_) * grid.size()[2]) / 2;
}

// Where the surface is in the cell, or below it, across alone.
TotalImpulse RecordBeside::of_pressure(LocalId k, LocalId r, LocalId c, bool across) const {
  const ProjectionGrid& grid = from_.surface.grid();
  const std::size_t here = grid.index(k, r, c);
  const Real particles = grid.size().prod() / (spacing_ * spacing_ * spacing_);
  TotalImpulse sum;
  for (std::size_t a = 0; a < (across ? 2 : 3); ++a) {
    if (a == 1 && grid.is_layer()) continue;
    for (const bool upper : {false, true}) {
      const Real open = from_.surface.face(a, here + (upper ? grid.step(a) : 0));
      if (open == 0) continue;
      const Face face{a, upper};
      const Real push = beyond_own(face, k, r, c) * open * particles / grid.size()[static_cast<Eigen::Index>(a)];
      const Vec3 normal = Vec3::Unit(static_cast<Eigen::Index>(grid.axis(a)));
      sum += obstacles_.about_middle((upper ? push : -push) * normal, middle_of(face, k, r, c));
    }
  }
  return sum;
}

void RecordBeside::of_row(LocalId k, LocalId r, const CellOrder& order, const Motion& motion) const {
  const ProjectionGrid& grid = from_.surface.grid();
  const Range cut = from_.surface.cuts()->cut_columns(k, r);
  const LocalId row = r * order.grid().columns(), ghosts = order.low_ghosts();
  CellParticles cell{0, 0, grid.place_of(k, r, 0)};
  for (LocalId c = cut.begin; c < cut.end; ++c) {
    cell.begin = static_cast<std::size_t>(order.start(k, row + c) - ghosts);
    cell.end = static_cast<std::size_t>(order.start(k, row + c + 1) - ghosts);
    grid.set_column(cell.place, c);
    of_cell(k, r, c, motion, cell);
  }
}

// Cells without particles, too: the pressure on the solid in them moves nobody.
void RecordBeside::of_cell(LocalId k, LocalId r, LocalId c, const Motion& motion, const CellParticles& cell) const {
  const FreeSurface& surface = from_.surface;
  const std::size_t here = surface.grid().index(k, r, c);
  if (!surface.cuts()->closes_any(surface.grid(), here) || surface.cuts()->floats(here)) return;
  if (!from_.transfer.displaces(here)) return;
  const bool across = surface.upright() && (!surface.is_wet(here) || surface.is_top(here));
  TotalImpulse given;
  if (cell.begin < cell.end)
    given = of_particles(from_.transfer.displacement_by_faces(from_.pressure, k, r, c), motion, cell, across);
  const TotalImpulse pressed = of_pressure(k, r, c, across);
  given += {-pressed.shift, -pressed.moment};
  obstacles_.take_from_rest(surface.cuts()->nearest(here), given);
}

}  // namespace trevi
