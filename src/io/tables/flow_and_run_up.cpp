#include "io/tables/flow_and_run_up.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

namespace trevi {

namespace {

// How much of a cube around `at` with edges of one spacing is between −half and half, as a fraction.
Real part_within(Real at, Real half, Real spacing) {
  const Real low = std::max(at - spacing / 2, -half), high = std::min(at + spacing / 2, half);
  return std::max(0.0, high - low) / spacing;
}

// As the edges of an inlet: the first is level, along x where the rectangle is.
Vec3 level_across(const Vec3& normal) {
  const Vec3 level = Vec3::UnitZ().cross(normal);
  return level.norm() > 1e-9 ? Vec3(level / level.norm()) : Vec3::UnitX();
}

}  // namespace

RectangleFlow::RectangleFlow(const GaugeSettings& gauge, Real spacing)
    : center_(gauge.center),
      normal_(gauge.normal),
      level_(level_across(gauge.normal)),
      across_(gauge.normal.cross(level_)),
      half_{gauge.size[0] / 2, gauge.size[1] / 2},
      spacing_(spacing) {}

Real RectangleFlow::flow(const Vec3& p, const Vec3& v) const {
  const Vec3 from = p - center_;
  const Real ahead = part_within(from.dot(normal_), spacing_, spacing_);
  if (ahead == 0) return 0;
  const Real volume = ahead * part_within(from.dot(level_), half_[0], spacing_) *
                      part_within(from.dot(across_), half_[1], spacing_) * spacing_ * spacing_ * spacing_;
  return volume * v.dot(normal_) / (2 * spacing_);
}

RunUp::RunUp(const GaugeSettings& gauge, const Settings& settings) : gauge_(gauge), spacing_(settings.fluid.spacing) {
  if (gauge.kind != GaugeKind::run_up) return;
  for (const ObstacleSettings& obstacle : settings.obstacles)
    if (!obstacle.moves()) solids_.push_back({make_shape(obstacle), BodyMotion(obstacle).at(0)});
}

bool RunUp::touches(const Vec3& p) const {
  const Vec3 from = p - gauge_.center;
  const Real along = from.dot(gauge_.normal), beside = -from.x() * gauge_.normal.y() + from.y() * gauge_.normal.x();
  if (along < 0 || std::abs(beside) > gauge_.radius) return false;
  return std::any_of(solids_.begin(), solids_.end(), [&](const Solid& solid) {
    return solid.shape->distance_within(solid.pose.into_body(p), 2 * spacing_) <= spacing_;
  });
}

}  // namespace trevi
