// Whether places are in a solid, or near it, where many are asked for and exact distances take long, as those of a mesh
// do: most places are told by the distance of the middle of their block, which is worked out once. Answers are those of
// the exact distance. Not collective; any thread may ask.
#pragma once

#include "boundary/geometry/lazy_blocks.hpp"
#include "boundary/geometry/shape.hpp"

namespace trevi {

class SolidTest {
 public:
  /// `edge`: of a block, m, at least.
  SolidTest(std::unique_ptr<Shape> shape, Real edge);
  /// Whether the distance of p, in the frame of the solid, is below `gap`, m.
  bool is_nearer(const Vec3& p, Real gap) const;

 private:
  std::unique_ptr<Shape> shape_;
  Real edge_;
  bool vessel_;
  Box bounds_;
  BlockPlace low_, high_;
  LazyBlocks<Real> middle_;  // distance of the middle of a block
};

}  // namespace trevi
