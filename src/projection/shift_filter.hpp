// What the sweeps of the density solve may do to positions: part particles, but not move the water. Kernel sums of
// disordered water exceed those of the lattice of the same density by 0.4 %, and spread by 1 %; a constraint that only
// pushes would lift the water by that, and the dam break is 2 % too thin without this filter. Volume has one judge, the
// cells' fill. So the smooth part of the shifts, the mean of the fits of the cells around a particle (affine.hpp), is
// taken off where the grid acts, but for where water is compressed over more than a cell, as in impacts, and for single
// particles that are squeezed, as at walls.
//
// A shifted particle takes on the velocity of where it goes (Lind et al., J. Comput. Phys. 231, 2012, eq. 28): v += B Δ
// with the slope B of the water's motion there (Projection::carry_velocities). Without that, shear and vortices
// diffuse.
//
// Collective: find().
#pragma once

#include "projection/cell_shifts.hpp"
#include "projection/free_surface.hpp"

namespace trevi {

class ShiftFilter {
 public:
  /// Memory of the stages before the sweeps, which they no longer need.
  struct Memory {
    CellFields &moments, &fits;
  };
  ShiftFilter(const FreeSurface& surface, const Memory& memory)
      : surface_(surface), sums_(memory.moments), fit_(memory.fits) {}

  void resize();
  /// Of shifts of the owned particles, and of their densities over that at rest.
  void find(const CellOrder& order, Halo& halo, const Motion& shifts, const Densities& densities);
  /// What is taken off the shifts of the particles in a row of cells where the grid acts in full. One for each part of
  /// a loop of threads, in which rows come in their order.
  struct Smooth {
    std::vector<EightCells> row;
    TentMemory memory;
    AffineMap at(LocalId c) const { return cell_of<AffineMap>(row.data(), numbers::map, c); }
  };
  void find_smooth(Smooth& smooth, LocalId k, LocalId r) const;
  std::size_t bytes() const { return kept_.capacity() * sizeof(Real); }

 private:
  void sum_row(const CellOrder& order, LocalId k, LocalId r, const Motion& shifts, const Densities& densities);
  void fit_row(TentMemory& memory, LocalId k, LocalId r);
  bool is_water(std::size_t at) const { return surface_.is_wet(at) || surface_.is_wet(at - 1); }

  const FreeSurface& surface_;
  CellFields& sums_;  // `more`: Σ rho/rho0 − 1
  CellFields& fit_;
  std::vector<Real> kept_;  // fraction that is taken off
};

}  // namespace trevi
