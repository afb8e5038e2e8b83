#include "projection/grid_to_particles.hpp"

#include <algorithm>
#include <cmath>

namespace trevi {

using namespace projection;

void pull_back(const AffineMap& motion, const ByAxis& per_length, Real held, Real share, CellDisplacement& by) {
  by.back = 1 - share;
  for (std::size_t a = 0; a < 3; ++a) {
    for (std::size_t b = 0; b < 3; ++b) {
      const Real back = share * motion.b[b][a] * per_length[a] / 2;
      by.offset[a] += back * (b == 2 ? by.low[b] - held : by.low[b]);
      by.slope[a][b] += back * by.rise[b];
    }
  }
}

namespace {

AffineMap times(AffineMap map, Real factor) {
  map.weight *= factor;
  for (std::size_t i = 0; i < 3; ++i) {
    map.a[i] *= factor;
    for (Real& slope : map.b[i]) slope *= factor;
  }
  return map;
}

// What the linear mean says of a wall is extrapolated where few particles stand for the water, and what is more than
// the mean of the cell's own, or against that, is not theirs (README.md).
Real bounded(Real by_slope, Real by_mean) {
  if (by_mean * by_slope <= 0) return 0;
  return std::abs(by_mean) < std::abs(by_slope) ? by_mean : by_slope;
}

}  // namespace

// A dry cell right above water under gravity: the few particles in it follow the top cell.
bool GridToParticles::follows(std::size_t at) const {
  return surface_.upright() && !surface_.is_wet(at) && surface_.is_wet(at - 1) && !surface_.is_solid(at - 1);
}

// The fraction of the noise of a cell that dies in this step: less where it moves too fast to be noise. `rest2`: the
// mean square of the motion that the fit leaves, m².
Real GridToParticles::rate(Real rest2) const {
  const Real noise = noise_speed * step_.time * h_;
  return std::min(step_.time / noise_time, 1.0) / (1 + rest2 / (noise * noise));
}

// What part of what the fit leaves of a cell, `rest2`, m², is noise: of a smooth motion it is a small part of the mean
// motion's square.
Real GridToParticles::part_of_noise(LocalId k, LocalId r, LocalId c, Real rest2) const {
  const Moments moments = surface_.water().moments(surface_.grid().index(k, r, c));
  const ByAxis& u = moments.flow.u;
  const Vec3 motion(u[0] / moments.at.n, u[1] / moments.at.n, u[2] / moments.at.n + step_.g_dt2);
  const Real smooth = smooth_rest * motion.squaredNorm();
  return smooth > 0 ? rest2 / (rest2 + smooth) : 1;
}

// Whether the surface is at the cell or one of the next above it. Solid cells are wet unless it is beneath them.
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

// By the solid that closes it, and by water that comes through.
Real GridToParticles::moved(std::size_t a, std::size_t face) const {
  const CutCells* cuts = surface_.cuts();
  const Openings* openings = surface_.openings();
  return (cuts != nullptr ? cuts->moved(a, face) : 0) + (openings != nullptr ? openings->displacement(a, face) : 0);
}

// What takes the particles of a cell along with a wall, or with a solid. They move towards it as the linear mean at its
// face does.
Real GridToParticles::through_closed(const CellFace& face, LocalId k, LocalId r, LocalId c) const {
  const ProjectionGrid& grid = surface_.grid();
  const std::size_t at = grid.index(k, r, c);
  const Real wall = moved(face.a, grid.index_of(face, at)), by_wall = wall - closed_.displacement(face, k, r, c);
  const ParticlesToGrid::Means held = surface_.water().means(at);
  return held.n == 0 ? by_wall : bounded(by_wall, wall - held.u[grid.axis(face.a)] / held.n);
}

GridToParticles::FacePair GridToParticles::faces_of(const Pressure& pressure, std::size_t a, LocalId k, LocalId r,
                                                    LocalId c) const {
  const ProjectionGrid& grid = surface_.grid();
  const std::size_t at = grid.index(k, r, c);
  FacePair pair;
  if (a == 1 && grid.is_layer()) return {0, 0, true, true, true, true};
  const CellFace lower{a, false}, upper{a, true};
  pair.low_wall = grid.is_wall(lower, k, r, c);
  pair.high_wall = grid.is_wall(upper, k, r, c);
  pair.low_closed = surface_.is_closed(lower, k, r, c);
  pair.high_closed = surface_.is_closed(upper, k, r, c);
  const bool wet = surface_.is_wet(at);
  const auto through = [&](const CellFace& of, bool closed, bool& known) {
    const std::size_t face = grid.index_of(of, at);
    known = closed ? wet : surface_.is_wet(face) || surface_.is_wet(face - grid.step(a));
    if (!known) return 0.0;
    return closed ? through_closed(of, k, r, c) : pressure.displacement(surface_, a, face);
  };
  bool low_known = false, high_known = false;
  pair.low = through(lower, pair.low_closed, low_known);
  pair.high = through(upper, pair.high_closed, high_known);
  // A face between two dry cells has no phi on either side; under gravity it takes that of the opposite face.
  if (surface_.upright() && !low_known) pair.low = pair.high;
  if (surface_.upright() && !high_known) pair.high = pair.low;
  return pair;
}

// How pressure displaces the water of a cell, by its open faces; in a direction that has none, and beside bodies that
// float, which lean and heave more by those, as it bears the weight.
Vec3 GridToParticles::by_open_faces(std::size_t at, const Faces& faces) const {
  const CutCells& cuts = *surface_.cuts();
  Vec3 pushed(0, 0, step_.g_dt2);
  if (cuts.floats(at)) return pushed;
  for (std::size_t a = 0; a < 3; ++a) {
    const Real low = faces[a].low_closed ? 0 : cuts.face(a, at);
    const Real high = faces[a].high_closed ? 0 : cuts.face(a, at + surface_.grid().step(a));
    if (low + high > 0)
      pushed[static_cast<Eigen::Index>(a)] = (low * faces[a].low + high * faces[a].high) / (low + high);
  }
  return pushed;
}

// Nothing where the surface has no direction. A sheet one cell deep on a solid, and water at a body that moves freely,
// are bounded as water at walls is: the slope beside a light body that rises is steep, and throws what is few. `own`:
// the cell whose particles they are, `at` or the dry one above that follows it.
std::optional<GridToParticles::SolidSurface> GridToParticles::solid_surface(std::size_t at, std::size_t own,
                                                                            const Faces& faces,
                                                                            const Vec3& pushed) const {
  const ProjectionGrid& grid = surface_.grid();
  const CutCells& cuts = *surface_.cuts();
  const ParticlesToGrid& water = surface_.water();
  // A wet cell without particles, below one that follows it, has no fit of this step.
  const AffineMap fit = water.fit(at).weight > 0 ? water.fit(at) : AffineMap{};
  Vec3 area = Vec3::Zero(), solid = Vec3::Zero();  // of the solid's surface, out of it; and how it moves
  Real flux = 0, divergence = 0;
  for (std::size_t a = 0; a < 3; ++a) {
    const auto i = static_cast<Eigen::Index>(a);
    const std::size_t above = at + grid.step(a), b = grid.axis(a);
    ByAxis low = cuts.middle_of_face(a, at), high = cuts.middle_of_face(a, above);
    low[b] = 0;
    high[b] = 1;
    flux += cuts.face(a, above) * fit.at(b, high) - cuts.face(a, at) * fit.at(b, low);
    divergence += fit.b[b][b];
    if (faces[a].low_wall || faces[a].high_wall) continue;  // the box's face is no part of the solid's surface
    area[i] = cuts.face(a, above) - cuts.face(a, at);
    const Real closed_low = 1 - cuts.face(a, at), closed_high = 1 - cuts.face(a, above);
    if (closed_low + closed_high > 0)
      solid[i] = (closed_low * moved(a, at) + closed_high * moved(a, above)) / (closed_low + closed_high);
  }
  const Real size = area.norm();
  if (size < min_wall) return std::nullopt;
  const Vec3 n = area / size;
  Real into = (flux - cuts.open(at) * divergence) / size + n.dot(pushed - solid);
  const bool is_sheet = surface_.is_top(at) && cuts.face(2, at) == 0;
  if (const ParticlesToGrid::Means held = water.means(own); (is_sheet || cuts.floats(at)) && held.n > 0) {
    const Vec3 mean = Vec3(held.u[grid.axis(0)], held.u[grid.axis(1)], held.u[grid.axis(2)]) / held.n;
    into = bounded(into, n.dot(mean + pushed - solid));
  }
  return SolidSurface{n, into};
}

// At the closed faces of a cell that a solid cuts, but for those in the walls of the box. What the surface asks for is
// asked for at the surface, which in the mean is as far from an open face as the cell's volume reaches from it; the
// closed face beyond takes the linear continuation; not beside a body that floats, which sailed on by it.
void GridToParticles::slip(std::size_t at, std::size_t own, Faces& faces) const {
  const ProjectionGrid& grid = surface_.grid();
  const CutCells& cuts = *surface_.cuts();
  const Vec3 pushed = by_open_faces(at, faces);
  const std::optional<SolidSurface> solid = solid_surface(at, own, faces, pushed);
  if (!solid) return;
  for (std::size_t a = 0; a < 3; ++a) {
    const auto i = static_cast<Eigen::Index>(a);
    const Real along = pushed[i] - solid->normal[i] * solid->into;
    FacePair& pair = faces[a];
    const bool low = pair.low_closed && !pair.low_wall, high = pair.high_closed && !pair.high_wall;
    const bool from_open = a < 2 && !cuts.floats(at) && (low ? !pair.high_closed : !pair.low_closed);
    const auto beyond = [&](Real open, std::size_t open_face) {
      if (!from_open) return along;
      return open + (along - open) / std::clamp(cuts.open(at) / cuts.face(a, open_face), min_distance, 1.0);
    };
    if (low) pair.low = beyond(pair.high, at + grid.step(a));
    if (high) pair.high = beyond(pair.low, at);
  }
}

void GridToParticles::pull_back_beyond_weight(std::size_t cell, CellDisplacement& by) const {
  if (!surface_.upright() || !surface_.is_wet(cell)) return;
  Vec3 middle;
  for (std::size_t a = 0; a < 3; ++a) middle[static_cast<Eigen::Index>(a)] = by.low[a] + by.rise[a] / 2;
  const Real times_weight = middle.norm() / step_.g_dt2;
  const bool at_solid = surface_.is_cut(cell) && !surface_.cuts()->floats(cell);
  const Real share =
      at_solid ? 1.0 : std::clamp((times_weight - pulled_begins) / (pulled_full - pulled_begins), 0.0, 1.0);
  if (share == 0) return;
  const AffineMap motion = surface_.water().fit(cell);
  if (motion.weight == 0) return;
  pull_back(motion, surface_.grid().per_length(), std::clamp(middle.z(), 0.0, step_.g_dt2), share, by);
}

CellDisplacement GridToParticles::displacement_by_faces(const Pressure& pressure, LocalId k, LocalId r,
                                                        LocalId c) const {
  const ProjectionGrid& grid = surface_.grid();
  const std::size_t at = grid.index(k, r, c);
  const bool above = follows(at);
  CellDisplacement by;
  by.act = surface_.is_wet(at) || above ? 1 : 0;
  if (!displaces(at)) return by;
  Faces faces;
  for (std::size_t a = 0; a < 3; ++a) faces[a] = faces_of(pressure, a, k, r, above && a < 2 ? c - 1 : c);
  const std::size_t cell = above ? at - 1 : at;
  if (surface_.is_cut(cell)) slip(cell, at, faces);
  for (std::size_t a = 0; a < 3; ++a) {
    by.low[grid.axis(a)] = faces[a].low;
    by.rise[grid.axis(a)] = faces[a].high - faces[a].low;
  }
  pull_back_beyond_weight(cell, by);
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
