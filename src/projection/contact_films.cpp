#include "projection/contact_films.hpp"

#include <algorithm>
#include <cmath>
#include <span>
#include <tuple>
#include <utility>

#include "parallel/reductions.hpp"

namespace trevi {

namespace {

// Of a body's closed faces along an axis, and of one face: less is the rounding of a closed surface. Less of a face
// than the last one is that of edges, beyond which the body is not.
constexpr Real min_part = 0.002, min_contact = 0.01, min_beside = 0.02;

}  // namespace

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

// Calls visit(number of a side, account of what is beyond it) for the sides of a body on which something else touches
// it next to a cell: beyond the faces of the cell, and beside what the body fills of the next cells. Two bodies with
// flush sides are next to each other there only.
template <class Visit>
void ContactFilms::for_each_touched(const FreeSurface& surface, const std::array<LocalId, 3>& cell, std::size_t body,
                                    const Visit& visit) const {
  const ProjectionGrid& grid = surface.grid();
  const std::size_t at = grid.index(cell[0], cell[1], cell[2]);
  const auto beyond = [&](std::size_t from, std::size_t a, bool upper) {
    return upper ? from + grid.step(a) : from - grid.step(a);
  };
  std::array<bool, sides> known{};
  const auto touch = [&](std::size_t a, bool upper, std::size_t account) {
    if (!std::exchange(known[side(a, upper)], true)) visit(side(a, upper), account);
  };
  const auto look_into = [&](std::size_t a, bool upper) {
    const std::size_t next = beyond(at, a, upper);
    if (!surface.is_solid(next) && !(a < 2 && cuts_.is_gap(next))) return;  // a gap is a part of a contact
    const std::span<const PartOfCell> parts = cuts_.parts_of_cell(next);
    const auto own = std::find_if(parts.begin(), parts.end(), [&](const PartOfCell& p) { return p.solid == body; });
    if (own == parts.end() && cuts_.nearest(next) != body) return touch(a, upper, cuts_.nearest(next));
    for (const PartOfCell& other : parts) {
      if (other.solid == body || own == parts.end()) continue;
      std::size_t b = 0;
      const auto off = [&](std::size_t c) { return other.middle[c] - own->middle[c]; };
      for (const std::size_t c : {1U, 2U})
        if (std::abs(off(c)) > std::abs(off(b))) b = c;
      touch(b, off(b) > 0, other.solid);
    }
    for (std::size_t b = 0; b < 3; ++b) {
      for (const bool above : {false, true}) {
        std::array<LocalId, 3> there = cell;
        there[a] += upper ? 1 : -1;
        if (b == a || grid.is_wall({b, above}, there[0], there[1], there[2])) continue;
        const std::size_t beside = beyond(next, b, above);
        if ((surface.is_solid(beside) || cuts_.is_gap(beside)) && cuts_.nearest(beside) != body)
          touch(b, above, cuts_.nearest(beside));
      }
    }
  };
  for (std::size_t a = 0; a < 3; ++a) {
    for (const bool upper : {false, true}) {
      if (grid.is_wall({a, upper}, cell[0], cell[1], cell[2])) {
        touch(a, upper, obstacles_.box_account());
      } else {
        look_into(a, upper);
      }
    }
  }
}

// Whether a gap ends in a cell, and water reaches it.
bool ContactFilms::is_at_end_of_gap(const FreeSurface& surface, std::size_t at) const {
  const auto opens = [&](std::size_t a) {
    return std::max(cuts_.face(a, at), cuts_.face(a, at + surface.grid().step(a)));
  };
  return surface.is_wet(at) && std::max(opens(0), opens(1)) > 0.5;
}

// Finds the cells beside each contact.
void ContactFilms::find_beside(const FreeSurface& surface) {
  const ProjectionGrid& grid = surface.grid();
  const RigidBodies& bodies = *obstacles_.floating();
  PerThread<std::vector<Beside>> found;
  for_each_row(grid.rows_of({1, grid.planes() + 1}), [&](LocalId k, LocalId r) {
    const Range cut = cuts_.cut_columns(k, r);
    for (LocalId c = cut.begin; c < std::min(cut.end, grid.columns()); ++c) {
      const std::array<LocalId, 3> cell{k, r, c};
      const std::size_t at = grid.index(k, r, c);
      if (surface.is_solid(at) || !cuts_.is_pushed(at) || (cuts_.is_gap(at) && !is_at_end_of_gap(surface, at)))
        continue;
      cuts_.for_each_closed(cell, at, [&](std::size_t solid, std::size_t, bool, Real closed, const Vec3&) {
        if (!bodies.holds(solid) || closed < min_beside) return;
        for_each_touched(surface, cell, solid, [&](std::size_t of_side, std::size_t account) {
          found.mine().push_back(
              {cell, sides * (solid - bodies.first()) + of_side, account, closed * surface.open(at)});
        });
      });
    }
  });
  beside_.clear();
  found.for_each([&](const auto& some) { beside_.insert(beside_.end(), some.begin(), some.end()); });
}

// Sums are integers, so they do not depend on the order.
void ContactFilms::find_touches(const FreeSurface& surface) {
  const RigidBodies& bodies = *obstacles_.floating();
  const auto in_order = [](const Touch& one, const Touch& other) {
    return std::pair(one.side, one.account) < std::pair(other.side, other.account);
  };
  // Adds up those of the same side and account.
  const auto joined = [&](std::vector<Touch> all) {
    std::sort(all.begin(), all.end(), in_order);
    std::vector<Touch> sums;
    for (const Touch& one : all) {
      if (sums.empty() || in_order(sums.back(), one)) sums.push_back({one.side, one.account, 0, 0, {}});
      Touch& sum = sums.back();
      sum.weight += one.weight;
      sum.counted += one.counted;
      for (std::size_t i = 0; i < 2; ++i) sum.moment[i] += one.moment[i];
    }
    return sums;
  };
  std::vector<Touch> own;
  for (const Beside& one : beside_) {
    const auto fine = [](Real number) { return static_cast<std::int64_t>(std::llrint(std::ldexp(number, 30))); };
    const Vec3 arm =
        cuts_.middle(one.cell[0], one.cell[1], one.cell[2]) - bodies.center(bodies.first() + one.side / sides);
    own.push_back({one.side,
                   one.account,
                   fine(one.weight),
                   counts(surface, one) ? fine(one.weight) : 0,
                   {fine(one.weight * arm.x() / h_), fine(one.weight * arm.y() / h_)}});
  }
  touches_ = joined(gather_over_ranks(comm_, joined(std::move(own))));
}

std::span<const ContactFilms::Touch> ContactFilms::touches_of(std::size_t side) const {
  const auto begin = std::lower_bound(touches_.begin(), touches_.end(), side,
                                      [](const Touch& one, std::size_t of) { return one.side < of; });
  auto end = begin;
  while (end != touches_.end() && end->side == side) ++end;
  return {begin, end};
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
  beside_.clear();
  if (!any) return;
  find_beside(surface);
  find_touches(surface);
  share_out(surface, std::move(missing));
}

// Whether the pressure of a cell tells that of the film: beside a body only that of water.
bool ContactFilms::counts(const FreeSurface& surface, const Beside& one) const {
  return one.side % sides >= 4 || surface.is_wet(surface.grid().index(one.cell[0], one.cell[1], one.cell[2]));
}

// The volume, in cells, by which a contact grows in the substep, by the present twists.
Real ContactFilms::displaced_in(const Contact& contact) const {
  const RigidBodies& bodies = *obstacles_.floating();
  const auto passed_by = [&](std::size_t body, const TotalImpulse& push) {
    const RigidBody& solid = bodies.body(body);
    return (push.shift.dot(along_of(solid.twist())) + push.moment.dot(about_of(solid.twist()))) * solid.dt();
  };
  const TotalImpulse& push = contact.open.push;
  Real sum = -passed_by(contact.body, push);
  if (bodies.holds(contact.other)) {
    const std::size_t other = contact.other - bodies.first();
    sum += passed_by(other, about(contact.body, push, other));
  } else if (contact.other != obstacles_.box_account()) {
    // The contact is where a force along its normal has this moment, at the height of the centre of the body.
    const Vec3 place =
        bodies.center(bodies.first() + contact.body) + push.shift.cross(push.moment) / push.shift.squaredNorm();
    sum += push.shift.dot(obstacles_.body(contact.other).displacement_at(place));
  }
  return sum / (h_ * h_);
}

// Each cell gets its sums in the order of the contacts, on any number of threads and ranks.
void ContactFilms::displace(const FreeSurface& surface, Pressure& pressure) {
  for (Contact& contact : contacts_) {
    const Real now = displaced_in(contact), change = now - contact.displaced;
    contact.displaced = now;
    if (change == 0 || contact.side < 4 || !(contact.weight > 0)) continue;
    for (const Beside& one : beside_) {
      if (one.side != sides * contact.body + contact.side || !counts(surface, one)) continue;
      pressure.make_room(surface, surface.grid().index(one.cell[0], one.cell[1], one.cell[2]),
                         change * one.weight / contact.weight);
    }
  }
}

// The same push about the centre of another body.
TotalImpulse ContactFilms::about(std::size_t body, const TotalImpulse& push, std::size_t other) const {
  const RigidBodies& bodies = *obstacles_.floating();
  const Vec3 arm = bodies.center(bodies.first() + body) - bodies.center(bodies.first() + other);
  return {push.shift, push.moment + arm.cross(push.shift)};
}

// The height of the centroid of an open part of a surface about the centre of its body, m; `b`: its normal.
Real ContactFilms::height_of(const Open& open, Eigen::Index b) {
  return (b == 0 ? open.push.moment.y() : -open.push.moment.x()) / open.push.shift[b];
}

// The contacts of a side, none if it touches nothing. Beneath or above a body each of the solids that it touches has a
// share by weight, about the place of its weight; all these places are moved alike, so that the moment is kept. Beside
// a body the solid of the largest weight has it all.
std::vector<ContactFilms::Contact> ContactFilms::split(std::size_t body, std::size_t on, const Open& open) const {
  constexpr Real min_share = 0.02;
  const std::span<const Touch> all = touches_of(sides * body + on);
  if (all.empty()) return {};
  Contact whole{body, on, 0, open};
  std::int64_t weight = 0;
  for (const Touch& one : all) whole.weight += std::ldexp(static_cast<Real>(one.counted), -30);
  if (on < 4 || all.size() == 1) {
    whole.other = std::max_element(all.begin(), all.end(), [](const Touch& one, const Touch& other) {
                    return one.weight < other.weight;
                  })->account;
    return {whole};
  }
  std::vector<Touch> some;
  for (const Touch& one : all) weight += one.weight;
  if (weight == 0) return {};
  for (const Touch& one : all)
    if (static_cast<Real>(one.weight) >= min_share * static_cast<Real>(weight)) some.push_back(one);
  weight = 0;
  std::array<std::int64_t, 2> moment{};
  for (const Touch& one : some) {
    weight += one.weight;
    for (std::size_t i = 0; i < 2; ++i) moment[i] += one.moment[i];
  }
  const auto place_of = [&](const std::array<std::int64_t, 2>& of, std::int64_t by) {
    return Vec3(h_ * static_cast<Real>(of[0]) / static_cast<Real>(by),
                h_ * static_cast<Real>(of[1]) / static_cast<Real>(by), 0);
  };
  const Vec3& push = open.push.shift;
  const Vec3 off = push.cross(open.push.moment) / push.squaredNorm() - place_of(moment, weight);
  std::vector<Contact> contacts;
  for (const Touch& one : some) {
    Contact part = whole;
    part.other = one.account;
    part.open.push.shift = push * (static_cast<Real>(one.weight) / static_cast<Real>(weight));
    part.open.push.moment = (place_of(one.moment, one.weight) + off).cross(part.open.push.shift);
    contacts.push_back(part);
  }
  return contacts;
}

// A body that rests on another one hands the surface of that contact on to it, and so forth down to what stands still.
// `missing`: for each body and direction, what is missing to a closed surface.
void ContactFilms::share_out(const FreeSurface& surface, std::vector<Open> missing) {
  const RigidBodies& bodies = *obstacles_.floating();
  for (std::size_t pass = 0; pass <= bodies.count(); ++pass) {
    for (std::size_t n = 0; n < missing.size(); ++n) {
      const auto b = static_cast<Eigen::Index>(surface.grid().axis(n % 3));
      const std::size_t body = n / 3, on = side(n % 3, missing[n].push.shift[b] > 0);
      // Less is the rounding of what other contacts have handed on.
      const Real face = h_ * h_ / surface.grid().size()[static_cast<Eigen::Index>(n % 3)];
      if (std::abs(missing[n].push.shift[b]) <= min_contact * face) continue;
      const std::vector<Contact> contacts = split(body, on, missing[n]);
      if (contacts.empty()) continue;
      missing[n] = {};
      for (const Contact& contact : contacts) {
        contacts_.push_back(contact);
        if (!bodies.holds(contact.other)) continue;
        const std::size_t next = contact.other - bodies.first();
        const Open& open = contact.open;
        Open& rest = missing[3 * next + n % 3];
        const Real up = bodies.center(bodies.first() + body).z() - bodies.center(contact.other).z();
        if (n % 3 < 2) rest.square += open.square + open.push.shift[b] * up * (2 * height_of(open, b) + up);
        rest.push += about(body, open.push, next);
      }
    }
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
    const auto& [cell, of_side, account, part] = beside_[static_cast<std::size_t>(n)];
    const std::size_t at = grid.index(cell[0], cell[1], cell[2]), body = bodies.first() + of_side / sides;
    const Real middle = cuts_.middle(cell[0], cell[1], cell[2]).z();
    if (!counts(surface, beside_[static_cast<std::size_t>(n)])) return;
    Real up = 0, height = 0.5;  // above the centre of the body; in the cell
    if (of_side % sides < 4) {
      up = (middle - bodies.center(body).z()) / half_height(body);
    } else {
      const Box place = obstacles_.body(body).surface_box();
      height = ((of_side % 2 == 1 ? place.max : place.min).z() - middle) / grid.size()[2] + 0.5;
    }
    const Real phi = forces.at_height(at, height) / (h_ * h_), weight = part * h_;
    around_.add(of_side, TotalImpulse{weight * Vec3(1, phi, up), weight * h_ * Vec3(up * up, up * phi, 0)});
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
