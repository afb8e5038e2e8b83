#include "projection/contact_films.hpp"

#include <algorithm>
#include <cmath>

#include "parallel/waiting.hpp"

namespace trevi {

namespace {

constexpr Real min_contact = 0.01;  // of a face of a cell: less is the rounding of a closed surface

}  // namespace

ContactFilms::ContactFilms(MPI_Comm comm, const CutCells& cuts, Obstacles& obstacles, Real h)
    : comm_(comm),
      cuts_(cuts),
      obstacles_(obstacles),
      h_(h),
      uniform_(3 * obstacles.floating()->count(), h),
      around_(sides * obstacles.floating()->count(), h) {}

// What a uniform pressure in the cell gives to its water. Above the highest cells of the grid a body goes on: what it
// has there adds up to its section at their upper faces, which lies in cells that it fills.
void ContactFilms::add_cell(const FreeSurface& surface, const std::array<LocalId, 3>& cell) {
  const ProjectionGrid& grid = surface.grid();
  const RigidBodies& bodies = *obstacles_.floating();
  const std::size_t at = grid.index(cell[0], cell[1], cell[2]);
  const bool ends = cell[2] + 1 == grid.columns() && grid.columns() < grid.count(2);
  const auto add = [&](std::size_t solid, std::size_t a, const Vec3& shift, const Vec3& place) {
    const Impulse push{shift * h_, place - bodies.center(solid)};
    uniform_.add(3 * (solid - bodies.first()) + a, {&push, 1});
  };
  if (surface.is_solid(at)) {
    if (!ends || !cuts_.floats(at)) return;
    add(cuts_.nearest(at), 2, -Vec3::UnitZ() * h_ / grid.size()[2],
        cuts_.middle(cell[0], cell[1], cell[2]) + Vec3::UnitZ() * grid.size()[2] / 2);
    return;
  }
  cuts_.for_each_closed(cell, at, [&](std::size_t solid, std::size_t a, bool upper, Real closed, const Vec3& arm) {
    if (!bodies.holds(solid) || (ends && a == 2 && upper)) return;
    const Real push = h_ * closed / grid.size()[static_cast<Eigen::Index>(a)];
    add(solid, a, (upper ? push : -push) * Vec3::Unit(static_cast<Eigen::Index>(grid.axis(a))), arm);
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

void ContactFilms::find(const FreeSurface& surface) {
  const ProjectionGrid& grid = surface.grid();
  const RigidBodies& bodies = *obstacles_.floating();
  uniform_.clear();
  for_each_row(grid.rows_of({1, grid.planes() + 1}), [&](LocalId k, LocalId r) {
    const Range cut = cuts_.cut_columns(k, r);
    for (LocalId c = cut.begin; c < std::min(cut.end, grid.columns()); ++c) add_cell(surface, {k, r, c});
  });
  const std::vector<TotalImpulse> all = uniform_.total(comm_);
  contacts_.clear();
  for (std::size_t n = 0; n < all.size(); ++n) {
    const auto b = static_cast<Eigen::Index>(grid.axis(n % 3));
    const Real push = all[n].shift[b] * grid.size()[static_cast<Eigen::Index>(n % 3)] / (h_ * h_);  // in faces
    if (std::abs(push) < min_contact) continue;
    contacts_.push_back({n / 3, n % 3, push > 0, all[n]});
  }
  films_.clear();
  if (contacts_.empty()) return;
  PerThread<std::vector<int>> touched;
  touched.for_each([&](auto& of) { of.assign(sides * bodies.count(), 0); });
  for_each_row(grid.rows_of({1, grid.planes() + 1}), [&](LocalId k, LocalId r) {
    const Range cut = cuts_.cut_columns(k, r);
    for (LocalId c = cut.begin; c < std::min(cut.end, grid.columns()); ++c) {
      const std::size_t at = grid.index(k, r, c);
      if (surface.is_solid(at)) continue;
      cuts_.for_each_closed({k, r, c}, at, [&](std::size_t solid, std::size_t, bool, Real, const Vec3&) {
        if (!bodies.holds(solid)) return;
        for_each_touched(surface, {k, r, c}, solid, [&](std::size_t a, bool upper, std::size_t account) {
          int& found = touched.mine()[sides * (solid - bodies.first()) + side(a, upper)];
          found = std::max(found, static_cast<int>(account) + 1);
        });
      });
    }
  });
  touched_.assign(sides * bodies.count(), 0);
  touched.for_each([&](const auto& of) {
    for (std::size_t n = 0; n < of.size(); ++n) touched_[n] = std::max(touched_[n], of[n]);
  });
  all_reduce(comm_, touched_.data(), static_cast<int>(touched_.size()), MPI_INT, MPI_MAX);
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
  for_each_row(grid.rows_of({1, grid.planes() + 1}), [&](LocalId k, LocalId r) {
    const Range cut = cuts_.cut_columns(k, r);
    for (LocalId c = cut.begin; c < std::min(cut.end, grid.columns()); ++c) {
      const std::size_t at = grid.index(k, r, c);
      if (surface.is_solid(at)) continue;
      cuts_.for_each_closed({k, r, c}, at, [&](std::size_t solid, std::size_t, bool, Real closed, const Vec3&) {
        if (!bodies.holds(solid)) return;
        for_each_touched(surface, {k, r, c}, solid, [&](std::size_t a, bool upper, std::size_t) {
          const Box place = obstacles_.body(solid).surface_box();
          const Real z = upper ? place.max.z() : place.min.z(), low = cuts_.middle(k, r, c).z() - grid.size()[2] / 2;
          const Real phi =
              a < 2 ? forces.on_side(at) : forces.at_height(at, std::clamp((z - low) / grid.size()[2], 0.0, 1.0));
          const Vec3 sum(closed * h_, closed * phi / h_, 0);
          around_.add(sides * (solid - bodies.first()) + side(a, upper), TotalImpulse{sum, Vec3::Zero()});
        });
      });
    }
  });
  const std::vector<TotalImpulse> all = around_.total(comm_);
  films_.assign(bodies.count(), {});
  const Real particles = grid.size().prod() / (spacing * spacing * spacing);
  for (const Contact& contact : contacts_) {
    const Vec3& sum = all[sides * contact.body + side(contact.a, contact.upper)].shift;
    if (!(sum.x() > 0)) continue;
    const Real phi = sum.y() / sum.x() * h_ * h_;
    films_[contact.body] -= TotalImpulse{contact.uniform.shift * (phi * particles / (h_ * h_)),
                                         contact.uniform.moment * (phi * particles / (h_ * h_))};
  }
  return films_;
}

void ContactFilms::record() const {
  if (films_.empty() || rank_of(comm_) != 0) return;
  for (std::size_t k = 0; k < films_.size(); ++k) {
    const std::size_t body = obstacles_.floating()->first() + k;
    for (const Contact& contact : contacts_) {
      const int other = touched_[sides * k + side(contact.a, contact.upper)];
      if (contact.body == k && other > 0) {
        obstacles_.record_between(body, static_cast<std::size_t>(other - 1), films_[k]);
        break;
      }
    }
  }
}

}  // namespace trevi
