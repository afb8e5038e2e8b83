#include "trevi/particles/cell_grid.hpp"

#include <cassert>
#include <cmath>

#include "trevi/base/error.hpp"

namespace trevi {

CellGrid::CellGrid(const Vec3& min, const Vec3& max, Real h, int slab_axis)
    : min_(min), axis_{slab_axis, 1 - slab_axis, 2} {
  assert(slab_axis == 0 || slab_axis == 1);
  double cells = 1;
  for (int k = 0; k < 3; ++k) {
    const Real extent = max[axis_[k]] - min[axis_[k]];
    // A hair of tolerance, so that a box of n h has n cells whatever its rounding.
    count_[k] = std::max(1, static_cast<LocalId>(std::min(std::floor(extent / h * (1 + 1e-12)), 2e9)));
    per_length_[k] = count_[k] / extent;
    if (k > 0) cells *= count_[k];
  }
  require(cells < 2e9, "the box has more cells in a plane than can be counted; make the box smaller");
}

}  // namespace trevi
