#include "scene/free_places.hpp"

#include <fmt/format.h>

#include <algorithm>

namespace trevi {

FreePlaces::FreePlaces(const Scene& scene, Real time)
    : spacing_(scene.fluid.spacing), obstacles_(static_cast<int>(scene.obstacles.size())) {
  constexpr Real rounding = 1e-6;  // a lattice that fits just beside a solid stays whole
  const Real gap = (0.5 - rounding) * spacing_;
  const auto is_known = [time](const ObstacleSettings& obstacle) {  // where a paddle that absorbs is, the water says
    return time == 0 || !obstacle.wavemaker || !obstacle.wavemaker->absorb;
  };
  for (const ObstacleSettings& obstacle : scene.obstacles)
    if (is_known(obstacle)) add(obstacle, BodyMotion(obstacle).at(time), gap);
  if (time > 0) return;  // where bodies are then is not known
  for (const BodySettings& body : scene.bodies) add(body, BodyMotion(body).at(0), 0);
}

void FreePlaces::add(const ObstacleSettings& obstacle, const Pose& pose, Real gap) {
  constexpr Real edge = 2;  // of a block, in spacings
  solids_.push_back({std::make_unique<SolidTest>(make_shape(obstacle), edge * spacing_), pose, gap});
}

bool FreePlaces::is_free(const Vec3& p) const {
  return std::all_of(solids_.begin(), solids_.end(),
                     [&](const Solid& solid) { return !solid.test->is_nearer(solid.pose.into_body(p), solid.gap); });
}

std::string FreePlaces::name_of(int solid) const {
  return solid < obstacles_ ? fmt::format("obstacle {}", solid) : fmt::format("body {}", solid - obstacles_);
}

int FreePlaces::solid_at(const Vec3& p, Real depth) const {
  for (std::size_t k = 0; k < solids_.size(); ++k)
    if (solids_[k].test->is_nearer(solids_[k].pose.into_body(p), -depth)) return static_cast<int>(k);
  return -1;
}

}  // namespace trevi
