#include "fluid/walls.hpp"

namespace trevi {

namespace {

// The first plane that p + t v meets: its axis (−1 for none before t_end) and the time.
struct Hit {
  int axis = -1;
  Real t = 0;
};

Hit first_hit(const Box& box, const Vec3& p, const Vec3& v, Real t_end) {
  Hit hit{-1, t_end};
  for (int a = 0; a < 3; ++a) {
    if (v[a] == 0) continue;
    const Real t = ((v[a] > 0 ? box.max[a] : box.min[a]) - p[a]) / v[a];
    if (t < hit.t) hit = {a, t};
  }
  return hit;
}

}  // namespace

Walls::Walls(const Box& box, const WallSettings& settings, Real tolerance)
    : box_(box),
      restitution_(settings.restitution),
      tolerance_(tolerance),
      along_ray_(settings.reflection == Reflection::report) {}

Vec3 Walls::predict(const Vec3& p, const Vec3& v, Real dt) const {
  const Vec3 straight = p + v * dt;
  if (inside(straight)) return straight;
  if (!v.allFinite()) return straight;  // the guard of the run reports it
  constexpr int most_bounces = 10000;   // reached only at an absurd speed; the rest of the motion is then dropped
  Vec3 position = p, velocity = v;
  for (int bounce = 0; bounce < most_bounces && dt > 0; ++bounce) {
    const Hit hit = first_hit(box_, position, velocity, dt);
    position += velocity * hit.t;
    if (hit.axis < 0) break;
    position[hit.axis] = velocity[hit.axis] > 0 ? box_.max[hit.axis] : box_.min[hit.axis];
    velocity[hit.axis] = -velocity[hit.axis];
    if (along_ray_) {
      velocity *= restitution_;
    } else {
      velocity[hit.axis] *= restitution_;
    }
    dt -= hit.t;
  }
  return clamp(position);
}

Vec3 Walls::stop_on_ray(const Vec3& p, const Vec3& shift) const {
  const Hit hit = first_hit(box_, p, shift, 1.0);
  Vec3 position = p + hit.t * shift;
  if (hit.axis >= 0) {
    position[hit.axis] = shift[hit.axis] > 0 ? box_.max[hit.axis] - tolerance_ : box_.min[hit.axis] + tolerance_;
  }
  return clamp(position);
}

}  // namespace trevi
