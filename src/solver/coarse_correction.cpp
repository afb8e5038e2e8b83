#include "solver/coarse_correction.hpp"

#include <algorithm>
#include <cmath>

#include "base/threads.hpp"

namespace trevi {

namespace {

// Time constants in units of sqrt(h/g), the time in which water falls by about h: in noise_time a particle's motion
// relaxes to that of its cell, in return_time a cell returns to its volume. Measured on pools of 5 to 20 layers at dt =
// 1/60 and 1/240 s: without this damping 8e-4 to 2e-3 m²/s² of kinetic energy per mass never decay; with noise_time =
// 3.5 it is 1e-4, and a wave 20 h long loses 1.3 % of its amplitude in half a period; with 1.75 it loses 3.5 %. What is
// in the dry cell above the surface's takes part: without it a pool whose top layer lies there simmered at 3e-3 m²/s²,
// at 1e-4 with it.
// A cell that a solid cuts has its displacements from fewer faces and particles; there the motion relaxes cut_noise
// times as fast, which halves that of water at rest in a vessel and costs a swing of it little.
constexpr Real noise_time = 3.5, return_time = 6, cut_noise = 3;
// In units of sqrt(g h): what moves faster than this relative to its cell is a jet rather than noise, and is damped the
// less the faster it moves. Without this bound a jet through a pool lost a sixth of its height.
constexpr Real noise_speed = 0.2;
// In spacings below the surface: the correction acts in full up to a quarter of a spacing above the surface, and fades
// out over the next two spacings above that.
constexpr Real fade_begins = -0.25, fade_length = 2;

}  // namespace

CoarseCorrection::CoarseCorrection(MPI_Comm comm, const CellGrid& grid, const Box& box, const Model& model,
                                   Obstacles* obstacles)
    : model_(model),
      water_(comm, grid, box, model.spacing, obstacles),
      pressure_(comm, water_.grid().repeats()),
      obstacles_(obstacles) {}

// What takes the particles along with a wall, or with a solid.
Real CoarseCorrection::through_closed(std::size_t a, std::size_t face) const {
  const CoarseSolids* solids = water_.solids();
  return (solids != nullptr ? solids->moved(a, face) : 0) - water_.displacement(a, face);
}

Real CoarseCorrection::noise_share(std::size_t at) const {
  return water_.is_cut(at) ? std::min(1.0, cut_noise * share_) : share_;
}

CellDisplacement CoarseCorrection::displacement_of(LocalId k, LocalId r, LocalId c) const {
  const CoarseGrid& grid = water_.grid();
  const std::size_t own = grid.index(k, r, c);
  const bool wet = water_.is_wet(own),
             follows = !wet && water_.is_wet(own - 1) && !water_.is_solid(own - 1);  // the top cell below it
  CellDisplacement by{};
  by.share = wet || follows ? noise_share(own) : 0;
  by.per_noise2 = per_noise2_;
  by.at_surface = 1;
  if (follows || water_.is_top(own)) {
    by.surface = follows ? c - 1 + water_.height(own - 1) : c + water_.height(own);
    by.at_surface = 1 - fade_begins / fade_length;
    by.fade = grid.size()[2] / (model_.spacing * fade_length);
  }
  for (std::size_t a = 0; a < 3; ++a) {
    const std::size_t at = follows && a < 2 ? own - 1 : own, above = at + grid.step(a), b = grid.axis(a);
    const auto through = [&](std::size_t face, bool wall, bool& known) {
      wall = is_closed(a, face, wall);
      known = wall ? water_.is_wet(at) : water_.is_wet(face) || water_.is_wet(face - grid.step(a));
      if (!known) return 0.0;
      return wall ? through_closed(a, face) : pressure_.displacement(water_, a, face);
    };
    bool low_known = false, high_known = false;
    Real low = through(at, grid.is_wall(a, k, r, c), low_known);
    Real high = through(above, grid.is_wall(a, k + (a == 0), r + (a == 1), c + (a == 2)), high_known);
    // A face between two dry cells has no phi on either side; it takes the displacement of the opposite face.
    if (!low_known) low = high;
    if (!high_known) high = low;
    by.low[b] = low;
    by.rise[b] = high - low;
    by.mean_low[b] = water_.displacement(a, at);
    by.mean_rise[b] = follows && a == 2 ? 0 : water_.displacement(a, above) - by.mean_low[b];
  }
  return by;
}

template <class T>
void CoarseCorrection::displacements(const CellOrder& order, Halo& halo, Real dt, const Motion& motion,
                                     std::span<Vec4<T>> out) {
  const ScopedEvent timed(event_);
  const Real time = dt / std::sqrt(model_.h / model_.gravity);
  const Real noise = noise_speed * time * model_.h;
  share_ = std::min(1.0, time / noise_time);
  per_noise2_ = 1 / (noise * noise);
  fall_ = model_.gravity * dt * dt;
  water_.measure(order, halo, motion);
  pressure_.solve(water_, halo, fall_, std::min(1.0, time / return_time));
  const LocalId rows = order.grid().rows(), all_columns = order.grid().columns();
  for_each_part(order.planes() * rows, [&](LocalId row) {
    const LocalId k = row / rows + 1, r = row % rows;
    const LocalId columns = water_.grid().columns(k, r);
    for (LocalId c = 0; c < columns; ++c) {
      const LocalId cell = r * all_columns + c;
      const auto begin = static_cast<std::size_t>(order.start(k, cell) - order.low_ghosts());
      const auto end = static_cast<std::size_t>(order.start(k, cell + 1) - order.low_ghosts());
      if (begin == end) continue;
      displace_cell(water_.frame(), motion, {begin, end, water_.grid().place_of(motion.p[begin])},
                    displacement_of(k, r, c), &out[begin]);
    }
    const LocalId flying = order.start(k, r * all_columns + columns), end = order.start(k, (r + 1) * all_columns);
    std::fill_n(out.begin() + (flying - order.low_ghosts()), end - flying, Vec4<T>{});
    if (obstacles_ == nullptr) return;
    const LocalId begin = order.start(k, r * all_columns);
    tell_of_row<T>(
        k, r, out.subspan(static_cast<std::size_t>(begin - order.low_ghosts()), static_cast<std::size_t>(end - begin)));
  });
  if (obstacles_ != nullptr) tell_gauges();
}

// Obstacles have what the pressure of the cells does to their surface, the box has the rest of what moves the particles
// of the row.
template <class T>
void CoarseCorrection::tell_of_row(LocalId k, LocalId r, std::span<const Vec4<T>> moved) {
  Vec3 sum = Vec3::Zero();
  for (const Vec4<T>& one : moved) sum += vector_of(one);
  obstacles_->take_of_grid(obstacles_->box_taker(), sum, Vec3::Zero());
  if (!water_.solids()->cuts_row(k, r)) return;
  for (LocalId c = 0; c < water_.grid().columns(); ++c) tell_of_cell(k, r, c);
}

// The solid's surface in a cell, as a vector out of the water, is what the areas of opposite faces differ by. The
// pressure is that at the surface's height.
void CoarseCorrection::tell_of_cell(LocalId k, LocalId r, LocalId c) {
  const CoarseGrid& grid = water_.grid();
  const CoarseSolids& solids = *water_.solids();
  const std::size_t at = grid.index(k, r, c);
  if (!water_.is_wet(at) || water_.is_solid(at)) return;
  const Real phi = pressure_.phi(at) + fall_ * solids.surface_above_middle(at);
  Vec3 shift = Vec3::Zero();
  for (std::size_t a = 0; a < 3; ++a) {
    const Real rise = solids.face(a, at + grid.step(a)) - solids.face(a, at);
    const Real particles = grid.size().prod() / (model_.spacing * model_.spacing * model_.spacing);
    shift[static_cast<Eigen::Index>(grid.axis(a))] =
        -phi * rise * particles / grid.size()[static_cast<Eigen::Index>(a)];
  }
  if (shift.isZero()) return;
  const std::size_t nearest = solids.nearest(at);
  obstacles_->take_of_grid(nearest, shift, solids.middle(k, r, c));
  obstacles_->take_of_grid(obstacles_->box_taker(), -shift, Vec3::Zero());
}

// In the cell before the face, half a cell off it.
void CoarseCorrection::tell_gauges() {
  const CoarseGrid& grid = water_.grid();
  PressureGauges& gauges = obstacles_->gauges();
  for (std::size_t g = 0; g < gauges.count(); ++g) {
    const GaugeSettings& gauge = gauges.gauge(g);
    const Vec3 before = (gauge.center + 0.5 * grid.size().minCoeff() * gauge.normal)
                            .cwiseMax(water_.box().min)
                            .cwiseMin(water_.box().max);
    const LocalId k = grid.cell_of(before, 0) - water_.solids()->first_plane() + 1;
    if (k >= 1 && k <= grid.planes())
      gauges.add_phi(g, phi_at(k, grid.cell_of(before, 1), grid.cells_to(gauge.center, 2)));
  }
}

// Linear between the middles of the cells of water below and above that height, which is in cells from the floor; where
// there is but one of them, hydrostatic from its middle.
Real CoarseCorrection::phi_at(LocalId k, LocalId r, Real height) const {
  const CoarseGrid& grid = water_.grid();
  const Real from_middle = height - 0.5;
  const auto below = static_cast<LocalId>(std::floor(from_middle));
  Real sum = 0, weight = 0;
  for (LocalId c = std::max(below, 0); c <= below + 1 && c < grid.columns(k, r); ++c) {
    const std::size_t at = grid.index(k, r, c);
    if (!water_.is_wet(at) || water_.is_solid(at)) continue;
    const Real part = 1 - std::abs(from_middle - c);
    sum += part * (pressure_.phi(at) - fall_ * grid.size()[2] * (c - from_middle));
    weight += part;
  }
  return weight > 0 ? std::min(sum / weight, 0.0) : 0;
}

template void CoarseCorrection::displacements(const CellOrder&, Halo&, Real, const Motion&, std::span<Vec4<float>>);
template void CoarseCorrection::displacements(const CellOrder&, Halo&, Real, const Motion&, std::span<Vec4<double>>);

}  // namespace trevi
