// The paths of particles among obstacles: Obstacles::predict() and Obstacles::collide().
#include <algorithm>

#include "fluid/obstacles/obstacles.hpp"

namespace trevi {

namespace {

constexpr std::size_t nobody = static_cast<std::size_t>(-1);

}  // namespace

// A straight piece of a particle's way, as each obstacle sees it from its own frame.
struct Obstacles::Leg {
  struct View {
    Vec3 from, to;
  };
  struct Contact {
    std::size_t body = nobody;
    Real part = 1;  // of the leg
  };
  const std::vector<std::unique_ptr<Body>>& bodies;
  std::vector<View> views{};

  Contact first_contact() const {
    Contact first;
    for (std::size_t k = 0; k < views.size(); ++k) {
      if (!bodies[k]->may_meet(views[k].from, views[k].to)) continue;
      const auto part = bodies[k]->first_contact(views[k].from, views[k].to);
      if (part && *part < first.part) first = {k, *part};
    }
    return first;
  }
  /// Goes this part of the leg.
  void go(Real part) {
    for (View& view : views) view.from += part * (view.to - view.from);
  }
  void aim(const Vec3& target) {
    for (std::size_t k = 0; k < views.size(); ++k) views[k].to = bodies[k]->now().into_body(target);
  }
};

// Where only the ends of a leg are known in the world, the walls are met on the straight line between them.
Vec3 Obstacles::predict(const Vec3& p, const Vec3& v, Real dt) {
  const Vec3 straight = p + v * dt;
  if (!straight.allFinite()) return straight;  // the guard of the run reports it
  const bool bounces = !walls_.inside(straight);
  bool met = false;
  for (const auto& body : bodies_) {
    const Vec3 from = body->before().into_body(p), to = body->now().into_body(straight);
    met =
        met || (bounces ? body->may_meet(from, (straight - p).norm() + (to - from).norm()) : body->may_meet(from, to));
  }
  if (met) return among(p, v, dt);
  if (!bounces) return straight;
  const Vec3 end = walls_.predict(p, v, dt);
  take(box_taker(), end - straight, end);
  return end;
}

Vec3 Obstacles::among(const Vec3& p, const Vec3& v, Real dt) {
  const Vec3 straight = p + v * dt;
  Vec3 here = p;
  Leg leg{bodies_};
  for (const auto& body : bodies_) leg.views.push_back({body->outside(body->before().into_body(p)), straight});
  leg.aim(straight);
  std::size_t last_met = 0;
  Vec3 velocity = v, target = straight;
  Real left = dt;
  constexpr int most_bounces = 16;  // the rest of the motion is then dropped
  for (int bounce = 0; bounce < most_bounces && left > 1e-9 * dt; ++bounce) {
    const WallHit wall = walls_.first_hit(here, velocity, left);
    const Leg::Contact contact = leg.first_contact();
    const bool at_wall = wall.axis >= 0 && wall.t <= contact.part * left;
    if (!at_wall && contact.body == nobody) return walls_.clamp(target);
    const Real part = at_wall ? std::clamp(wall.t / left, 0.0, 1.0) : contact.part;
    const Vec3 last = target;
    here += part * (target - here);
    const Real whole = left;
    left *= 1 - part;
    std::size_t taker = box_taker();
    if (at_wall) {
      leg.go(part);
      walls_.bounce(wall, here, velocity);
      target = here + velocity * left;
    } else {
      taker = last_met = contact.body;
      Leg::View& view = leg.views[contact.body];
      const Body& body = *bodies_[contact.body];
      const Vec3 relative = (view.to - view.from) / whole;  // the velocity in the frame of the body
      leg.go(part);
      const Vec3 away = body.reflected(relative, view.from);
      view.from = body.lifted(view.from);
      target = body.now().into_world(view.from + away * left);
      velocity = (target - here) / std::max(left, 1e-300);
    }
    leg.aim(target);
    take(taker, target - last, here);
  }
  // Stays where it met something last, and goes with it.
  const Vec3 stop = walls_.clamp(bodies_[last_met]->now().into_world(leg.views[last_met].from));
  take(last_met, stop - target, stop);
  return stop;
}

// At a contact the rest of the shift goes on along the surface; what it meets after that ends it.
Vec3 Obstacles::collide(const Vec3& p, const Vec3& shift) {
  Vec3 here = p, target = walls_.collide(p, shift);
  if (!target.allFinite()) return target;
  if (target != p + shift) take(box_taker(), target - (p + shift), target);
  bool met = false;
  for (const auto& body : bodies_) met = met || body->may_meet(body->now().into_body(p), body->now().into_body(target));
  if (!met) return target;
  Leg leg{bodies_};
  for (const auto& body : bodies_) leg.views.push_back({body->now().into_body(p), target});
  leg.aim(target);
  constexpr int most_contacts = 4;
  for (int k = 0; k < most_contacts; ++k) {
    const Leg::Contact contact = leg.first_contact();
    if (contact.body == nobody) return target;
    const auto& [from, to] = leg.views[contact.body];
    const Body& body = *bodies_[contact.body];
    const Vec3 last = target, place = from + contact.part * (to - from);
    here += contact.part * (target - here);
    const Vec3 rest = k + 1 < most_contacts ? body.along(to - place, place) : Vec3::Zero();
    target = walls_.clamp(k + 1 < most_contacts ? body.now().into_world(place + rest) : here);
    leg.go(contact.part);
    leg.aim(target);
    take(contact.body, target - last, here);
  }
  return target;
}

}  // namespace trevi
