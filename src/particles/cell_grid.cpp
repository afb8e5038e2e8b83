#include "particles/cell_grid.hpp"

#include <cassert>
#include <cmath>

namespace trevi {

CellGrid::CellGrid(const Vec3& min, const Vec3& max, Real h, int slab_axis, const std::array<bool, 3>& periodic)
    : min_(min), axis_{slab_axis, 1 - slab_axis, 2} {
  assert(slab_axis == 0 || slab_axis == 1);
  for (std::size_t k = 0; k < 3; ++k) {
    const Real extent = max[axis_[k]] - min[axis_[k]];
    // A tolerance, so that a box of n h has n cells despite rounding.
    count_[k] = std::max(1, static_cast<LocalId>(std::min(std::floor(extent / h * (1 + 1e-12)), 2e9)));
    per_length_[k] = count_[k] / extent;
    periodic_[k] = periodic[static_cast<std::size_t>(axis_[k])];
    // Along periodic axes positions have about 46 bits (boundary/periodic_domain.hpp): one on a cell's lower face is in
    // this cell despite rounding.
    if (periodic_[k]) per_length_[k] *= 1 + 0x1p-50;
    length_[k] = extent;
  }
  is_layer_ = max.y() - min.y() < h * (1 - 1e-9);
  assert(static_cast<Real>(rows()) * columns() < 2e9);  // ensured by the reader of the scene
}

}  // namespace trevi
