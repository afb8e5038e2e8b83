#include "boundary/rigid_bodies/contacts.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "boundary/geometry/surface_points.hpp"

namespace trevi {

namespace {

constexpr std::size_t nearest_points = 8, spread_points = 8;  // of a pair of solids
constexpr int rounds = 200;
constexpr Real settled = 1e-9;   // of all impulses, when a round changes no more
constexpr Real slack = 0.1;      // spacings: what is nearer is examined, however slow
constexpr Real push_out = 0.25;  // of an overlap, in a substep

bool is_convex(const ObstacleSettings& solid) {
  using enum ShapeKind;
  return !solid.inside &&
         (solid.shape == sphere || solid.shape == box || solid.shape == cylinder || solid.shape == capsule);
}

Vec3 tangent_of(const Vec3& normal) {
  Eigen::Index least = 0;
  normal.cwiseAbs().minCoeff(&least);
  const Vec3 across = normal.cross(Vec3(Vec3::Unit(least)));
  return across / across.norm();
}

}  // namespace

Contacts::Round::Round(const ObstacleSettings& solid) : kind(solid.shape) {
  if (kind == ShapeKind::sphere || kind == ShapeKind::cylinder || kind == ShapeKind::capsule) radius = solid.radius;
  if (kind == ShapeKind::torus) radius = solid.tube;
  if (kind == ShapeKind::capsule) middle = std::max(solid.height / 2 - solid.radius, 0.0);
  if (kind == ShapeKind::torus) middle = solid.radius;
}

Vec3 Contacts::Round::middle_of(const Vec3& p) const {
  if (kind == ShapeKind::capsule) return {0, 0, std::clamp(p.z(), -middle, middle)};
  if (kind == ShapeKind::cylinder) return {0, 0, p.z()};
  const Real along = std::sqrt(p.x() * p.x() + p.y() * p.y());
  return kind == ShapeKind::torus && along > 0 ? Vec3(middle / along * p.x(), middle / along * p.y(), 0) : Vec3::Zero();
}

Vec3 Contacts::Round::nearest(const Vec3& p, const Vec3& normal) const {
  constexpr Real flat = 0.3;  // a cylinder that stands does so on all of its edge
  const Vec3 across(normal.x(), normal.y(), is_side() ? 0 : normal.z());
  const Real length = across.norm();
  return length > flat ? Vec3(middle_of(p) - radius / length * across) : p;
}

Contacts::Contacts(const Settings& settings, const std::vector<std::unique_ptr<Body>>& all)
    : all_(&all),
      first_(settings.obstacles.size()),
      box_(settings.domain),
      spacing_(settings.fluid.spacing),
      gravity_(settings.gravity.value_or(Vec3::Zero()).norm()),
      wall_restitution_(settings.walls.restitution) {
  const auto note = [&](const ObstacleSettings& one) {
    surface_.emplace_back(one.restitution.value_or(settings.walls.restitution), one.friction);
    is_convex_.push_back(is_convex(one));
    is_ball_.push_back(is_ball_.size() >= first_ && one.shape == ShapeKind::sphere);
  };
  for (const ObstacleSettings& one : settings.obstacles) note(one);
  constexpr Real parts = 24;  // of a large body
  for (const BodySettings& one : settings.bodies) {
    note(one);
    const Shape& shape = all[first_ + points_.size()]->shape();
    const Real size = (shape.bounds().max - shape.bounds().min).maxCoeff();
    points_.push_back(points_of(shape.surface(spacing_ / 50), std::max(spacing_, size / parts)));
    round_.emplace_back(one);
    middles_.emplace_back();
    for (const Vec3& p : points_.back()) middles_.back().push_back(round_.back().middle_of(p));
    keep_one_of_each(middles_.back(), 1e-6 * size);
    note_walls_reached_through(one);
  }
  find_edges(settings);
}

namespace {

Real gap_to(const Box& box, int axis, int side, const Vec3& p) {
  return side < 0 ? p[axis] - box.min[axis] : box.max[axis] - p[axis];
}

}  // namespace

// A body that initially extends beyond a wall, along an axis along which it is not free, has its bearing there: if it
// were pushed out of the wall, an overlap that cannot be removed would turn it. In two dimensions there are no walls
// along y.
void Contacts::note_walls_reached_through(const BodySettings& body) {
  const Pose start = BodyMotion(body).at(0);
  constexpr Real rounding = 1e-9;  // spacings
  auto& goes_through = goes_through_.emplace_back();
  for (int a = 0; a < 3; ++a)
    for (const int side : {-1, 1})
      goes_through[static_cast<std::size_t>(a)][side < 0 ? 0 : 1] =
          (body.extruded && a == 1) || std::any_of(points_.back().begin(), points_.back().end(), [&](const Vec3& p) {
            return gap_to(box_, a, side, start.into_world(p)) < -rounding * spacing_;
          });
}

// For bodies that are not round. An obstacle that initially extends into a body is its bearing.
void Contacts::find_edges(const Settings& settings) {
  constexpr Real around = 0.1;  // spacings
  edges_.resize(first_);
  if (std::all_of(round_.begin(), round_.end(), [](const Round& round) { return round.radius > 0; })) return;
  for (std::size_t n = 0; n < first_; ++n) {
    const Shape& shape = (*all_)[n]->shape();
    const Pose there = BodyMotion(settings.obstacles[n]).at(0);
    edges_[n] = edges_of(shape, shape.surface(around * spacing_ / 10), around * spacing_, spacing_);
    std::erase_if(edges_[n], [&](const Vec3& p) {
      for (std::size_t k = 0; k < settings.bodies.size(); ++k) {
        const Pose start = BodyMotion(settings.bodies[k]).at(0);
        if ((*all_)[first_ + k]->shape().distance(start.into_body(there.into_world(p))) < -slack * spacing_)
          return true;
      }
      return false;
    });
  }
}

void Contacts::find(const std::vector<RigidBody>& bodies, Real dt) {
  dt_ = dt;
  contacts_.clear();
  poses_.clear();
  ends_.clear();
  for (std::size_t k = 0; k < first_; ++k) {
    poses_.push_back((*all_)[k]->before());
    ends_.push_back((*all_)[k]->now());
  }
  for (const RigidBody& body : bodies) {
    poses_.push_back(body.pose());
    ends_.push_back(body.end_pose());
  }
  for (std::size_t k = 0; k < bodies.size(); ++k) {
    find_walls(bodies, k);
    for (std::size_t other = 0; other < first_ + bodies.size(); ++other)
      if (other != first_ + k) find_solid(bodies, k, other);
  }
}

namespace {

// The largest distance that any point of the body may move in a substep.
Real reach_of(const RigidBody& body, Real radius, Real dt) {
  return (along_of(body.twist()).norm() + about_of(body.twist()).norm() * radius) * dt;
}

}  // namespace

void Contacts::find_walls(const std::vector<RigidBody>& bodies, std::size_t k) {
  const Real radius = (*all_)[first_ + k]->radius();
  const Real margin = 2 * reach_of(bodies[k], radius, dt_) + slack * spacing_;
  const Pose& pose = poses_[first_ + k];
  for (int a = 0; a < 3; ++a) {
    for (const int side : {-1, 1}) {
      const auto gap_of = [&](const Vec3& p) { return gap_to(box_, a, side, p); };
      if (goes_through_[k][static_cast<std::size_t>(a)][side < 0 ? 0 : 1]) continue;
      if (gap_of(pose.center) - radius > margin) continue;
      const Vec3 normal = -side * Vec3::Unit(a);
      std::vector<Near> near = near_points(k, true, margin, gap_of, [&](const Vec3&) { return normal; });
      add(bodies, k, nobody, near,
          {std::min(surface_[first_ + k].first, wall_restitution_), surface_[first_ + k].second});
    }
  }
}

// The points of body k nearer than `margin` to something; of a round part, its nearest point. A convex solid has one
// such point for each ball. The normal is taken at a point inside the round part: on an edge, or just inside, the
// normal of the solid is that of a face, which would make a frictionless ball spin.
template <class Gap, class Normal>
std::vector<Contacts::Near> Contacts::near_points(std::size_t k, bool convex, Real margin, const Gap& gap_of,
                                                  const Normal& normal_at) const {
  const Pose& pose = poses_[first_ + k];
  const Round& round = round_[k];
  std::vector<Near> near;
  const auto note = [&](Real gap, const Vec3& p, const Vec3& normal) {
    near.push_back({gap, p, normal, Vec3::Zero()});
  };
  if (convex && round.radius > 0 && !round.is_side()) {
    for (const Vec3& middle : middles_[k]) {
      const Vec3 m = pose.into_world(middle);
      const Real gap = gap_of(m) - round.radius;
      if (gap >= margin) continue;
      const Vec3 normal = normal_at(m);
      note(gap, m - round.radius * normal, normal);
    }
    return near;
  }
  for (const Vec3& point : points_[k]) {
    const Vec3 p = pose.into_world(point);
    const Real gap = gap_of(p);
    if (gap >= margin) continue;
    if (round.radius == 0) {
      note(gap, p, normal_at(p));
      continue;
    }
    const Vec3 normal = normal_at((p + pose.into_world(round.middle_of(point))) / 2);
    const Vec3 q = pose.into_world(round.nearest(point, pose.turn.transpose() * normal));
    const Real gap_there = gap_of(q);
    const Vec3& nearest = gap_there <= gap ? q : p;
    const bool is_there = std::any_of(near.begin(), near.end(), [&](const Near& one) {
      return (one.p - nearest).squaredNorm() < 1e-8 * spacing_ * spacing_;
    });
    if (!is_there) note(std::min(gap, gap_there), nearest, normal);
  }
  return near;
}

// Edges of an obstacle near a body, between the points of the body's own surface, such as the top of a thin wall on
// which a box falls. Round bodies find edges by themselves.
void Contacts::append_edges(std::size_t k, std::size_t obstacle, Real margin, std::vector<Near>& near) const {
  if (round_[k].radius > 0) return;
  const Body& own = *(*all_)[first_ + k];
  const Pose &pose = poses_[first_ + k], &there = poses_[obstacle];
  const Real reach = own.radius() + margin;
  for (const Vec3& point : edges_[obstacle]) {
    const Vec3 p = there.into_world(point);
    if ((p - pose.center).squaredNorm() > reach * reach) continue;
    const Vec3 in_body = pose.into_body(p);
    const Real gap = own.shape().distance_within(in_body, margin);
    if (gap < margin) near.push_back({gap, p, pose.turn * -own.shape().normal(in_body), Vec3::Zero()});
  }
}

// Points of body k near another solid. A ball finds every convex solid, which need not find the ball.
void Contacts::find_solid(const std::vector<RigidBody>& bodies, std::size_t k, std::size_t solid) {
  if (is_ball_[solid] && (is_ball_[first_ + k] ? solid < first_ + k : is_convex_[first_ + k])) return;
  const Body &own = *(*all_)[first_ + k], &other = *(*all_)[solid];
  const Pose &pose = poses_[first_ + k], &there = poses_[solid];
  Real reach = reach_of(bodies[k], own.radius(), dt_);
  if (solid >= first_) reach += reach_of(bodies[solid - first_], other.radius(), dt_);
  if (other.moves() && solid < first_) reach += other.motion().fastest(0, dt_, other.radius()) * dt_;
  const Real margin = 2 * reach + slack * spacing_;
  if (other.shape().distance_within(there.into_body(pose.center), own.radius() + margin) >= own.radius() + margin)
    return;
  const Real within = margin + round_[k].radius;
  std::vector<Near> near = near_points(
      k, is_convex_[solid], margin,
      [&](const Vec3& p) { return other.shape().distance_within(there.into_body(p), within); },
      [&](const Vec3& p) { return Vec3(there.turn * other.shape().normal(there.into_body(p))); });
  if (solid < first_) {
    append_edges(k, solid, margin, near);
    for (Near& one : near) one.surface = (ends_[solid].into_world(there.into_body(one.p)) - one.p) / dt_;
  }
  const auto& [e, mu] = surface_[first_ + k];
  const auto& [e_other, mu_other] = surface_[solid];
  add(bodies, k, solid < first_ ? nobody : solid - first_, near, {std::min(e, e_other), std::max(mu, mu_other)});
}

// Keeps the nearest points, and of the others those that are furthest apart: a face on a floor stands on all of its
// corners.
void Contacts::keep_few(std::vector<Near>& near) {
  std::stable_sort(near.begin(), near.end(), [](const Near& a, const Near& b) { return a.gap < b.gap; });
  std::vector<Real> apart(near.size(), 1e300);
  for (std::size_t n = 0; n < std::min(near.size(), nearest_points + spread_points); ++n) {
    if (n >= nearest_points) {
      const auto next = std::max_element(apart.begin() + static_cast<std::ptrdiff_t>(n), apart.end()) - apart.begin();
      std::swap(near[n], near[static_cast<std::size_t>(next)]);
      std::swap(apart[n], apart[static_cast<std::size_t>(next)]);
    }
    for (std::size_t m = n + 1; m < near.size(); ++m)
      apart[m] = std::min(apart[m], (near[m].p - near[n].p).squaredNorm());
  }
  near.resize(std::min(near.size(), nearest_points + spread_points));
}

// The separation speed at the end of a substep that began at a distance with the approach speed v, after a bounce on
// the way, under the acceleration a. Bodies then rise as high as if they had bounced when they met, although they have
// moved at this speed all the time. With only the speed v times the restitution, a ball would rise by v dt more and
// gain energy.
Real Contacts::rebound(Real restitution, Real v, Real a, Real distance) const {
  const Real lost = a * dt_, fall = 2 * a * distance;
  return std::sqrt(std::max(lost * lost + restitution * restitution * (v * v + fall) - fall, 0.0)) - lost;
}

// Adds the contacts, each with the motion that it requires of the bodies.
void Contacts::add(const std::vector<RigidBody>& bodies, std::size_t k, std::size_t other, std::vector<Near>& near,
                   const std::pair<Real, Real>& restitution_and_friction) {
  keep_few(near);
  for (const Near& one : near) {
    Contact contact{k, other, {}, {}, {}, 0, restitution_and_friction.second, {}, {}, {}, {}};
    const Vec3 tangent = tangent_of(one.normal);
    const std::array<Vec3, 3> directions{one.normal, tangent, one.normal.cross(tangent)};
    for (std::size_t i = 0; i < 3; ++i) {
      const Vec3& d = directions[i];
      contact.arm[i] = six_of(d, (one.p - bodies[k].state().position).cross(d));
      contact.surface[i] = one.surface.dot(d);
      if (other != nobody) contact.against[i] = six_of(d, (one.p - bodies[other].state().position).cross(d));
    }
    const auto approach_of = [&](const auto& twist_of) {
      const Real own = contact.surface[0] - dot(contact.arm[0], twist_of(bodies[k]));
      return other == nobody ? own : own + dot(contact.against[0], twist_of(bodies[other]));
    };
    const Real approach =
        approach_of([](const RigidBody& body) { return six_of(body.state().velocity, body.state().angular_velocity); });
    const Real later = approach_of([](const RigidBody& body) { return body.twist(); });
    contact.least = one.gap > 0 ? -one.gap / dt_ : -push_out * one.gap / dt_;
    const bool bounces = approach > 4 * gravity_ * dt_ && std::max(approach, later) * dt_ > one.gap;
    if (bounces)
      contact.least = std::max(contact.least, rebound(restitution_and_friction.first, approach,
                                                      std::max(later - approach, 0.0) / dt_, std::max(one.gap, 0.0)));
    contacts_.push_back(contact);
  }
}

// Velocity of the contact point away from the other solid, m/s.
Real Contacts::velocity_of(const Contact& contact, std::size_t along, const std::vector<Six>& twists) {
  const Real velocity = dot(contact.arm[along], twists[contact.body]) - contact.surface[along];
  return contact.other == nobody ? velocity : velocity - dot(contact.against[along], twists[contact.other]);
}

Real Contacts::set_impulse(Contact& contact, std::size_t along, Real total, std::vector<Six>& twists) {
  const Real step = total - contact.impulse[along];
  contact.impulse[along] = total;
  Six& own = twists[contact.body];
  own = plus(own, contact.answer[along], step);
  if (contact.other != nobody) {
    Six& other = twists[contact.other];
    other = plus(other, contact.answer_other[along], -step);
  }
  return step;
}

// Gives the impulse with which the bodies separate as fast as they must.
Real Contacts::push(Contact& contact, std::vector<Six>& twists) {
  if (contact.mobility[0] <= 0) return 0;
  const Real more = (contact.least - velocity_of(contact, 0, twists)) / contact.mobility[0];
  return set_impulse(contact, 0, std::max(contact.impulse[0] + more, 0.0), twists);
}

// Gives the impulse with which the contact sticks, within Coulomb's cone. Sliding is braked opposite to its direction,
// because both tangents take the same fraction of the velocity.
std::array<Real, 2> Contacts::brake(Contact& contact, std::vector<Six>& twists) {
  const Real mobility = std::max(contact.mobility[1], contact.mobility[2]);
  if (contact.friction == 0 || mobility <= 0) return {};
  std::array<Real, 2> total{};
  for (const std::size_t i : {0U, 1U})
    if (contact.mobility[i + 1] > 0) total[i] = contact.impulse[i + 1] - velocity_of(contact, i + 1, twists) / mobility;
  const Real length = std::sqrt(total[0] * total[0] + total[1] * total[1]),
             most = contact.friction * contact.impulse[0];
  const Real share = length > most ? most / length : 1;
  return {set_impulse(contact, 1, share * total[0], twists), set_impulse(contact, 2, share * total[1], twists)};
}

void Contacts::find_answers(const std::vector<RigidBody>& bodies) {
  for (Contact& contact : contacts_) {
    const RigidBody& body = bodies[contact.body];
    for (std::size_t i = 0; i < 3; ++i) {
      contact.answer[i] = solved(body.felt_inertia(), contact.arm[i], body.free());
      contact.mobility[i] = dot(contact.arm[i], contact.answer[i]);
      if (contact.other == nobody) continue;
      const RigidBody& other = bodies[contact.other];
      contact.answer_other[i] = solved(other.felt_inertia(), contact.against[i], other.free());
      contact.mobility[i] += dot(contact.against[i], contact.answer_other[i]);
    }
  }
}

void Contacts::solve(std::vector<RigidBody>& bodies) {
  if (contacts_.empty()) return;
  find_answers(bodies);
  std::vector<Six> twists, given(bodies.size());
  for (const RigidBody& body : bodies) twists.push_back(body.twist());
  for (int round = 0; round < rounds; ++round) {
    Real most = 0;
    for (Contact& contact : contacts_) {
      const Real pushed = push(contact, twists);
      const std::array<Real, 2> braked = brake(contact, twists);
      for (const auto& [along, step] : {std::pair{0U, pushed}, {1U, braked[0]}, {2U, braked[1]}}) {
        if (step == 0) continue;
        most = std::max(most, std::abs(step));
        given[contact.body] = plus(given[contact.body], contact.arm[along], step);
        if (contact.other != nobody) given[contact.other] = plus(given[contact.other], contact.against[along], -step);
        driven_work_ += step * contact.surface[along];
      }
    }
    Real all = 0;
    for (const Contact& contact : contacts_) all += contact.impulse[0];
    if (most <= settled * all) break;
  }
  for (std::size_t k = 0; k < bodies.size(); ++k) {
    if (given[k] == Six{}) continue;
    bodies[k].give(given[k]);
    bodies[k].set_twist(twists[k]);
  }
}

bool Contacts::touches(std::size_t body) const {
  return std::any_of(contacts_.begin(), contacts_.end(),
                     [&](const Contact& one) { return (one.body == body || one.other == body) && one.impulse[0] > 0; });
}

}  // namespace trevi
