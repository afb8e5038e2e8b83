// Contacts of bodies: what touches each of their sides, next to which cells, and with which part of their surface.
#include <algorithm>
#include <cmath>
#include <utility>

#include "parallel/reductions.hpp"
#include "projection/contact_films.hpp"

namespace trevi {

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
  constexpr Real min_beside = 0.02;  // of a face: less is that of an edge, beyond which the body is not
  PerThread<std::vector<Beside>> found;
  for_each_row(grid.rows_of({1, grid.planes() + 1}), [&](LocalId k, LocalId r) {
    const Range cut = cuts_.cut_columns(k, r);
    for (LocalId c = cut.begin; c < std::min(cut.end, grid.columns()); ++c) {
      const std::array<LocalId, 3> cell{k, r, c};
      const std::size_t at = grid.index(k, r, c);
      if (surface.is_solid(at) || !cuts_.is_pushed(at) || (cuts_.is_gap(at) && !is_at_end_of_gap(surface, at)))
        continue;
      std::array<std::pair<std::size_t, Real>, SolidParts::max_solids> closing;  // bodies, and what they close
      std::size_t count = 0;
      cuts_.for_each_closed(cell, at, [&](std::size_t solid, std::size_t, bool, Real closed, const Vec3&) {
        if (!bodies.holds(solid) || closed < min_beside) return;
        std::size_t n = 0;
        while (n < count && closing[n].first != solid) ++n;
        if (n == closing.size()) return;
        if (n == count) closing[count++] = {solid, 0};
        closing[n].second += closed;
      });
      for (std::size_t n = 0; n < count; ++n) {
        const auto [solid, closed] = closing[n];
        const Real weight = closed * surface.open(at);
        for_each_touched(surface, cell, solid, [&](std::size_t of_side, std::size_t account) {
          found.mine().push_back({cell, sides * (solid - bodies.first()) + of_side, account, weight});
        });
      }
    }
  });
  beside_.clear();
  found.for_each([&](const auto& some) { beside_.insert(beside_.end(), some.begin(), some.end()); });
}

// Sums are integers, so they do not depend on the order.
void ContactFilms::find_touches() {
  const RigidBodies& bodies = *obstacles_.floating();
  const auto in_order = [](const Touch& one, const Touch& other) {
    return std::pair(one.side, one.account) < std::pair(other.side, other.account);
  };
  // Adds up those of the same side and account.
  const auto joined = [&](std::vector<Touch> all) {
    std::sort(all.begin(), all.end(), in_order);
    std::vector<Touch> sums;
    for (const Touch& one : all) {
      if (sums.empty() || in_order(sums.back(), one)) sums.push_back({one.side, one.account, 0, {}});
      Touch& sum = sums.back();
      sum.weight += one.weight;
      for (std::size_t i = 0; i < 2; ++i) sum.moment[i] += one.moment[i];
    }
    return sums;
  };
  std::vector<Touch> own;
  for (const Beside& one : beside_) {
    const auto fine = [](Real number) { return static_cast<std::int64_t>(std::llrint(std::ldexp(number, 30))); };
    const Vec3 arm =
        cuts_.middle(one.cell[0], one.cell[1], one.cell[2]) - bodies.center(bodies.first() + one.side / sides);
    own.push_back(
        {one.side, one.account, fine(one.weight), {fine(one.weight * arm.x() / h_), fine(one.weight * arm.y() / h_)}});
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
// share by weight, which is that of the edges of the contact rather than its area, about the place of its weight; all
// these places are moved alike, so that the moment is kept. Beside a body the solid of the largest weight has it all.
std::vector<ContactFilms::Contact> ContactFilms::split(std::size_t body, std::size_t on, const Open& open) const {
  constexpr Real min_share = 0.02;  // of the largest weight
  const std::span<const Touch> all = touches_of(sides * body + on);
  std::int64_t weight = 0, largest = 0;
  for (const Touch& one : all) {
    weight += one.weight;
    largest = std::max(largest, one.weight);
  }
  if (largest == 0) return {};
  const Contact whole{body, on, 0, open, {}, std::ldexp(static_cast<Real>(weight), -30)};
  std::vector<Touch> some;
  for (const Touch& one : all) {
    const bool counts = on < 4 ? one.weight == largest && some.empty()
                               : static_cast<Real>(one.weight) >= min_share * static_cast<Real>(largest);
    if (counts) some.push_back(one);
  }
  std::vector<Contact> contacts(some.size(), whole);
  for (std::size_t n = 0; n < some.size(); ++n) contacts[n].other = some[n].account;
  if (some.size() == 1) return contacts;
  weight = 0;
  std::array<std::int64_t, 2> moment{};
  for (const Touch& one : some) {
    weight += one.weight;
    for (std::size_t i = 0; i < 2; ++i) moment[i] += one.moment[i];
  }
  const auto place_of = [&](const std::array<std::int64_t, 2>& of, std::int64_t by) {
    const Real unit = h_ / static_cast<Real>(by);
    return Vec3(unit * static_cast<Real>(of[0]), unit * static_cast<Real>(of[1]), 0);
  };
  const Vec3& push = open.push.shift;
  const Vec3 off = push.cross(open.push.moment) / push.squaredNorm() - place_of(moment, weight);
  for (std::size_t n = 0; n < some.size(); ++n) {
    TotalImpulse& part = contacts[n].open.push;
    part.shift = push * (static_cast<Real>(some[n].weight) / static_cast<Real>(weight));
    part.moment = (place_of(some[n].moment, some[n].weight) + off).cross(part.shift);
  }
  return contacts;
}

// A body that rests on another one hands the surface of that contact on to it, and so forth down to what stands still.
// What touches one solid only is handed on first, because its share is known. `missing`: for each body and direction,
// what is missing to a closed surface.
void ContactFilms::share_out(const FreeSurface& surface, std::vector<Open> missing) {
  const RigidBodies& bodies = *obstacles_.floating();
  const auto hand_on = [&](std::size_t n, bool shared) {
    const auto b = static_cast<Eigen::Index>(surface.grid().axis(n % 3));
    const std::size_t body = n / 3, on = side(n % 3, missing[n].push.shift[b] > 0);
    // Less is the rounding of what other contacts have handed on.
    const Real face = h_ * h_ / surface.grid().size()[static_cast<Eigen::Index>(n % 3)];
    if (std::abs(missing[n].push.shift[b]) <= min_contact * face) return false;
    if (!shared && on >= 4 && touches_of(sides * body + on).size() > 1) return false;
    const std::vector<Contact> contacts = split(body, on, missing[n]);
    if (contacts.empty()) return false;
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
    return true;
  };
  bool shared = false;
  for (std::size_t pass = 0; pass < 2 * (missing.size() + 1); ++pass) {
    bool any = false;
    for (std::size_t n = 0; n < missing.size() && !(any && shared); ++n) any = hand_on(n, shared) || any;
    if (!any && shared) return;
    shared = !any;
  }
}

}  // namespace trevi
