// Signed distances of a shape whose exact distances are expensive, from a grid in its own frame: linear between nodes
// h/6 apart near the surface, coarser further away, and a bound far away. For what samples space anyway (the cells of
// the coarse grid), never for collisions: a sheet thinner than the distance between nodes is not resolved. However the
// shape moves, nothing is recomputed. Blocks are made when they are first asked for, from the shape alone. Not
// collective.
#pragma once

#include "boundary/geometry/lazy_blocks.hpp"
#include "boundary/geometry/shape.hpp"

namespace trevi {

class DistanceGrid {
 public:
  DistanceGrid(const Shape& shape, Real h);

  /// `error`: the largest error; where the surface is further away than 3 h, both together bound the distance.
  struct Rough {
    Real distance, error;
  };
  Rough at(const Vec3& p) const;
  std::size_t bytes() const { return blocks_.bytes(); }

 private:
  struct Block {
    int intervals = 0;        // in each direction; 0 if it is far away
    Real far = 0;             // the bound
    std::vector<float> node;  // m
  };
  std::unique_ptr<Block> make(const BlockPlace& place) const;
  Rough beyond(const Vec3& p) const;

  const Shape& shape_;
  Real edge_;  // of a block, m: h
  bool vessel_;
  Box bounds_;
  BlockPlace low_, high_;
  LazyBlocks<Block> blocks_;
};

}  // namespace trevi
