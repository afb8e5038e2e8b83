#include "projection/contact_films.hpp"

#include <algorithm>
#include <cmath>
#include <span>
#include <utility>

namespace trevi {

ContactFilms::ContactFilms(MPI_Comm comm, const CutCells& cuts, Obstacles& obstacles, Real h)
    : comm_(comm),
      cuts_(cuts),
      obstacles_(obstacles),
      h_(h),
      uniform_(3 * obstacles.floating()->count(), h),
      around_(sides * obstacles.floating()->count(), h) {}

// Half the height of a body, m, which is the unit of heights about its centre.
Real ContactFilms::half_height(std::size_t body) const {
  const Box place = obstacles_.body(body).surface_box();
  return (place.max.z() - place.min.z()) / 2;
}

// What a uniform pressure of h² in the cell gives to its water at floating bodies; in the next component the area
// without its sign, and in the one after that the push times the square of the height about the centre of the body. A
// body may go on above the highest cells of the grid: what it has there adds up to its section at their upper faces.
void ContactFilms::add_cell(const FreeSurface& surface, const std::array<LocalId, 3>& cell) {
  const ProjectionGrid& grid = surface.grid();
  const RigidBodies& bodies = *obstacles_.floating();
  const std::size_t at = grid.index(cell[0], cell[1], cell[2]);
  const bool ends = cell[2] + 1 == grid.columns() && grid.columns() < grid.count(2);
  const Real middle = cuts_.middle(cell[0], cell[1], cell[2]).z(), size = grid.size()[2];
  const auto add = [&](std::size_t solid, std::size_t a, Real push, const Vec3& place) {
    const auto b = static_cast<Eigen::Index>(grid.axis(a));
    const Vec3 off = place - bodies.center(solid);
    // What is closed of a face is as high as its centroid and the body allow.
    const Real unit = half_height(solid);
    const Real extent = a < 2 ? std::min(size - 2 * std::abs(place.z() - middle), 2 * unit) : 0;
    const Real square = (off.z() * off.z() + extent * extent / 12) / (unit * unit);
    const Vec3 along = push * Vec3::Unit(b), area = std::abs(push) * Vec3::Unit((b + 1) % 3);
    uniform_.add(3 * (solid - bodies.first()) + a,
                 TotalImpulse{along + area + push * square * Vec3::Unit((b + 2) % 3), off.cross(along)});
  };
  if (surface.is_solid(at)) {
    if (!ends) return;
    const Vec3 top = cuts_.middle(cell[0], cell[1], cell[2]) + Vec3::UnitZ() * size / 2;
    const std::span<const PartOfCell> parts = cuts_.parts_of_cell(at);
    if (parts.empty() && cuts_.floats(at)) add(cuts_.nearest(at), 2, -h_ * h_ / size, top);
    for (const PartOfCell& part : parts)
      if (bodies.holds(part.solid)) add(part.solid, 2, -h_ * h_ / size * part.volume, top);
    return;
  }
  if (!cuts_.is_pushed(at)) return;
  cuts_.for_each_closed(cell, at, [&](std::size_t solid, std::size_t a, bool upper, Real closed, const Vec3& arm) {
    if (!bodies.holds(solid) || (ends && a == 2 && upper)) return;
    const Real push = h_ * h_ * closed / grid.size()[static_cast<Eigen::Index>(a)];
    add(solid, a, upper ? push : -push, arm);
  });
}

void ContactFilms::find(const FreeSurface& surface) {
  const ProjectionGrid& grid = surface.grid();
  uniform_.clear();
  for_each_row(grid.rows_of({1, grid.planes() + 1}), [&](LocalId k, LocalId r) {
    const Range cut = cuts_.cut_columns(k, r);
    for (LocalId c = cut.begin; c < std::min(cut.end, grid.columns()); ++c) add_cell(surface, {k, r, c});
  });
  const std::vector<TotalImpulse> sums = uniform_.total(comm_);
  std::vector<Open> missing(sums.size());
  bool any = false;
  constexpr Real min_part = 0.002;  // of a body's closed faces along an axis: the rounding of a closed surface
  for (std::size_t n = 0; n < sums.size(); ++n) {
    const auto b = static_cast<Eigen::Index>(grid.axis(n % 3));
    const Vec3& sum = sums[n].shift;
    const Real face = h_ * h_ / grid.size()[static_cast<Eigen::Index>(n % 3)];
    if (!(std::abs(sum[b]) > min_contact * face + min_part * sum[(b + 1) % 3])) continue;
    const Real unit = half_height(obstacles_.floating()->first() + n / 3);
    missing[n] = {{sum[b] * Vec3::Unit(b), sums[n].moment}, sum[(b + 2) % 3] * unit * unit};
    any = true;
  }
  contacts_.clear();
  if (!any) return;
  find_beside(surface);
  find_touches();
  share_out(surface, std::move(missing));
}

// The volume, in cells, by which a contact grows in the substep, by the present twists.
Real ContactFilms::displaced_in(const Contact& contact) const {
  const RigidBodies& bodies = *obstacles_.floating();
  const TotalImpulse& push = contact.open.push;
  Real sum = -bodies.passed_by(contact.body, push);
  if (bodies.holds(contact.other)) {
    const std::size_t other = contact.other - bodies.first();
    sum += bodies.passed_by(other, about(contact.body, push, other));
  } else if (contact.other != obstacles_.box_account()) {
    // The contact is where a force along its normal has this moment, at the height of the centre of the body.
    const Vec3 place =
        bodies.center(bodies.first() + contact.body) + push.shift.cross(push.moment) / push.shift.squaredNorm();
    sum += push.shift.dot(obstacles_.body(contact.other).displacement_at(place));
  }
  return sum / (h_ * h_);
}

// The entries of a cell are in one order on any number of threads and ranks, because one thread has found them.
void ContactFilms::displace(const FreeSurface& surface, Pressure& pressure) {
  if (contacts_.empty()) return;
  std::vector<Real> change(sides * obstacles_.floating()->count());  // of each side, for a weight of 1
  for (Contact& contact : contacts_) {
    if (contact.side < 4) continue;
    const Real now = displaced_in(contact);
    change[sides * contact.body + contact.side] += (now - contact.displaced) / contact.weight;
    contact.displaced = now;
  }
  for (const Beside& one : beside_) {
    if (change[one.side] != 0)
      pressure.make_room(surface, surface.grid().index(one.cell[0], one.cell[1], one.cell[2]),
                         change[one.side] * one.weight);
  }
}

namespace {

// The mean over a height, m, and that times the distance from its middle, of a pressure that is `phi` in the middle and
// grows upwards by `rise` a metre, where it is below zero.
std::pair<Real, Real> below_zero(Real phi, Real rise, Real height) {
  Real low = -height / 2, high = height / 2;
  if (rise > 0) high = std::clamp(-phi / rise, low, high);
  if (rise < 0) low = std::clamp(-phi / rise, low, high);
  if (!(height > 0) || (rise == 0 && phi >= 0)) return {std::min(phi, 0.0), 0};
  const Real square = (high * high - low * low) / 2, cube = (high * high * high - low * low * low) / 3;
  return {(phi * (high - low) + rise * square) / height, (phi * square + rise * cube) / height};
}

}  // namespace

// What the film of a contact gives to the water, by what is known of the pressure around it. Beside a body it is linear
// in height, over as much of it as the second moment of the contact tells. Its slope is fitted to the cells around.
// They may all be at one height, so the slope of water at rest counts as further cells, which lie apart by
// `spread_at_rest` in square. Of contacts on both sides of a body only the difference is known, which may seem to lie
// beyond the body; they have the mean pressure.
TotalImpulse ContactFilms::film_of(const Contact& contact, Eigen::Index b, const TotalImpulse& around,
                                   Real g_dt2) const {
  constexpr Real spread_at_rest = 0.2;  // of half the height of the body, squared
  const Real weight = around.shift.x();
  if (!(weight > 0)) return {};
  const TotalImpulse& push = contact.open.push;
  const auto mean = [&](Real sum) { return sum / weight; };
  const Real phi = mean(around.shift.y()), level = mean(around.shift.z());
  const TotalImpulse even{-phi * push.shift, -phi * push.moment};
  if (b == 2) return even;
  const Real unit = half_height(obstacles_.floating()->first() + contact.body), height = height_of(contact.open, b);
  const Real square = contact.open.square / push.shift[b] - height * height;
  if (std::abs(height) > unit || square < 0) return even;
  // Falling water has no pressure, and no slope.
  const Real at_rest = std::min(g_dt2 * unit / (h_ * h_), -10 * phi);
  const Real spread = mean(around.moment.x()) / h_ - level * level;
  const Real rise = (mean(around.moment.y()) / h_ - level * phi + spread_at_rest * at_rest) / (spread + spread_at_rest);
  const auto [inside, tilt] = below_zero(phi + rise * (height / unit - level), rise / unit, std::sqrt(12 * square));
  const Vec3 turn = tilt * push.shift[b] * (b == 0 ? Vec3(0, 1, 0) : Vec3(-1, 0, 0));
  return {-inside * push.shift, -inside * push.moment - turn};
}

// The pressure around a contact is that of the cells beside both the body and what it touches, by their weights; below
// and above a body it is that at its lowest or highest point.
const std::vector<TotalImpulse>& ContactFilms::press(const FreeSurface& surface, const RecordForces& forces,
                                                     Real spacing) {
  films_.clear();
  if (contacts_.empty()) return films_;
  const ProjectionGrid& grid = surface.grid();
  const RigidBodies& bodies = *obstacles_.floating();
  around_.clear();
  for_each_part(static_cast<LocalId>(beside_.size()), [&](LocalId n) {
    const Beside& one = beside_[static_cast<std::size_t>(n)];
    const auto [k, r, c] = one.cell;
    const std::size_t at = grid.index(k, r, c), body = bodies.first() + one.side / sides;
    const Real middle = cuts_.middle(k, r, c).z();
    Real up = 0, height = 0.5;  // above the centre of the body; in the cell
    if (one.side % sides < 4) {
      if (!surface.is_wet(at)) return;
      up = (middle - bodies.center(body).z()) / half_height(body);
    } else {
      const Real end = obstacles_.body(body).lowest_and_highest()[one.side % 2];
      height = std::clamp((end - middle) / grid.size()[2] + 0.5, -1.0, 2.0);
    }
    const Real phi = forces.at_height(at, height) / (h_ * h_), weight = one.weight * h_;
    around_.add(one.side, TotalImpulse{weight * Vec3(1, phi, up), weight * h_ * Vec3(up * up, up * phi, 0)});
  });
  const std::vector<TotalImpulse> all = around_.total(comm_);
  films_.assign(bodies.count(), {});
  const Real particles = grid.size().prod() / (spacing * spacing * spacing);
  for (Contact& contact : contacts_) {
    const auto b = static_cast<Eigen::Index>(grid.axis(contact.side / 2));
    contact.film = film_of(contact, b, all[sides * contact.body + contact.side], forces.g_dt2());
    contact.film.shift *= particles;
    contact.film.moment *= particles;
    films_[contact.body] += contact.film;
    if (!bodies.holds(contact.other)) continue;
    const std::size_t other = contact.other - bodies.first();
    films_[other] -= about(contact.body, contact.film, other);
  }
  return films_;
}

void ContactFilms::record() const {
  if (films_.empty() || rank_of(comm_) != 0) return;
  const RigidBodies& bodies = *obstacles_.floating();
  for (std::size_t k = 0; k < films_.size(); ++k)
    obstacles_.record_about(bodies.first() + k, films_[k], bodies.center(bodies.first() + k));
  for (const Contact& contact : contacts_) {
    if (bodies.holds(contact.other)) continue;
    const TotalImpulse opposite{-contact.film.shift, -contact.film.moment};
    obstacles_.record_about(contact.other, opposite, bodies.center(bodies.first() + contact.body));
  }
}

}  // namespace trevi
