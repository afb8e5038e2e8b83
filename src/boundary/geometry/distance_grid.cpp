#include "boundary/geometry/distance_grid.hpp"

#include <algorithm>
#include <cmath>

namespace trevi {

namespace {

constexpr int near_intervals = 6, middle_intervals = 2;
constexpr std::int32_t margin = 4;  // blocks around the bounds
constexpr Real far_edges = 3;       // in edges of a block: larger distances are only bounded

}  // namespace

DistanceGrid::DistanceGrid(const Shape& shape, Real h)
    : shape_(shape),
      edge_(h),
      vessel_(shape.distance(shape.bounds().max + Vec3::Constant(h)) < 0),
      bounds_(shape.bounds()),
      low_(shifted_place(block_place(bounds_.min, edge_), -margin)),
      high_(shifted_place(block_place(bounds_.max, edge_), margin + 1)),
      blocks_(low_, high_) {}

std::unique_ptr<DistanceGrid::Block> DistanceGrid::make(const BlockPlace& place) const {
  auto block = std::make_unique<Block>();
  const Vec3 corner = corner_of(place, edge_);
  const Real middle = shape_.distance(corner + Vec3::Constant(edge_ / 2));
  const Real least = std::abs(middle) - half_diagonal * edge_;
  if (least > far_edges * edge_) {
    block->far = std::copysign(least, middle);
    return block;
  }
  const int n = block->intervals = least > edge_ / 2 ? middle_intervals : near_intervals;
  for (int z = 0; z <= n; ++z) {
    for (int y = 0; y <= n; ++y) {
      for (int x = 0; x <= n; ++x)
        block->node.push_back(static_cast<float>(shape_.distance(corner + edge_ / n * Vec3(x, y, z))));
    }
  }
  return block;
}

// From the bounds of the surface.
DistanceGrid::Rough DistanceGrid::beyond(const Vec3& p) const {
  const Real least = (bounds_.min - p).cwiseMax(p - bounds_.max).cwiseMax(0.0).norm();
  return {vessel_ ? -least : least, 0};
}

DistanceGrid::Rough DistanceGrid::at(const Vec3& p) const {
  const BlockPlace place = block_place(p, edge_);
  for (std::size_t a = 0; a < 3; ++a) {
    if (place[a] < low_[a] || place[a] >= high_[a]) return beyond(p);
  }
  const Block& block = blocks_.at(place, [&] { return make(place); });
  if (block.intervals == 0) return {block.far, 0};
  const int n = block.intervals;
  const Vec3 in_nodes = (p / edge_ - Vec3(place[0], place[1], place[2])) * n;
  std::array<std::size_t, 3> first{};
  Vec3 t;
  for (std::size_t a = 0; a < 3; ++a) {
    const auto b = static_cast<Eigen::Index>(a);
    const int k = std::clamp(static_cast<int>(in_nodes[b]), 0, n - 1);
    first[a] = static_cast<std::size_t>(k);
    t[b] = in_nodes[b] - k;
  }
  const auto row = static_cast<std::size_t>(n) + 1;
  const float* node = block.node.data() + (first[2] * row + first[1]) * row + first[0];
  const auto along_x = [&](const float* from) { return from[0] + t.x() * (static_cast<Real>(from[1]) - from[0]); };
  const auto along_y = [&](const float* from) {
    const Real low = along_x(from);
    return low + t.y() * (along_x(from + row) - low);
  };
  const Real low = along_y(node);
  return {low + t.z() * (along_y(node + row * row) - low), half_diagonal * edge_ / n};
}

}  // namespace trevi
