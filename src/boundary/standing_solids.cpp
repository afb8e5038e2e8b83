#include "boundary/standing_solids.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "boundary/gauges.hpp"

namespace trevi {

StandingSolids::StandingSolids(const Settings& settings) {
  for (const ObstacleSettings& obstacle : settings.obstacles)
    if (!obstacle.moves()) solids_.push_back({make_shape(obstacle), BodyMotion(obstacle).at(0)});
}

bool StandingSolids::are_near(const Vec3& p, Real reach) const {
  return std::any_of(solids_.begin(), solids_.end(), [&](const Solid& solid) {
    return solid.shape->distance_within(solid.pose.into_body(p), 2 * reach) <= reach;
  });
}

Real StandingSolids::open_share(const Vec3& p, Real edge) const {
  Real open = 1;
  for (const Solid& solid : solids_) {
    const Real distance = solid.shape->distance_within(solid.pose.into_body(p), edge);
    open -= std::clamp(0.5 - distance / edge, 0.0, 1.0);
  }
  return std::max(open, 0.0);
}

bool StandingSolids::may_reach_into(const Box& box) const {
  return are_near((box.min + box.max) / 2, (box.max - box.min).norm() / 2);
}

OpenVolume::OpenVolume(const Box& part, const StandingSolids& solids, const Settings& settings)
    : bottom_(settings.domain.min.z()) {
  const Real edge = settings.fluid.spacing / 2;
  const Vec3 size = part.max - part.min;
  const auto count = [&](Eigen::Index a) { return std::max(1.0, std::round(size[a] / edge)); };
  const Real along = count(0), across = count(1), layers = count(2);
  height_ = size.z() / layers;
  volume_.push_back(0);
  for (Real n = 0; n < layers; ++n) {
    Real open = 0;
    for (Real i = 0; i < along; ++i) {
      for (Real j = 0; j < across; ++j) {
        const Vec3 place((i + 0.5) / along, (j + 0.5) / across, (n + 0.5) / layers);
        open += solids.open_share(part.min + size.cwiseProduct(place), edge);
      }
    }
    constexpr Real rounding = 1e-6;
    const Real share = open / (along * across);
    areas_.push_back(share > rounding ? size.x() * size.y() * share : 0);
    volume_.push_back(volume_.back() + areas_.back() * height_);
  }
}

std::size_t OpenVolume::layer_of(Real level) const {
  const auto last = static_cast<Real>(areas_.size() - 1);
  return static_cast<std::size_t>(std::clamp(std::floor((level - bottom_) / height_), 0.0, last));
}

// The layer itself, or the highest one below it that is not closed, if there is one.
std::size_t OpenVolume::highest_open(std::size_t n) const {
  while (areas_[n] == 0 && volume_[n] > 0) --n;
  return n;
}

Real OpenVolume::level(Real volume) const {
  const auto above = std::upper_bound(volume_.begin() + 1, volume_.end() - 1, volume);
  auto n = highest_open(static_cast<std::size_t>(above - volume_.begin()) - 1);
  if (n > 0 && areas_[n - 1] == 0 && volume_[n] > 0) {
    const std::size_t below = highest_open(n - 1);
    if (volume - volume_[n] < 2 * areas_[below] * height_) n = below;
  }
  const Real layers = static_cast<Real>(n) + (areas_[n] > 0 ? (volume - volume_[n]) / (areas_[n] * height_) : 0);
  return bottom_ + layers * height_;
}

Real OpenVolume::volume(Real level) const {
  const std::size_t n = layer_of(level);
  return volume_[n] + areas_[n] * std::clamp(level - bottom_ - static_cast<Real>(n) * height_, 0.0, height_);
}

Real OpenVolume::depth(Real level) const {
  const std::size_t at = layer_of(level), n = highest_open(at);
  if (areas_[n] == 0) return 0;
  return volume_[n] / areas_[n] + (n < at ? height_ : level - bottom_ - static_cast<Real>(n) * height_);
}

OpenDisc::OpenDisc(const GaugeSettings& gauge, const StandingSolids& solids, const Settings& settings)
    : bottom_(gauge.center.z()),
      step_(settings.fluid.spacing / 4),
      in_box_(open_fraction_of_gauge(gauge, lattice_of(settings.fluid), settings.domain, {}, settings.periodic)) {
  const bool in_layer = settings.fluid.dimensions == 2;
  const Real top = settings.domain.max.z(), radius = gauge.radius;
  const Vec3 reach(radius, in_layer ? 0 : radius, 0);
  const Box around{gauge.center - reach, Vec3(gauge.center.x() + reach.x(), gauge.center.y() + reach.y(), top)};
  if (!solids.may_reach_into(around)) return;
  const int samples = in_layer ? 64 : 16, rows = in_layer ? 1 : samples;
  const Real edge = 2 * radius / samples;
  Box within = settings.domain;
  for (Eigen::Index a = 0; a < 2; ++a) {
    if (!settings.periodic[static_cast<std::size_t>(a)]) continue;
    within.min[a] = -INFINITY;
    within.max[a] = INFINITY;
  }
  std::vector<std::pair<Vec3, Real>> parts;  // of the disc in the box: positions on it, weights
  for (int k = 0; k < samples * rows; ++k) {
    const Vec3 from((k % samples + 0.5) * edge - radius, in_layer ? 0 : (k / samples + 0.5) * edge - radius, 0);
    const Vec3 half(edge / 2, edge / 2, 0);
    const Vec3 low = (from - half).cwiseMax(within.min - gauge.center);
    const Vec3 high = (from + half).cwiseMin(within.max - gauge.center);
    if (low.x() >= high.x() || (!in_layer && low.y() >= high.y())) continue;
    const Box2 square{low.x(), low.y(), high.x(), high.y()};
    const Real weight = in_layer ? gauge_weight_in_layer_of(square, radius) : gauge_weight_of(square, radius);
    if (weight <= 0) continue;
    // A solid that meets a wall of the box continues behind it.
    const Vec3 place = (gauge.center + from).cwiseMax(within.min + half).cwiseMin(within.max - half);
    parts.emplace_back(Vec3(place.x(), place.y(), gauge.center.z()), weight);
  }
  const auto heights = static_cast<std::size_t>(std::ceil(std::max(0.0, top - bottom_) / step_)) + 1;
  for (std::size_t n = 0; n < heights; ++n) {
    Real open = 0;
    for (const auto& [place, weight] : parts)
      open += weight * solids.open_share(place + static_cast<Real>(n) * step_ * Vec3::UnitZ(), edge);
    shares_.push_back(open / in_box_);
  }
}

Real OpenDisc::at(Real z) const {
  constexpr Real least = 0.2;
  if (shares_.size() < 2) return in_box_;
  const Real steps = std::clamp((z - bottom_) / step_, 0.0, static_cast<Real>(shares_.size() - 1));
  const std::size_t n = std::min(static_cast<std::size_t>(steps), shares_.size() - 2);
  const Real part = steps - static_cast<Real>(n);
  return in_box_ * std::max(least, (1 - part) * shares_[n] + part * shares_[n + 1]);
}

}  // namespace trevi
