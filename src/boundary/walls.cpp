#include "boundary/walls.hpp"

namespace trevi {

Box box_of_walls(const Settings& settings) {
  constexpr Real far = 1000;  // lengths of the box, which no particle crosses in a step
  const Box& box = settings.domain;
  Box walls = box;
  for (int a = 0; a < 3; ++a) {
    if (!settings.periodic[static_cast<std::size_t>(a)] && !(settings.fluid.dimensions == 2 && a == 1)) continue;
    walls.min[a] -= far * (box.max[a] - box.min[a]);
    walls.max[a] += far * (box.max[a] - box.min[a]);
  }
  return walls;
}

Walls::Walls(const Box& box, const WallSettings& settings, Real tolerance)
    : box_(box),
      restitution_(settings.restitution),
      tolerance_(tolerance),
      along_ray_(settings.reflection == Reflection::report) {}

WallHit Walls::first_hit(const Vec3& p, const Vec3& v, Real t_end) const {
  WallHit hit{-1, t_end};
  for (int a = 0; a < 3; ++a) {
    if (v[a] == 0) continue;
    const Real t = ((v[a] > 0 ? box_.max[a] : box_.min[a]) - p[a]) / v[a];
    if (t < hit.t) hit = {a, t};
  }
  return hit;
}

void Walls::bounce(const WallHit& hit, Vec3& position, Vec3& velocity) const {
  position[hit.axis] = velocity[hit.axis] > 0 ? box_.max[hit.axis] : box_.min[hit.axis];
  velocity[hit.axis] = -velocity[hit.axis];
  if (along_ray_) {
    velocity *= restitution_;
  } else {
    velocity[hit.axis] *= restitution_;
  }
}

Vec3 Walls::predict(const Vec3& p, const Vec3& v, Real dt) const {
  const Vec3 straight = p + v * dt;
  if (inside(straight)) return straight;
  if (!v.allFinite()) return straight;  // the guard of the run reports it
  constexpr int max_bounces = 10000;    // reached only at an absurd speed; the rest of the motion is then dropped
  Vec3 position = p, velocity = v;
  for (int k = 0; k < max_bounces && dt > 0; ++k) {
    const WallHit hit = first_hit(position, velocity, dt);
    position += velocity * hit.t;
    if (hit.axis < 0) break;
    bounce(hit, position, velocity);
    dt -= hit.t;
  }
  return clamp(position);
}

Vec3 Walls::stop_on_ray(const Vec3& p, const Vec3& shift) const {
  const WallHit hit = first_hit(p, shift, 1.0);
  Vec3 position = p + hit.t * shift;
  if (hit.axis >= 0) {
    position[hit.axis] = shift[hit.axis] > 0 ? box_.max[hit.axis] - tolerance_ : box_.min[hit.axis] + tolerance_;
  }
  return clamp(position);
}

}  // namespace trevi
