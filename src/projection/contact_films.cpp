#include "projection/contact_films.hpp"

#include <algorithm>
#include <cmath>

#include "parallel/waiting.hpp"

namespace trevi {

namespace {

// Of a body's closed faces along an axis, and of one face: less is the rounding of a closed surface.
constexpr Real min_part = 0.002, min_contact = 0.01;

}  // namespace

ContactFilms::ContactFilms(MPI_Comm comm, const CutCells& cuts, Obstacles& obstacles, Real h)
    : comm_(comm),
      cuts_(cuts),
      obstacles_(obstacles),
      h_(h),
      uniform_(3 * obstacles.floating()->count(), h),
      around_(sides * obstacles.floating()->count(), h) {}

// What a uniform pressure of h² in the cell gives to its water at floating bodies, and in the next component the area
// without its sign. A body may go on above the highest cells of the grid: what it has there adds up to its section at
// their upper faces.
void ContactFilms::add_cell(const FreeSurface& surface, const std::array<LocalId, 3>& cell) {
  const ProjectionGrid& grid = surface.grid();
  const RigidBodies& bodies = *obstacles_.floating();
  const std::size_t at = grid.index(cell[0], cell[1], cell[2]);
  const bool ends = cell[2] + 1 == grid.columns() && grid.columns() < grid.count(2);
  const auto add = [&](std::size_t solid, std::size_t a, Real push, const Vec3& place) {
    const auto b = static_cast<Eigen::Index>(grid.axis(a));
    const Vec3 along = push * Vec3::Unit(b), area = std::abs(push) * Vec3::Unit((b + 1) % 3);
    uniform_.add(3 * (solid - bodies.first()) + a,
                 TotalImpulse{along + area, (place - bodies.center(solid)).cross(along)});
  };
  if (surface.is_solid(at)) {
    if (!ends || !cuts_.floats(at)) return;
    const Real height = grid.size()[2];
    add(cuts_.nearest(at), 2, -h_ * h_ / height, cuts_.middle(cell[0], cell[1], cell[2]) + Vec3::UnitZ() * height / 2);
    return;
  }
  if (!cuts_.is_pushed(at)) return;
  cuts_.for_each_closed(cell, at, [&](std::size_t solid, std::size_t a, bool upper, Real closed, const Vec3& arm) {
    if (!bodies.holds(solid) || (ends && a == 2 && upper)) return;
    const Real push = h_ * h_ * closed / grid.size()[static_cast<Eigen::Index>(a)];
    add(solid, a, upper ? push : -push, arm);
  });
}

// Calls visit(direction, whether it is the upper face, account of what is beyond it) for the faces of a cell beyond
// which there is a wall or a solid other than the body.
template <class Visit>
void ContactFilms::for_each_touched(const FreeSurface& surface, const std::array<LocalId, 3>& cell, std::size_t body,
                                    const Visit& visit) const {
  const ProjectionGrid& grid = surface.grid();
  const std::size_t at = grid.index(cell[0], cell[1], cell[2]);
  for (std::size_t a = 0; a < 3; ++a) {
    for (const bool upper : {false, true}) {
      if (grid.is_wall({a, upper}, cell[0], cell[1], cell[2])) {
        visit(a, upper, obstacles_.box_account());
        continue;
      }
      const std::size_t beyond = upper ? at + grid.step(a) : at - grid.step(a);
      if (surface.is_solid(beyond) && cuts_.nearest(beyond) != body) visit(a, upper, cuts_.nearest(beyond));
    }
  }
}

// Calls visit(body, what it closes, cell, number of a side, account beyond it) for the closed faces of bodies in cells
// that touch something else.
template <class Visit>
void ContactFilms::for_each_beside(const FreeSurface& surface, const Visit& visit) const {
  const ProjectionGrid& grid = surface.grid();
  const RigidBodies& bodies = *obstacles_.floating();
  for_each_row(grid.rows_of({1, grid.planes() + 1}), [&](LocalId k, LocalId r) {
    const Range cut = cuts_.cut_columns(k, r);
    for (LocalId c = cut.begin; c < std::min(cut.end, grid.columns()); ++c) {
      const std::array<LocalId, 3> cell{k, r, c};
      const std::size_t at = grid.index(k, r, c);
      if (surface.is_solid(at) || !cuts_.is_pushed(at) || cuts_.is_gap(at)) continue;
      cuts_.for_each_closed(cell, at, [&](std::size_t solid, std::size_t, bool, Real closed, const Vec3&) {
        if (!bodies.holds(solid)) return;
        for_each_touched(surface, cell, solid, [&](std::size_t a, bool upper, std::size_t account) {
          visit(solid - bodies.first(), closed, cell, side(a, upper), account);
        });
      });
    }
  });
}

void ContactFilms::find(const FreeSurface& surface) {
  const ProjectionGrid& grid = surface.grid();
  uniform_.clear();
  for_each_row(grid.rows_of({1, grid.planes() + 1}), [&](LocalId k, LocalId r) {
    const Range cut = cuts_.cut_columns(k, r);
    for (LocalId c = cut.begin; c < std::min(cut.end, grid.columns()); ++c) add_cell(surface, {k, r, c});
  });
  std::vector<TotalImpulse> missing = uniform_.total(comm_);
  bool any = false;
  for (std::size_t n = 0; n < missing.size(); ++n) {
    const auto b = static_cast<Eigen::Index>(grid.axis(n % 3));
    const Real face = h_ * h_ / grid.size()[static_cast<Eigen::Index>(n % 3)], push = missing[n].shift[b];
    const bool touches = std::abs(push) > min_contact * face + min_part * missing[n].shift[(b + 1) % 3];
    missing[n].shift = push * Vec3::Unit(b);
    if (!touches) missing[n] = {};
    any = any || touches;
  }
  contacts_.clear();
  if (!any) return;
  find_touched(surface);
  share_out(surface, std::move(missing));
}

void ContactFilms::find_touched(const FreeSurface& surface) {
  const std::size_t count = sides * obstacles_.floating()->count();
  PerThread<std::vector<int>> touched;
  touched.for_each([&](auto& of) { of.assign(count, 0); });
  for_each_beside(surface, [&](std::size_t body, Real, const auto&, std::size_t of_side, std::size_t account) {
    touched.mine().resize(count, 0);
    int& found = touched.mine()[sides * body + of_side];
    found = std::max(found, static_cast<int>(account) + 1);
  });
  touched_.assign(count, 0);
  touched.for_each([&](const auto& of) {
    for (std::size_t n = 0; n < of.size(); ++n) touched_[n] = std::max(touched_[n], of[n]);
  });
  all_reduce(comm_, touched_.data(), static_cast<int>(count), MPI_INT, MPI_MAX);
}

// The same push about the centre of another body.
TotalImpulse ContactFilms::about(std::size_t body, const TotalImpulse& push, std::size_t other) const {
  const RigidBodies& bodies = *obstacles_.floating();
  const Vec3 arm = bodies.center(bodies.first() + body) - bodies.center(bodies.first() + other);
  return {push.shift, push.moment + arm.cross(push.shift)};
}

// A body that rests on another one hands the surface of that contact on to it, and so forth down to what stands still.
// `missing`: for each body and direction, what is missing to a closed surface.
void ContactFilms::share_out(const FreeSurface& surface, std::vector<TotalImpulse> missing) {
  const RigidBodies& bodies = *obstacles_.floating();
  for (std::size_t pass = 0; pass <= bodies.count(); ++pass) {
    for (std::size_t n = 0; n < missing.size(); ++n) {
      const auto b = static_cast<Eigen::Index>(surface.grid().axis(n % 3));
      const std::size_t body = n / 3, on = side(n % 3, missing[n].shift[b] > 0);
      const int other = touched_[sides * body + on];
      if (missing[n].shift.isZero(0) || other == 0) continue;
      const auto account = static_cast<std::size_t>(other - 1);
      contacts_.push_back({body, on, account, missing[n]});
      if (bodies.holds(account)) {
        const std::size_t next = account - bodies.first();
        missing[3 * next + n % 3] += about(body, missing[n], next);
      }
      missing[n] = {};
    }
  }
}

// The pressure around a contact is that of the cells beside both the body and what it touches, in the mean, weighted by
// what the body closes; below and above a body it is that at its lowest or highest point.
const std::vector<TotalImpulse>& ContactFilms::press(const FreeSurface& surface, const RecordForces& forces,
                                                     Real spacing) {
  films_.clear();
  if (contacts_.empty()) return films_;
  const ProjectionGrid& grid = surface.grid();
  const RigidBodies& bodies = *obstacles_.floating();
  around_.clear();
  for_each_beside(surface, [&](std::size_t body, Real closed, const std::array<LocalId, 3>& cell, std::size_t of_side,
                               std::size_t) {
    const std::size_t at = grid.index(cell[0], cell[1], cell[2]);
    const Box place = obstacles_.body(bodies.first() + body).surface_box();
    const Real z = of_side % 2 == 1 ? place.max.z() : place.min.z();
    const Real height = (z - cuts_.middle(cell[0], cell[1], cell[2]).z()) / grid.size()[2] + 0.5;
    const Real phi = of_side / 2 < 2 ? forces.on_side(at) : forces.at_height(at, std::clamp(height, 0.0, 1.0));
    around_.add(sides * body + of_side, TotalImpulse{Vec3(closed * h_, closed * phi / h_, 0), Vec3::Zero()});
  });
  const std::vector<TotalImpulse> all = around_.total(comm_);
  films_.assign(bodies.count(), {});
  const Real particles = grid.size().prod() / (spacing * spacing * spacing);
  for (Contact& contact : contacts_) {
    const Vec3& sum = all[sides * contact.body + contact.side].shift;
    const Real part = sum.x() > 0 ? -sum.y() / sum.x() * particles : 0;
    contact.film = {part * contact.uniform.shift, part * contact.uniform.moment};
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
