// Whether positions are in a solid, or near it, when there are many of them and exact distances are expensive, as they
// are for a mesh: most positions are decided by the distance of the centre of their block, which is computed once. The
// results are those of the exact distance. Not collective; any thread may ask.
#pragma once

#include "boundary/geometry/lazy_blocks.hpp"
#include "boundary/geometry/shape.hpp"

namespace trevi {

class SolidTest {
 public:
  /// `edge`: the least edge of a block, m.
  SolidTest(std::unique_ptr<Shape> shape, Real edge);
  /// Whether the distance of p, in the frame of the solid, is below `gap`, m.
  bool is_nearer(const Vec3& p, Real gap) const;

 private:
  std::unique_ptr<Shape> shape_;
  Real edge_;
  bool vessel_;
  Box bounds_;
  BlockPlace low_, high_;
  LazyBlocks<Real> middle_;  // distance of the centre of a block
};

}  // namespace trevi
