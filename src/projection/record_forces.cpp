#include "projection/record_forces.hpp"

#include <algorithm>
#include <array>
#include <cmath>

namespace trevi {

template <class T>
void RecordForces::of_row(LocalId k, LocalId r, std::span<const Vec4<T>> moved, std::span<const Vec3> from) const {
  TotalImpulse all;
  for (std::size_t i = 0; i < moved.size(); ++i) all += obstacles_.about_middle(vector_of(moved[i]), from[i]);
  TotalImpulse on_walls;
  const ProjectionGrid& grid = surface_.grid();
  const bool beside_wall = grid.is_wall(0, k, r, 1) || grid.is_wall(0, k + 1, r, 1) || grid.is_wall(1, k, r, 1) ||
                           grid.is_wall(1, k, r + 1, 1);
  for (LocalId c = 0; c < grid.columns(k, r); ++c) {
    if (beside_wall || grid.is_wall(2, k, r, c) || grid.is_wall(2, k, r, c + 1)) on_walls += of_walls(k, r, c);
  }
  obstacles_.record_walls(on_walls);
  all -= on_walls;
  const Range cut = surface_.cuts()->cut_columns(k, r);
  for (LocalId c = cut.begin; c < cut.end; ++c) all -= of_cell(k, r, c);
  obstacles_.record_rest(all);
}

// The pressure of a cell, and of the water in the cell above it, on the walls of the box that they touch, acting at the
// centres of both; in total, about the centre of the box.
TotalImpulse RecordForces::of_walls(LocalId k, LocalId r, LocalId c) const {
  const ProjectionGrid& grid = surface_.grid();
  const std::size_t at = grid.index(k, r, c);
  if (!surface_.is_wet(at) || surface_.is_solid(at)) return {};
  const Real particles = grid.size().prod() / (spacing_ * spacing_ * spacing_);
  const Real over_top = surface_.is_top(at) ? on_side(at + 1) : 0;
  std::array<Vec3, 2> shifts{Vec3::Zero(), Vec3::Zero()};
  for (std::size_t a = 0; a < 3; ++a) {
    if (a == 1 && grid.is_layer()) continue;  // no pressure acts along y
    const Real size = grid.size()[static_cast<Eigen::Index>(a)], half = a == 2 ? g_dt2_ * size / 2 : 0;
    const std::array<LocalId, 3> above{k + (a == 0 ? 1 : 0), r + (a == 1 ? 1 : 0), c + (a == 2 ? 1 : 0)};
    const auto b = static_cast<Eigen::Index>(grid.axis(a));
    const CutCells& solids = *surface_.cuts();
    const Real phi = a < 2 ? on_side(at) : pressure_.phi(at), over = a < 2 ? over_top : 0;
    const auto push = [&](std::size_t face, Real sign) {
      shifts[0][b] += sign * (phi + sign * half) * solids.face(a, face) * particles / size;
      if (over != 0) shifts[1][b] += sign * over * solids.face(a, face + 1) * particles / size;
    };
    if (grid.is_wall(a, k, r, c)) push(at, -1);
    if (grid.is_wall(a, above[0], above[1], above[2])) push(at + grid.step(a), 1);
  }
  TotalImpulse sum;
  for (std::size_t n = 0; n < shifts.size(); ++n) {
    if (!shifts[n].isZero())
      sum += obstacles_.about_middle(shifts[n], surface_.cuts()->middle(k, r, c + static_cast<LocalId>(n)));
  }
  return sum;
}

// The rate at which the pressure grows downwards, m: as in water at rest, but beside a solid that does not float as
// given by the pressure of the top cell, because falling water has none.
Real RecordForces::fall_at(std::size_t top) const {
  if (surface_.cuts()->floats(top)) return g_dt2_;
  return std::clamp(-pressure_.phi_so_far(top) / (surface_.grid().size()[2] * surface_.above_middle(top)), 0.0, g_dt2_);
}

// In a top cell the water reaches up to its surface, and above that, water may reach into the dry cell over it. It
// counts as far as the pressure there is that of water at rest, because falling water has none.
Real RecordForces::on_side(std::size_t at) const {
  if (surface_.is_solid(at)) return 0;
  if (surface_.is_wet(at)) {
    const Real phi = pressure_.phi_so_far(at), height = surface_.height(at);
    if (height >= 1) return phi;
    const Real fall = fall_at(at) * surface_.grid().size()[2];
    return height * (phi + fall * (surface_.above_middle(at) - height / 2));
  }
  const Real over = surface_.filled_height(at);
  if (over == 0) return 0;
  return -fall_at(at - 1) * surface_.grid().size()[2] * over * over / 2;
}

Real RecordForces::at_height(std::size_t at, Real height) const {
  const Real size = surface_.grid().size()[2];
  if (!surface_.is_wet(at)) {
    const Real over = surface_.filled_height(at);
    return over > 0 && over > height ? -fall_at(at - 1) * size * (over - height) : 0;
  }
  const Real fall = surface_.height(at) < 1 ? fall_at(at) : g_dt2_;
  return std::min(pressure_.phi_so_far(at) + fall * size * (height - 0.5), 0.0);
}

Pushes RecordForces::pushes_of_cell(LocalId k, LocalId r, LocalId c) const {
  Pushes pushes = shifts_of_cell(k, r, c);
  const Real particles = surface_.grid().size().prod() / (spacing_ * spacing_ * spacing_);
  for (std::size_t n = 0; n < pushes.count; ++n) pushes.all[n].shift *= particles;
  return pushes;
}

// The same for a mass of a single particle per cell.
Pushes RecordForces::shifts_of_cell(LocalId k, LocalId r, LocalId c) const {
  const ProjectionGrid& grid = surface_.grid();
  const std::size_t at = grid.index(k, r, c);
  if (surface_.is_solid(at)) return {};
  const CutCells& cuts = *surface_.cuts();
  if (surface_.is_wet(at)) {
    const Real phi = pressure_.phi_so_far(at), height = surface_.height(at);
    if (height >= 1) return cuts.pushes({k, r, c}, at, {phi, g_dt2_});
    const Real fall = fall_at(at), at_rest = -fall * grid.size()[2] * surface_.above_middle(at);
    return cuts.pushes_below({k, r, c}, at, height, {phi - at_rest, fall});
  }
  if (const Real over = surface_.filled_height(at); c > 0 && over > 0)
    return cuts.pushes_below({k, r, c}, at, over, {0, fall_at(at - 1)});
  return {};
}

// The pressure on the solids in a cell, which is recorded for these. Returns the sum, about the centre of the box.
TotalImpulse RecordForces::of_cell(LocalId k, LocalId r, LocalId c) const {
  const Pushes pushes = pushes_of_cell(k, r, c);
  TotalImpulse sum;
  for (std::size_t n = 0; n < pushes.count; ++n) {
    const auto& [shift, place] = pushes.all[n];
    obstacles_.record_projection(pushes.solid[n], shift, place);
    sum += obstacles_.about_middle(shift, place);
  }
  return sum;
}

// The pressure of the cell in front of the gauge, half a cell off its face.
void RecordForces::of_gauges(const Box& box) const {
  const ProjectionGrid& grid = surface_.grid();
  PressureGauges& gauges = obstacles_.gauges();
  for (std::size_t g = 0; g < gauges.count(); ++g) {
    const GaugeSettings& gauge = gauges.gauge(g);
    const Vec3 before =
        (gauge.center + 0.5 * grid.size().minCoeff() * gauge.normal).cwiseMax(box.min).cwiseMin(box.max);
    const LocalId k = grid.own_plane(grid.cell_of(before, 0)), r = grid.own_row(grid.cell_of(before, 1));
    if (k >= 1 && k <= grid.planes() && r >= 0 && r < grid.rows())
      gauges.add_phi(g, phi_at(k, r, grid.cells_to(gauge.center, 2)));
  }
}

// Interpolated linearly between the centres of the wet cells below and above that height, which is in cells from the
// floor. If only one of them is wet, the pressure is hydrostatic from its centre.
Real RecordForces::phi_at(LocalId k, LocalId r, Real height) const {
  const ProjectionGrid& grid = surface_.grid();
  const Real from_middle = height - 0.5;
  const auto below = static_cast<LocalId>(std::floor(from_middle));
  Real sum = 0, weight = 0;
  for (LocalId c = std::max(below, 0); c <= below + 1 && c < grid.columns(k, r); ++c) {
    const std::size_t at = grid.index(k, r, c);
    if (!surface_.is_wet(at) || surface_.is_solid(at)) continue;
    const Real part = 1 - std::abs(from_middle - c);
    sum += part * (pressure_.phi(at) - g_dt2_ * grid.size()[2] * (c - from_middle));
    weight += part;
  }
  return weight > 0 ? std::min(sum / weight, 0.0) : 0;
}

template void RecordForces::of_row(LocalId, LocalId, std::span<const Vec4<float>>, std::span<const Vec3>) const;
template void RecordForces::of_row(LocalId, LocalId, std::span<const Vec4<double>>, std::span<const Vec3>) const;

}  // namespace trevi
