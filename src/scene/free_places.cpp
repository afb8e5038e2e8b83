#include "scene/free_places.hpp"

#include <fmt/format.h>

#include <algorithm>

namespace trevi {

FreePlaces::FreePlaces(const Scene& scene, Real time) : obstacles_(static_cast<int>(scene.obstacles.size())) {
  constexpr Real rounding = 1e-6;  // a lattice that fits just beside a solid stays whole
  const Real gap = (0.5 - rounding) * scene.fluid.spacing;
  const auto is_known = [time](const ObstacleSettings& obstacle) {  // where a paddle that absorbs is, the water says
    return time == 0 || !obstacle.wavemaker || !obstacle.wavemaker->absorb;
  };
  for (const ObstacleSettings& obstacle : scene.obstacles)
    if (is_known(obstacle)) solids_.push_back({make_shape(obstacle), BodyMotion(obstacle).at(time), gap});
  if (time > 0) return;  // where bodies are then is not known
  for (const BodySettings& body : scene.bodies) solids_.push_back({make_shape(body), BodyMotion(body).at(0), 0});
}

bool FreePlaces::is_free(const Vec3& p) const {
  return std::all_of(solids_.begin(), solids_.end(),
                     [&](const Solid& solid) { return solid.shape->distance(solid.pose.into_body(p)) >= solid.gap; });
}

std::string FreePlaces::name_of(int solid) const {
  return solid < obstacles_ ? fmt::format("obstacle {}", solid) : fmt::format("body {}", solid - obstacles_);
}

int FreePlaces::solid_at(const Vec3& p, Real depth) const {
  for (std::size_t k = 0; k < solids_.size(); ++k)
    if (solids_[k].shape->distance(solids_[k].pose.into_body(p)) < -depth) return static_cast<int>(k);
  return -1;
}

}  // namespace trevi
