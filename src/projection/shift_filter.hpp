// What the sweeps of the density solve may do to positions: part particles, but not move the water. Kernel sums of
// disordered water exceed those of the lattice of the same density by 0.4 %, and spread by 1 %; a constraint that only
// pushes would lift the water by that, and the dam break is 2 % too thin without this filter. Volume has one judge, the
// cells' fill. So the smooth part of the shifts, the mean of the fits of the cells around a particle (affine.hpp), is
// taken off where the grid acts, but for where water is compressed over more than a cell, as in impacts.
//
// A shifted particle takes on the velocity of where it goes (Lind et al., J. Comput. Phys. 231, 2012, eq. 28): v += B Δ
// with the slope B of the water's motion there (Projection::carry_velocities). Without that, shear and vortices
// diffuse.
//
// Collective: find().
#pragma once

#include "projection/free_surface.hpp"

namespace trevi {

class ShiftFilter {
 public:
  explicit ShiftFilter(const FreeSurface& surface) : surface_(surface) {}

  void resize();
  void clear_row(LocalId k, LocalId r);
  /// Of shifts of the owned particles, and of their compression rho/rho0 − 1.
  template <class T>
  void find(const CellOrder& order, Halo& halo, const Motion& shifts, std::span<const T> compression);
  /// What is taken off the shift of a particle of the cell that is at y, m, where the grid acts in full.
  Vec3 smooth(std::size_t at, const ByAxis& y) const {
    const AffineMap& map = map_[at];
    return {map.at(0, y), map.at(1, y), map.at(2, y)};
  }
  std::size_t bytes() const {
    return sums_.capacity() * sizeof(Moments) + (fit_.capacity() + map_.capacity()) * sizeof(AffineMap) +
           kept_.capacity() * sizeof(Real);
  }

 private:
  bool is_water(std::size_t at) const { return surface_.is_wet(at) || surface_.is_wet(at - 1); }

  const FreeSurface& surface_;
  std::vector<Moments> sums_;  // `more`: Σ rho/rho0 − 1
  std::vector<AffineMap> fit_, map_;
  std::vector<Real> kept_;  // fraction that is taken off
};

}  // namespace trevi
