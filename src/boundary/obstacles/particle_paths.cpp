// The paths of particles among obstacles: Obstacles::predict() and Obstacles::collide().
#include <algorithm>

#include "boundary/obstacles/obstacles.hpp"

namespace trevi {

namespace {

constexpr std::size_t nobody = static_cast<std::size_t>(-1);

}  // namespace

// A straight piece of a particle's path, as each obstacle sees it. What moves the particle aside moves it for all of
// them, so that no two disagree about where it is.
struct Obstacles::Leg {
  struct Contact {
    std::size_t body = nobody;
    Real part = 1;  // of the leg
  };
  const std::vector<std::unique_ptr<Body>>& bodies;
  const Walls& walls;
  std::vector<Segment>& segments;

  const Vec3& here() const { return segments.front().from.in_world; }
  Contact first_contact() const {
    Contact first;
    for (std::size_t k = 0; k < segments.size(); ++k) {
      if (!bodies[k]->may_meet(segments[k].from.in_body, segments[k].to.in_body)) continue;
      const auto part = bodies[k]->first_contact(segments[k]);
      if (part && *part < first.part) first = {k, *part};
    }
    return first;
  }
  /// Goes this part of the leg.
  void go(Real part) {
    for (Segment& segment : segments) segment.from = segment.at(part);
  }
  void aim(const Vec3& target) {
    for (std::size_t k = 0; k < segments.size(); ++k) segments[k].to = {bodies[k]->now().into_body(target), target};
  }
  /// Shifts the start of the leg, within the box.
  void shift(const Vec3& segment) {
    const Vec3 there = walls.clamp(here() + segment), step = there - here();
    for (std::size_t k = 0; k < segments.size(); ++k) {
      segments[k].from.in_body += bodies[k]->now().turn.transpose() * step;
      segments[k].from.in_world = there;
    }
  }
  bool is_clear() const {
    for (std::size_t k = 0; k < segments.size(); ++k)
      if (!bodies[k]->is_clear(segments[k].from)) return false;
    return true;
  }
  /// Off the surface of a body, unless that is into another one.
  void contact_offset(std::size_t body, const Vec3& normal) {
    const Vec3 step = bodies[body]->now().turn * bodies[body]->contact_offset(normal);
    shift(step);
    if (!is_clear()) shift(-step);
  }
  /// Out of the solids that it is in, as those that move may be where a wall has stopped it.
  void leave() {
    for (std::size_t k = 0; k < segments.size(); ++k) {
      const Vec3 out = bodies[k]->exit_shift(segments[k].from);
      if (out != Vec3::Zero()) shift(bodies[k]->now().turn * out);
    }
  }
};

// Where only the ends of a leg are known in the world, the walls are met on the straight line between them.
Vec3 Obstacles::predict_among(const Vec3& p, const Vec3& v, Real dt) {
  const Vec3 straight = p + v * dt;
  if (!straight.allFinite()) return straight;  // the guard of the run reports it
  const bool bounces = !walls_.inside(straight);
  bool met = false;
  for (const auto& body : bodies_) {
    if (!bounces && body->is_out_of_way(p, straight)) continue;
    const Vec3 from = body->before().into_body(p), to = body->now().into_body(straight);
    met =
        met || (bounces ? body->may_meet(from, (straight - p).norm() + (to - from).norm()) : body->may_meet(from, to));
  }
  if (met) return among(p, v, dt);
  if (!bounces) return straight;
  const Vec3 end = walls_.predict(p, v, dt);
  record(box_account(), end - straight, end);
  return end;
}

Obstacles::Leg Obstacles::leg_from(const Vec3& p, bool before) {
  std::vector<Segment>& segments = segments_.mine();
  segments.clear();
  for (const auto& body : bodies_) {
    const ContactPoint from{(before ? body->before() : body->now()).into_body(p), p};
    segments.push_back({from, from});
  }
  return {bodies_, walls_, segments};
}

Vec3 Obstacles::among(const Vec3& p, const Vec3& v, Real dt) {
  Leg leg = leg_from(p, true);
  leg.leave();
  Vec3 velocity = v, target = p + v * dt;
  leg.aim(target);
  std::size_t last_met = nobody;
  Real left = dt;
  constexpr int max_bounces = 16;  // the rest of the motion is then dropped
  for (int bounce = 0; bounce < max_bounces && left > 1e-9 * dt; ++bounce) {
    const WallHit wall = walls_.first_hit(leg.here(), velocity, left);
    const Leg::Contact contact = leg.first_contact();
    const bool at_wall = wall.axis >= 0 && wall.t <= contact.part * left;
    if (!at_wall && contact.body == nobody) return walls_.clamp(target);
    const Vec3 last = target;
    const Real whole = left;
    std::size_t account = box_account();
    if (at_wall) {
      const Real part = std::clamp(wall.t / left, 0.0, 1.0);
      left *= 1 - part;
      leg.go(part);
      Vec3 on_wall = leg.here();
      walls_.bounce(wall, on_wall, velocity);
      leg.shift(on_wall - leg.here());
      target = leg.here() + velocity * left;
    } else {
      account = last_met = contact.body;
      const Body& body = *bodies_[contact.body];
      const Segment& segment = leg.segments[contact.body];
      const Vec3 relative =
          (segment.to.in_body - segment.from.in_body) / whole;  // the velocity in the frame of the body
      left *= 1 - contact.part;
      leg.go(contact.part);
      const Vec3 normal = body.normal(segment.from), away = body.reflected(relative, normal);
      if (sounding_ && floating_->holds(contact.body))
        floating_->meet(contact.body, leg.here(), body.now().turn * normal, velocity, 1 + body.restitution());
      leg.contact_offset(contact.body, normal);
      target = body.now().into_world(segment.from.in_body + away * left);
      velocity = (target - leg.here()) / std::max(left, 1e-300);
    }
    leg.aim(target);
    record(account, target - last, leg.here());
  }
  // Stays where it met something last, and goes with an obstacle.
  const bool by_walls = last_met == nobody;
  const Vec3 stop =
      walls_.clamp(by_walls ? leg.here() : bodies_[last_met]->now().into_world(leg.segments[last_met].from.in_body));
  record(by_walls ? box_account() : last_met, stop - target, stop);
  return stop;
}

// At a contact the rest of the shift goes on along the surface; what it meets after that ends it.
Vec3 Obstacles::collide(const Vec3& p, const Vec3& shift) {
  Vec3 target = walls_.collide(p, shift);
  if (!target.allFinite()) return target;
  if (target != p + shift) record(box_account(), target - (p + shift), target);
  bool met = false;
  for (const auto& body : bodies_)
    met = met ||
          (!body->is_passed_by(p, target) && body->may_meet(body->now().into_body(p), body->now().into_body(target)));
  if (!met) return target;
  Leg leg = leg_from(p, false);
  leg.aim(target);
  constexpr int max_contacts = 4;
  for (int k = 0; k < max_contacts; ++k) {
    const Leg::Contact contact = leg.first_contact();
    if (contact.body == nobody) return target;
    const Body& body = *bodies_[contact.body];
    const Segment& segment = leg.segments[contact.body];
    const Vec3 last = target, rest = (1 - contact.part) * (segment.to.in_body - segment.from.in_body);
    leg.go(contact.part);
    target = leg.here();
    if (k + 1 < max_contacts) {
      const Vec3 normal = body.normal(segment.from);
      leg.contact_offset(contact.body, normal);
      target = walls_.clamp(body.now().into_world(segment.from.in_body + Body::along(rest, normal)));
    }
    leg.aim(target);
    record(contact.body, target - last, leg.here());
  }
  return target;
}

}  // namespace trevi
