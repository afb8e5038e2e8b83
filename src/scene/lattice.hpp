// The initial lattice of a block of water: point (i, j, k) is min + (i + ½, j + ½, k + ½) spacing, m. Numbers have 64
// bits, because the block belongs to all ranks together. Not collective.
#pragma once

#include <array>
#include <cmath>

#include "trevi/scene.hpp"

namespace trevi {

struct Lattice {
  Vec3 min;
  Real spacing;
  std::array<GlobalId, 3> count;

  Lattice(const ParticleSource& block, Real s) : min(block.min), spacing(s) {
    for (std::size_t a = 0; a < 3; ++a) {
      const auto axis = static_cast<Eigen::Index>(a);
      count[a] = static_cast<GlobalId>(std::llround((block.max[axis] - block.min[axis]) / s));
    }
  }
  GlobalId size() const { return count[0] * count[1] * count[2]; }
  /// x fastest, from 0.
  GlobalId id(GlobalId i, GlobalId j, GlobalId k) const { return (k * count[1] + j) * count[0] + i; }
  Vec3 point(GlobalId i, GlobalId j, GlobalId k) const {
    return min + spacing * Vec3(static_cast<Real>(i) + 0.5, static_cast<Real>(j) + 0.5, static_cast<Real>(k) + 0.5);
  }
};

}  // namespace trevi
