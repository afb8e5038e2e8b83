#include "boundary/geometry/solid_test.hpp"

#include <algorithm>
#include <cmath>

namespace trevi {

namespace {

// Largest number of blocks across a large mesh.
constexpr int max_blocks = 256;

Real extent_of(const Shape& shape) { return (shape.bounds().max - shape.bounds().min).maxCoeff(); }

}  // namespace

SolidTest::SolidTest(std::unique_ptr<Shape> shape, Real edge)
    : shape_(std::move(shape)),
      edge_(std::max(edge, extent_of(*shape_) / max_blocks)),
      vessel_(shape_->distance(shape_->bounds().max + Vec3::Constant(edge_)) < 0),
      bounds_(shape_->bounds()),
      low_(block_place(bounds_.min, edge_)),
      high_(shifted_place(block_place(bounds_.max, edge_), 1)),
      middle_(low_, high_) {}

bool SolidTest::is_nearer(const Vec3& place_in_solid, Real gap) const {
  Vec3 p = place_in_solid;
  if (const auto along = shape_->extruded_along()) p[*along] = 0;  // it continues beyond its bounds
  const Vec3 beyond = (bounds_.min - p).cwiseMax(p - bounds_.max).cwiseMax(0.0);
  if (beyond.squaredNorm() > 0) return beyond.norm() > std::abs(gap) ? vessel_ : shape_->distance(p) < gap;
  const BlockPlace place = block_place(p, edge_);
  const Real middle = middle_.at(place, [&] {
    return std::make_unique<Real>(shape_->distance(corner_of(place, edge_) + Vec3::Constant(edge_ / 2)));
  });
  return std::abs(middle) > half_diagonal * edge_ + std::abs(gap) ? middle < 0 : shape_->distance(p) < gap;
}

}  // namespace trevi
