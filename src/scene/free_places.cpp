#include "scene/free_places.hpp"

#include <fmt/format.h>

#include <algorithm>

namespace trevi {

namespace {

constexpr Real rounding = 1e-6;  // spacings; a lattice that just fits beside a solid stays whole

// A number from 0 to 7, different for any eight consecutive places along an axis; it is below 4 at every second place,
// and below 2 at every fourth.
unsigned order_of(const Vec3& p, Real spacing) {
  constexpr Real off = 0.25;  // off the faces and the centres of cells
  const Eigen::Array3d cell = (p.array() / spacing + off).floor();
  const auto sum = static_cast<unsigned>(static_cast<std::int64_t>(cell.sum()));
  return (sum & 1) << 2 | (sum & 2) | (sum >> 2 & 1);
}

}  // namespace

FreePlaces::FreePlaces(const Scene& scene, Real time)
    : spacing_(scene.fluid.spacing), obstacles_(static_cast<int>(scene.obstacles.size())) {
  const auto is_known = [time](const ObstacleSettings& obstacle) {  // the water moves an absorbing paddle
    return time == 0 || !obstacle.wavemaker || !obstacle.wavemaker->absorb;
  };
  int number = 0;
  for (const ObstacleSettings& obstacle : scene.obstacles) {
    if (is_known(obstacle)) add(number, obstacle, BodyMotion(obstacle).at(time));
    ++number;
  }
  if (time > 0) return;  // where bodies are then is not known
  for (const BodySettings& body : scene.bodies) add(number++, body, BodyMotion(body).at(0));
}

void FreePlaces::add(int number, const ObstacleSettings& solid, const Pose& pose) {
  constexpr Real edge = 2;  // of a block, in spacings
  solids_.push_back({number, std::make_unique<SolidTest>(make_shape(solid), edge * spacing_), pose});
}

bool FreePlaces::is_free(const Vec3& p) const {
  return std::none_of(solids_.begin(), solids_.end(), [&](const Solid& solid) { return displaces(solid, p); });
}

bool FreePlaces::is_nearer(const Solid& solid, const Vec3& p, Real gap) const {
  return solid.test->is_nearer(solid.pose.into_body(p), gap);
}

// Of places on its surface it takes the fraction that the solid fills of the space around them, half of those on a
// face: a solid whose faces are planes of the lattice thus displaces its volume, too.
bool FreePlaces::displaces(const Solid& solid, const Vec3& p) const {
  if (is_nearer(solid, p, -rounding * spacing_)) return true;
  if (!is_nearer(solid, p, rounding * spacing_)) return false;
  unsigned inside = 0;
  for (int k = 0; k < 8; ++k) {
    const Vec3 to_corner = spacing_ / 4 * Vec3(k % 2 * 2 - 1, k / 2 % 2 * 2 - 1, k / 4 * 2 - 1);
    inside += is_nearer(solid, p + to_corner, 0) ? 1U : 0U;
  }
  return order_of(p, spacing_) < inside;
}

std::string FreePlaces::name_of(int solid) const {
  return is_body(solid) ? fmt::format("body {}", solid - obstacles_) : fmt::format("obstacle {}", solid);
}

int FreePlaces::solid_at(const Vec3& p, Real depth) const {
  for (const Solid& solid : solids_)
    if (is_nearer(solid, p, -depth)) return solid.number;
  return -1;
}

}  // namespace trevi
