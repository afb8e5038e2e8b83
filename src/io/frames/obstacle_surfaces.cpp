#include "io/frames/obstacle_surfaces.hpp"

#include <algorithm>
#include <utility>

#include "boundary/geometry/mass_properties.hpp"
#include "boundary/geometry/shape.hpp"
#include "boundary/rigid_bodies/rigid_body.hpp"

namespace trevi {

ObstacleSurfaces::ObstacleSurfaces(const std::vector<ObstacleSettings>& obstacles, Real finest, std::size_t bodies)
    : bodies_(bodies) {
  for (const ObstacleSettings& obstacle : obstacles) {
    TriangleMesh mesh = make_shape(obstacle)->surface(finest);
    if (obstacle.inside) {
      for (auto& corners : mesh.triangles) std::swap(corners[1], corners[2]);
    }
    const bool floats = all_.size() + bodies >= obstacles.size();
    all_.push_back({BodyMotion(obstacle), std::move(mesh), floats || obstacle.moves(),
                    floats ? mass_properties(obstacle).center : Vec3::Zero()});
  }
}

std::size_t ObstacleSurfaces::count(bool moves) const {
  return static_cast<std::size_t>(
      std::count_if(all_.begin(), all_.end(), [&](const One& one) { return one.moves == moves; }));
}

ObstacleSurface ObstacleSurfaces::placed(bool moves, Real time, std::span<const BodyState> bodies) const {
  ObstacleSurface surface;
  for (std::size_t k = 0; k < all_.size(); ++k) {
    if (all_[k].moves != moves) continue;
    Pose pose = all_[k].motion.at(time);
    const std::size_t body = k + bodies_ - all_.size();  // beyond their number if it is not a body
    if (body < bodies.size()) {
      pose.turn = rotation_of(bodies[body].orientation);
      pose.center = bodies[body].position - pose.turn * all_[k].center_of_mass;
    }
    const auto first = static_cast<std::int32_t>(surface.mesh.points.size());
    for (const Vec3& p : all_[k].mesh.points) surface.mesh.points.push_back(pose.into_world(p));
    for (const auto& [a, b, c] : all_[k].mesh.triangles) {
      surface.mesh.triangles.push_back({a + first, b + first, c + first});
      surface.obstacle.push_back(static_cast<std::int32_t>(k));
    }
  }
  return surface;
}

}  // namespace trevi
