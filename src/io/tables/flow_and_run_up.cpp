#include "io/tables/flow_and_run_up.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

namespace trevi {

namespace {

// The fraction of a cube around `at`, with edges of one spacing, that is between −half and half.
Real part_within(Real at, Real half, Real spacing) {
  const Real low = std::max(at - spacing / 2, -half), high = std::min(at + spacing / 2, half);
  return std::max(0.0, high - low) / spacing;
}

// Like the edges of an inlet: the first is horizontal, along x if the rectangle is.
Vec3 level_across(const Vec3& normal) {
  const Vec3 level = Vec3::UnitZ().cross(normal);
  return level.norm() > 1e-9 ? Vec3(level / level.norm()) : Vec3::UnitX();
}

// Half of an edge of a rectangle; along a periodic axis at most half of the box.
Real half_of(Real edge, const Vec3& direction, const Settings& settings) {
  Real half = edge / 2;
  for (Eigen::Index a = 0; a < 3; ++a) {
    if (settings.periodic[static_cast<std::size_t>(a)] && std::abs(direction[a]) > 1 - 1e-9)
      half = std::min(half, (settings.domain.max[a] - settings.domain.min[a]) / 2);
  }
  return half;
}

}  // namespace

RectangleFlow::RectangleFlow(const GaugeSettings& gauge, const Settings& settings)
    : normal_(gauge.normal),
      level_(level_across(gauge.normal)),
      across_(gauge.normal.cross(level_)),
      half_{half_of(gauge.size[0], level_, settings), half_of(gauge.size[1], across_, settings)},
      spacing_(settings.fluid.spacing),
      seen_(gauge.center,
            (half_[0] + spacing_) * level_.cwiseAbs() + (half_[1] + spacing_) * across_.cwiseAbs() +
                2 * spacing_ * normal_.cwiseAbs(),
            settings) {}

Real RectangleFlow::volume(const Vec3& from) const {
  const Real ahead = part_within(from.dot(normal_), spacing_, spacing_);
  if (ahead == 0) return 0;
  return ahead * part_within(from.dot(level_), half_[0], spacing_) *
         part_within(from.dot(across_), half_[1], spacing_) * spacing_ * spacing_ * spacing_;
}

Real RectangleFlow::flow(const Vec3& p, const Vec3& v) const {
  Real sum = 0;
  seen_.for_each(p, [&](const Vec3& from) { sum += volume(from); });
  return sum * v.dot(normal_) / (2 * spacing_);
}

RunUp::RunUp(const GaugeSettings& gauge, const Settings& settings)
    : gauge_(gauge), spacing_(settings.fluid.spacing), seen_(gauge.center, Vec3::Constant(gauge.radius), settings) {
  if (gauge.kind == GaugeKind::run_up) solids_.emplace(settings);
}

bool RunUp::touches(const Vec3& p) const {
  const Real along = (p - gauge_.center).dot(gauge_.normal);
  bool in_strip = false;
  seen_.for_each(p, [&](const Vec3& from) {
    const Real beside = -from.x() * gauge_.normal.y() + from.y() * gauge_.normal.x();
    in_strip = in_strip || std::abs(beside) <= gauge_.radius;
  });
  return along >= 0 && in_strip && solids_->are_near(p, spacing_);
}

}  // namespace trevi
