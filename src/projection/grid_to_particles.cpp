#include "projection/grid_to_particles.hpp"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <limits>

namespace trevi {

using namespace projection;

void pull_back(const AffineMap& motion, const ByAxis& per_length, Real held, CellDisplacement& by) {
  by.back = 0;
  for (std::size_t a = 0; a < 3; ++a) {
    for (std::size_t b = 0; b < 3; ++b) {
      const Real back = motion.b[b][a] * per_length[a] / 2;
      by.offset[a] += back * (b == 2 ? by.low[b] - held : by.low[b]);
      by.slope[a][b] += back * by.rise[b];
    }
  }
}

// The linear mean at a wall is an extrapolation where few particles represent the water. What exceeds the mean of the
// cell's own particles, or is opposite to it, is not their motion (README.md).
Real bounded(Real by_slope, Real by_mean) {
  if (by_mean * by_slope <= 0) return 0;
  return std::abs(by_mean) < std::abs(by_slope) ? by_mean : by_slope;
}

namespace {

constexpr Real unknown = std::numeric_limits<Real>::quiet_NaN();

AffineMap times(AffineMap map, Real factor) {
  map.weight *= factor;
  for (std::size_t i = 0; i < 3; ++i) {
    map.a[i] *= factor;
    for (Real& slope : map.b[i]) slope *= factor;
  }
  return map;
}

}  // namespace

// A dry cell directly above water under gravity: the few particles in it follow the top cell.
bool GridToParticles::follows(std::size_t at) const {
  return surface_.upright() && !surface_.is_wet(at) && surface_.is_wet(at - 1) && !surface_.is_solid(at - 1);
}

// The fraction of the noise of a cell that decays in this step. It is smaller where the motion is too fast to be noise.
// `rest2`: the mean square of the residual motion of the fit, m².
Real GridToParticles::rate(Real rest2) const {
  const Real noise = noise_speed * step_.time * h_;
  return std::min(step_.time / noise_time, 1.0) / (1 + rest2 / (noise * noise));
}

// The fraction of the residual motion of a cell's fit, `rest2`, m², that is noise: of a smooth motion, the residual is
// a small part of the square of the mean motion.
Real GridToParticles::part_of_noise(LocalId k, LocalId r, LocalId c, Real rest2) const {
  const Moments moments = surface_.water().moments(surface_.grid().index(k, r, c));
  const ByAxis& u = moments.flow.u;
  const Vec3 motion(u[0] / moments.at.n, u[1] / moments.at.n, u[2] / moments.at.n + step_.g_dt2);
  const Real smooth = smooth_rest * motion.squaredNorm();
  return smooth > 0 ? rest2 / (rest2 + smooth) : 1;
}

// Whether the surface is in the cell or in one of the next cells above it. Solid cells are wet unless it is beneath
// them.
bool GridToParticles::is_near_surface(std::size_t floor, LocalId c) const {
  const LocalId end = std::min(c + cut_noise_cells, surface_.grid().columns());
  for (LocalId above = c; above < end; ++above) {
    const std::size_t at = floor + static_cast<std::size_t>(above);
    if (!surface_.is_wet(at) || surface_.is_top(at)) return true;
  }
  return false;
}

void GridToParticles::prepare(Halo& halo, const Step& step) {
  step_ = step;
  closed_.find(surface_);
  if (!surface_.upright()) return;
  const ProjectionGrid& grid = surface_.grid();
  if (surface_.cuts() != nullptr) cut_fit_.borrow_briefly(grid.scratch(), grid.storage());
  noise_.borrow_briefly(grid.scratch(), grid.storage_rolling());
  const PlaneStage noise{[&](TentMemory& memory, LocalId k, LocalId r) { find_noise(memory, k, r); },
                         [&] { noise_.start(halo); }};
  const PlaneStage fits{[&](TentMemory& memory, LocalId k, LocalId r) { fit_noise(memory, k, r); },
                        [&] {
                          noise_fit_.start(halo);
                          if (surface_.cuts() != nullptr) cut_fit_.start(halo);
                        }};
  for_each_plane_in_turn<TentMemory>(grid, halo, noise, fits, [](Range) {});
  noise_.give_back();
}

void GridToParticles::find_noise(TentMemory& memory, LocalId k, LocalId r) {
  const ParticlesToGrid& water = surface_.water();
  const Range cells = water.filled(k, r);
  noise_.clear_around(k, r, cells);
  filter_motion(rows_around(surface_.grid(), water.fits(), {k, r, cells}, memory), water.all_moments().row(k, r),
                noise_.row(k, r));
}

void GridToParticles::fit_noise(TentMemory& memory, LocalId k, LocalId r) {
  const ProjectionGrid& grid = surface_.grid();
  const ParticlesToGrid& water = surface_.water();
  const Range cells = water.filled(k, r);
  const std::size_t floor = grid.index(k, r, 0);
  static thread_local std::vector<Real> rates;
  rates.assign(static_cast<std::size_t>(grid.columns()) + FourCells::count, 0.0);
  for (LocalId c = cells.begin; c < cells.end; ++c) {
    const std::size_t at = floor + static_cast<std::size_t>(c);
    if (water.all_moments().number(0, k, r, c) > 0 && (surface_.is_wet(at) || follows(at)))
      rates[static_cast<std::size_t>(c)] = rate(water.spreads().number(numbers::spread - 1, k, r, c));
  }
  if (surface_.cuts() != nullptr) fit_cut_cells(k, r, rates);
  noise_fit_.clear_around(k, r, cells);  // in the memory of the spreads
  fit_flow(rows_around(grid, noise_, {k, r, cells}, memory),
           {water.spreads().row(k, r), rates.data(), noise_fit_.row(k, r)});
}

void GridToParticles::fit_cut_cells(LocalId k, LocalId r, std::span<const Real> rates) {
  const ParticlesToGrid& water = surface_.water();
  const std::size_t floor = surface_.grid().index(k, r, 0);
  const Range cells = water.filled(k, r), cut = surface_.cuts()->cut_columns(k, r);
  cut_fit_.clear(k, r);
  for (LocalId c = std::max(cells.begin, cut.begin); c < std::min(cells.end, cut.end); ++c) {
    const std::size_t at = floor + static_cast<std::size_t>(c);
    const Real rate = rates[static_cast<std::size_t>(c)];
    if (rate == 0 || !surface_.is_cut(at)) continue;
    if (surface_.cuts()->moves_in_water(at) && !is_near_surface(floor, c)) continue;
    const Real rest2 = water.spreads().number(numbers::spread - 1, k, r, c);
    const Real noise = surface_.cuts()->floats(at) ? 1 : part_of_noise(k, r, c, rest2);
    cut_fit_.set(k, r, c, times(water.fits().cell<AffineMap>(k, r, c), std::min(cut_noise * noise * rate, 1.0)));
  }
}

void GridToParticles::find_damping(Damping& damping, LocalId k, LocalId r) const {
  if (!surface_.upright()) return;
  const ProjectionGrid& grid = surface_.grid();
  const ParticlesToGrid& water = surface_.water();
  const RowPlace row{k, r, water.filled(k, r)};
  auto& [of_noise, of_motion, of_cut] = damping.memories;
  damping.row.resize(noise_fit_.per_row());
  damp_noise(rows_around(grid, noise_fit_, row, of_noise), rows_around(grid, water.fits(), row, of_motion),
             damping.row.data());
  if (surface_.cuts() == nullptr) return;
  const Range near = surface_.cuts()->columns_near_cut(k, r);
  const Range cells{std::max(near.begin, row.cells.begin), std::min(near.end, row.cells.end)};
  if (cells.begin < cells.end) add_maps(rows_around(grid, cut_fit_, {k, r, cells}, of_cut), damping.row.data());
}

// The displacement of the solid that closes the face, plus that of water that flows through it.
Real GridToParticles::moved(std::size_t a, std::size_t face) const {
  const CutCells* cuts = surface_.cuts();
  const Openings* openings = surface_.openings();
  return (cuts != nullptr ? cuts->moved(a, face) : 0) + (openings != nullptr ? openings->displacement(a, face) : 0);
}

// The displacement that takes the particles of a cell along with a wall or a solid. They move towards it like the
// linear mean at its face.
Real GridToParticles::through_closed(const CellFace& face, LocalId k, LocalId r, LocalId c) const {
  const ProjectionGrid& grid = surface_.grid();
  const std::size_t at = grid.index(k, r, c);
  const Real wall = moved(face.a, grid.index_of(face, at)), by_wall = wall - closed_.displacement(face, k, r, c);
  const ParticlesToGrid::Means held = surface_.water().means(at);
  return held.n == 0 ? by_wall : bounded(by_wall, wall - held.u[grid.axis(face.a)] / held.n);
}

// Through what a moving solid leaves open of a face, water is no faster than the pressure can make it on its way, by
// Bernoulli's equation. Where the water's surface is near the face, its displacement in a whole step would be more: a
// box that fell beside a ball threw a particle at 13 m/s through a tenth of a face.
Real GridToParticles::through_open(const Pressure& pressure, std::size_t a, std::size_t face, std::size_t at) const {
  const Real displacement = pressure.displacement(surface_, a, face);
  const CutCells* cuts = surface_.cuts();
  if (cuts == nullptr || cuts->face(a, face) == 1 || !cuts->moves_in_water(at)) return displacement;
  const Real difference = std::abs(pressure.phi_so_far(face) - pressure.phi_so_far(face - surface_.grid().step(a)));
  const Real farthest = std::max(std::sqrt(2 * difference), step_.g_dt2);
  return std::clamp(displacement, -farthest, farthest);
}

GridToParticles::FacePair GridToParticles::faces_of(const Pressure& pressure, std::size_t a, LocalId k, LocalId r,
                                                    LocalId c) const {
  const ProjectionGrid& grid = surface_.grid();
  const std::size_t at = grid.index(k, r, c);
  FacePair pair;
  if (a == 1 && grid.is_layer()) return {0, 0, true, true, true, true};
  const CellFace lower{a, false}, upper{a, true};
  pair.low_closed = surface_.is_closed(lower, k, r, c);
  pair.high_closed = surface_.is_closed(upper, k, r, c);
  pair.low_wall = pair.low_closed && grid.is_wall(lower, k, r, c);
  pair.high_wall = pair.high_closed && grid.is_wall(upper, k, r, c);
  const bool wet = surface_.is_wet(at);
  const auto through = [&](const CellFace& of, bool closed, bool& known) {
    const std::size_t face = grid.index_of(of, at);
    known = closed ? wet : surface_.is_wet(face) || surface_.is_wet(face - grid.step(a));
    if (!known) return 0.0;
    return closed ? through_closed(of, k, r, c) : through_open(pressure, a, face, at);
  };
  bool low_known = false, high_known = false;
  pair.low = through(lower, pair.low_closed, low_known);
  pair.high = through(upper, pair.high_closed, high_known);
  // A face between two dry cells has no phi on either side; under gravity it takes the displacement of the opposite
  // face.
  if (surface_.upright() && !low_known) pair.low = pair.high;
  if (surface_.upright() && !high_known) pair.high = pair.low;
  return pair;
}

// Without gravity nothing is pulled back: vortices at Re 1000 and 20 across would then have 0.94 of the energy that
// they should have at three quarters instead of 0.97. The pressure of the weight already acts from where the paths
// begin (FreeSurface::half_rise()).
void GridToParticles::pull_back_beyond_weight(std::size_t cell, CellDisplacement& by) const {
  if (!surface_.upright() || !surface_.is_wet(cell)) return;
  const AffineMap motion = surface_.water().fit(cell);
  if (motion.weight == 0) return;
  const Real held = std::clamp(by.low[2] + by.rise[2] / 2, 0.0, step_.g_dt2);
  pull_back(motion, surface_.grid().per_length(), held, by);
}

// Whether phi is taken to be mirrored at a face: at a closed one of a cell that no solid cuts. What flows through it
// from an opening, and the motion of a solid, are left out.
bool GridToParticles::mirrors(const CellFace& face, LocalId k, LocalId r, LocalId c) const {
  return surface_.is_closed(face, k, r, c) && !surface_.is_cut(surface_.grid().index(k, r, c));
}

void GridToParticles::find_mean_rises(const Pressure& pressure) {
  const ProjectionGrid& grid = surface_.grid();
  mean_rise_ = grid.scratch().borrow_briefly<Real>(grid.cells());
  mean_rise_.fill(unknown);
  for_each_row(grid.rows_and_ghosts_of({0, grid.planes() + 2}), [&](LocalId k, LocalId r) {
    if (!grid.has_row(r)) return;
    for (LocalId c = 0; c < grid.columns(k, r); ++c) mean_rise_[grid.index(k, r, c)] = mean_rise(pressure, k, r, c);
  });
  grid.repeat(mean_rise_);
}

// For a cell in the water, the mean upward displacement at its lower and upper face. At a floor and a ceiling it is
// taken to be that of water at rest; a face that is closed by a solid which cuts the cell is left out.
Real GridToParticles::mean_rise(const Pressure& pressure, LocalId k, LocalId r, LocalId c) const {
  const std::size_t at = surface_.grid().index(k, r, c);
  if (!is_water(at)) return unknown;
  Real sum = 0;
  int faces = 0;
  for (const bool upper : {false, true}) {
    const bool closed = surface_.is_closed({2, upper}, k, r, c);
    if (closed && surface_.is_cut(at)) continue;
    sum += closed ? step_.g_dt2 : pressure.displacement(surface_, 2, upper ? at + 1 : at);
    ++faces;
  }
  return faces > 0 ? sum / faces : unknown;
}

// The change of the upward displacement from cell to cell along a, m.
Real GridToParticles::change_of_rise(std::size_t a, LocalId k, LocalId r, LocalId c) const {
  const ProjectionGrid& grid = surface_.grid();
  const std::size_t at = grid.index(k, r, c);
  assert(!mean_rise_.empty());
  const auto beyond = [&](bool upper) {
    const CellFace face{a, upper};
    if (mirrors(face, k, r, c)) return mean_rise_[at];
    if (grid.is_wall(face, k, r, c)) return unknown;
    return mean_rise_[upper ? at + grid.step(a) : at - grid.step(a)];
  };
  const Real low = beyond(false), high = beyond(true), own = mean_rise_[at];
  const bool low_known = !std::isnan(low), high_known = !std::isnan(high);
  if (low_known && high_known) return (high - low) / 2;
  if (std::isnan(own) || (!low_known && !high_known)) return 0;
  return low_known ? own - low : high - own;
}

// The mixed difference of phi along planes and rows, m², averaged over the edges of a cell around which all four cells
// are in the water; at the edges of mirrors it is zero.
Real GridToParticles::mixed_difference(const Pressure& pressure, LocalId k, LocalId r, LocalId c) const {
  const ProjectionGrid& grid = surface_.grid();
  const std::size_t at = grid.index(k, r, c), plane = grid.step(0), row = grid.step(1);
  Real sum = 0;
  int edges = 0;
  for (const bool upper_plane : {false, true}) {
    const std::size_t beside = upper_plane ? at + plane : at - plane;
    for (const bool upper_row : {false, true}) {
      const std::size_t next = upper_row ? at + row : at - row, across = upper_row ? beside + row : beside - row;
      const bool mirror = mirrors({0, upper_plane}, k, r, c) || mirrors({1, upper_row}, k, r, c);
      if (!mirror && !(is_water(beside) && is_water(next) && is_water(across))) continue;
      ++edges;
      if (mirror) continue;
      const Real change = pressure.phi_so_far(across) - pressure.phi_so_far(beside) - pressure.phi_so_far(next) +
                          pressure.phi_so_far(at);
      sum += upper_plane == upper_row ? change : -change;
    }
  }
  return edges > 0 ? sum / edges : 0;
}

// The mean path of the particles of a cell, in cells, by direction: cut off at the longest that counts, and zero if it
// is short or the particles are few.
std::array<Real, 3> GridToParticles::mean_path(std::size_t at) const {
  const ProjectionGrid& grid = surface_.grid();
  const ParticlesToGrid::Means held = surface_.water().means(at);
  std::array<Real, 3> path{};
  if (held.n * spacing_ * spacing_ * spacing_ < min_held_across * grid.size().prod()) return path;
  for (std::size_t a = 0; a < 3; ++a) path[a] = held.u[grid.axis(a)] / held.n * grid.per_length()[grid.axis(a)];
  const Real bound = surface_.upright() ? 2 * max_half_path : max_path;
  const Real longest = std::max({std::abs(path[0]), std::abs(path[1]), std::abs(path[2]), bound});
  const Real shortest = surface_.is_cut(at) ? min_path_across_cut : min_path_across;
  for (Real& along : path) along = std::abs(along) < shortest ? 0 : along * (bound / longest);
  return path;
}

// The displacement by the faces is linear only along its own direction. Across that direction it is the displacement of
// the cell that holds the ends of the paths, whereas it was found in the middle of the paths, or, without gravity, acts
// at their beginning. It is therefore moved back by half, or by all, of the mean path of the cell, using its changes
// across, which are mixed derivatives of phi. Without this the upward displacement was that of a point ahead of the
// level that causes it, and waves of 1 m on a current of 1 m/s grew or decayed by a tenth in a second at 1/120 s.
// Without the upward path, waves drive water forwards at the surface and backwards below it, by 0.04 m/s in 25 periods
// of waves of a height of 0.05 of their length at 1/60 s.
void GridToParticles::move_back_across(const Pressure& pressure, LocalId k, LocalId r, LocalId c,
                                       CellDisplacement& by) const {
  const ProjectionGrid& grid = surface_.grid();
  const std::size_t at = grid.index(k, r, c);
  if (!is_water(at)) return;
  std::array<Real, 3> path = mean_path(at);
  for (Real& along : path) along *= (1 + by.back) / 2;
  const Real bound = surface_.upright() ? max_change_across * step_.g_dt2 : std::numeric_limits<Real>::infinity();
  for (std::size_t a = 0; a < 2; ++a) {
    if ((path[a] == 0 && path[2] == 0) || (a == 1 && grid.is_layer())) continue;
    const Real change = std::clamp(change_of_rise(a, k, r, c), -bound, bound);
    by.offset[grid.axis(2)] -= path[a] * change;
    by.offset[grid.axis(a)] -= path[2] * change * grid.size()[2] / grid.size()[static_cast<Eigen::Index>(a)];
  }
  if ((path[0] == 0 && path[1] == 0) || grid.is_layer()) return;
  const Real change = mixed_difference(pressure, k, r, c);
  by.offset[grid.axis(0)] -= path[1] * change / grid.size()[0];
  by.offset[grid.axis(1)] -= path[0] * change / grid.size()[1];
}

CellDisplacement GridToParticles::between_faces(const Pressure& pressure, LocalId k, LocalId r, LocalId c) const {
  const ProjectionGrid& grid = surface_.grid();
  const std::size_t at = grid.index(k, r, c);
  const bool above = follows(at);
  CellDisplacement by;
  by.act = surface_.is_wet(at) || above ? 1 : 0;
  if (!displaces(at)) return by;
  Faces faces;
  for (std::size_t a = 0; a < 3; ++a) faces[a] = faces_of(pressure, a, k, r, above && a < 2 ? c - 1 : c);
  const std::size_t cell = above ? at - 1 : at;
  if (surface_.is_cut(cell)) {
    slip(cell, at, faces);
    let_in(pressure.taken_in(k, r, above ? c - 1 : c), faces);
  }
  for (std::size_t a = 0; a < 3; ++a) {
    by.low[grid.axis(a)] = faces[a].low;
    by.rise[grid.axis(a)] = faces[a].high - faces[a].low;
  }
  return by;
}

CellDisplacement GridToParticles::displacement_by_faces(const Pressure& pressure, LocalId k, LocalId r,
                                                        LocalId c) const {
  const std::size_t at = surface_.grid().index(k, r, c);
  CellDisplacement by = between_faces(pressure, k, r, c);
  if (!displaces(at)) return by;
  pull_back_beyond_weight(follows(at) ? at - 1 : at, by);
  move_back_across(pressure, k, r, c, by);
  return by;
}

CellDisplacement GridToParticles::displacement_of(const Pressure& pressure, const Damping& damping, LocalId k,
                                                  LocalId r, LocalId c) const {
  CellDisplacement by = displacement_by_faces(pressure, k, r, c);
  if (by.act == 0 || !surface_.upright()) return by;
  const ProjectionGrid& grid = surface_.grid();
  const std::size_t at = grid.index(k, r, c);
  const bool above = follows(at);
  const auto map = cell_of<AffineMap>(damping.row.data(), numbers::map, c);
  for (std::size_t a = 0; a < 3; ++a) {
    by.offset[a] += map.a[a];
    for (std::size_t b = 0; b < 3; ++b) by.slope[a][b] += map.b[a][b];
  }
  by.own = map.weight;
  if (above || surface_.is_top(at)) {
    by.surface = above ? c - 1 + surface_.height(at - 1) : c + surface_.height(at);
    by.at_surface = 1 - fade_begins / fade_length;
    by.fade = grid.size()[2] / (spacing_ * fade_length);
  }
  return by;
}

}  // namespace trevi
