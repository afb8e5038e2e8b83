// The points of a lattice around one of its points. Every sum over the lattice uses this function, so that all agree on
// which points are inside. Rank-local; the order of the points is fixed, because the last bits of the sums depend on
// it.
#pragma once

#include "kernels/kernels.hpp"

namespace trevi {

/// Calls visit(offset) for each lattice point nearer than h, the centre included; metres.
template <class Visit>
void for_each_lattice_point(const PointLattice& lattice, Real h, Visit&& visit) {
  const Real spacing = lattice.spacing;
  const int reach = static_cast<int>(h / spacing) + 1, across = lattice.dimensions == 2 ? 0 : reach;
  for (int x = -reach; x <= reach; ++x) {
    for (int y = -across; y <= across; ++y) {
      for (int z = -reach; z <= reach; ++z) {
        const Vec3 offset = spacing * Vec3(x, y, z);
        // Points at exactly h count as outside, independent of rounding.
        if (offset.norm() < h * (1 - 1e-9)) visit(offset);
      }
    }
  }
}

}  // namespace trevi
