// The paths of particles among obstacles: Obstacles::predict() and Obstacles::collide().
#include <Eigen/Geometry>
#include <algorithm>

#include "boundary/obstacles/obstacles.hpp"

namespace trevi {

namespace {

constexpr std::size_t nobody = static_cast<std::size_t>(-1);
/// Cosine of the angle between the normals of two contacts below which they are taken to be on two different faces.
constexpr Real same_direction = 0.9;

}  // namespace

// A straight piece of a particle's path, as seen from each obstacle. What moves the particle aside moves it for all of
// them, so that they agree on its position.
struct Obstacles::Leg {
  struct Contact {
    std::size_t body = nobody;
    Real part = 1;  // of the leg
  };
  const std::vector<std::unique_ptr<Body>>& bodies;
  const Walls& walls;
  std::vector<Segment>& segments;
  std::size_t last_met = nobody;  // the body that it met last, and the normal there, in the frame of the body
  Vec3 last_normal = Vec3::Zero();
  Vec3 met_at = Vec3::Zero(),
       met_normal = Vec3::Zero();  // of that contact: position in the world, normal as before

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
  /// Moves along this part of the leg.
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
  /// Moves off the surface of a body, unless that is into another one.
  void contact_offset(std::size_t body, const Vec3& normal) {
    const Vec3 step = bodies[body]->now().turn * bodies[body]->contact_offset(normal);
    shift(step);
    if (!is_clear()) shift(-step);
  }
  /// Moves to the wall and bounces off it, in the time that remains of `left`, s. Returns the target from there on.
  Vec3 bounce_at_wall(const WallHit& wall, Real& left, Vec3& velocity) {
    const Real part = std::clamp(wall.t / left, 0.0, 1.0);
    left *= 1 - part;
    go(part);
    Vec3 on_wall = here();
    walls.bounce(wall, on_wall, velocity);
    shift(on_wall - here());
    return here() + velocity * left;
  }
  /// The same at a body, in the frame in which it is at rest. Inside a curved wall the bounces would continue for ever
  /// on shorter and shorter chords, and the rest of the path would be lost. From the second contact with it on, the
  /// wall therefore pushes along the normal of the first contact, as far as the end of the path requires. The motion
  /// along the wall is conserved, and so is the angular momentum about its axis.
  Vec3 bounce_at_body(const Contact& contact, Real& left, Vec3& velocity) {
    const Body& body = *bodies[contact.body];
    const Segment& segment = segments[contact.body];
    const Vec3 relative = (segment.to.in_body - segment.from.in_body) / left;
    left *= 1 - contact.part;
    go(contact.part);
    const Vec3 normal = body.normal(segment.from);
    const bool curved = contact.body == last_met && normal.dot(last_normal) > same_direction;
    const auto push = curved ? body.shift_inside(segment.to, last_normal, relative.norm() * left) : std::nullopt;
    met_at = here(), met_normal = normal;
    contact_offset(contact.body, normal);
    const Vec3 end =
        push ? Vec3(segment.to.in_body + *push) : Vec3(segment.from.in_body + body.reflected(relative, normal) * left);
    if (!push) last_normal = normal;
    last_met = contact.body;
    const Vec3 target = body.now().into_world(end);
    velocity = (target - here()) / std::max(left, 1e-300);
    return target;
  }
  /// Moves out of the solids that contain it: moving solids may be where a wall has stopped it.
  void leave() {
    for (std::size_t k = 0; k < segments.size(); ++k) {
      const Vec3 out = bodies[k]->exit_shift(segments[k].from);
      if (out != Vec3::Zero()) shift(bodies[k]->now().turn * out);
    }
  }
};

// Where only the ends of a leg are known in the world, the walls are met on the straight line between them.
Vec3 Obstacles::predict(Vec3& p, const Vec3& v, Real dt) {
  const Vec3 straight = p + v * dt;
  if (!straight.allFinite()) return straight;  // the guard of the run reports it
  const bool bounces = !walls_.inside(straight);
  const bool met = index_->any(bounces ? index_->all() : along(p, straight), [&](std::size_t k) {
    const Body& body = *bodies_[k];
    if (!bounces && body.is_out_of_way(p, straight)) return false;
    const Vec3 from = body.before().into_body(p), to = body.now().into_body(straight);
    return bounces ? body.may_meet(from, (straight - p).norm() + (to - from).norm()) : body.may_meet(from, to);
  });
  if (met) return among(p, v, dt);
  if (!bounces) return straight;
  const Vec3 end = walls_.predict(p, v, dt);
  record_bounce(box_account(), end - straight, end, p);
  return end;
}

// The shift acts at the point of contact, so that a ball is not turned by it, whereas the resulting velocity begins
// with the path. The difference in angular momentum is part of the remainder.
void Obstacles::record_bounce(std::size_t account, const Vec3& shift, const Vec3& p, const Vec3& start) {
  record(account, shift, p);
  if (recording_) record_rest({Vec3::Zero(), (start - p).cross(shift)});
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

Vec3 Obstacles::among(Vec3& p, const Vec3& v, Real dt) {
  Leg leg = leg_from(p, true);
  leg.leave();
  p = leg.here();
  Vec3 velocity = v, target = p + v * dt;
  leg.aim(target);
  Real left = dt;
  constexpr int max_bounces = 16;  // the rest of the motion is then dropped
  for (int bounce = 0; bounce < max_bounces && left > 1e-9 * dt; ++bounce) {
    const WallHit wall = walls_.first_hit(leg.here(), velocity, left);
    const Leg::Contact contact = leg.first_contact();
    const bool at_wall = wall.axis >= 0 && wall.t <= contact.part * left;
    if (!at_wall && contact.body == nobody) return walls_.clamp(target);
    const Vec3 last = target;
    std::size_t account = box_account();
    if (at_wall) {
      target = leg.bounce_at_wall(wall, left, velocity);
    } else {
      account = contact.body;
      const Vec3 arriving = velocity;
      target = leg.bounce_at_body(contact, left, velocity);
      const Body& body = *bodies_[contact.body];
      if (sounding_ && floating_->holds(contact.body))
        floating_->meet(contact.body, leg.met_at, body.now().turn * leg.met_normal, arriving, 1 + body.restitution());
    }
    leg.aim(target);
    record_bounce(account, target - last, leg.here(), p);
  }
  // Stays where it met something last, and moves along with an obstacle.
  const std::size_t met = leg.last_met;
  const bool by_walls = met == nobody;
  const Vec3 stop =
      walls_.clamp(by_walls ? leg.here() : bodies_[met]->now().into_world(leg.segments[met].from.in_body));
  record_bounce(by_walls ? box_account() : met, stop - target, stop, p);
  return stop;
}

// After a contact the rest of the shift continues along the surface; whatever it meets after that ends it.
Vec3 Obstacles::collide(const Vec3& p, const Vec3& shift) {
  Vec3 target = walls_.collide(p, shift);
  if (!target.allFinite()) return target;
  if (target != p + shift) record_bounce(box_account(), target - (p + shift), target, p);
  const bool meets = index_->any(along(p, target), [&](std::size_t k) {
    const Body& body = *bodies_[k];
    return !body.is_passed_by(p, target) && body.may_meet(body.now().into_body(p), body.now().into_body(target));
  });
  if (!meets) return target;
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
    record_bounce(contact.body, target - last, leg.here(), p);
  }
  return target;
}

}  // namespace trevi
