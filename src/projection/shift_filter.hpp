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
  /// What row (k, r) no longer has of its columns when it keeps `columns`.
  void clear_row(LocalId k, LocalId r, LocalId columns);
  /// Of shifts of the owned particles, and of their compression rho/rho0 − 1.
  template <class T>
  void find(const CellOrder& order, Halo& halo, const Motion& shifts, std::span<const T> compression);
  /// What is taken off the shifts of the particles of a cell where the grid acts in full.
  AffineMap smooth(LocalId k, LocalId r, LocalId c) const { return map_.cell<AffineMap>(k, r, c); }
  std::size_t bytes() const { return sums_.bytes() + fit_.bytes() + map_.bytes() + kept_.capacity() * sizeof(Real); }

 private:
  template <class T>
  void sum_row(const CellOrder& order, LocalId k, LocalId r, const Motion& shifts, std::span<const T> compression);
  void fit_row(TentMemory& memory, LocalId k, LocalId r);
  bool is_water(std::size_t at) const { return surface_.is_wet(at) || surface_.is_wet(at - 1); }

  const FreeSurface& surface_;
  CellFields sums_{numbers::moments};  // `more`: Σ rho/rho0 − 1
  CellFields fit_{numbers::map}, map_{numbers::map};
  std::vector<Real> kept_;  // fraction that is taken off
};

}  // namespace trevi
