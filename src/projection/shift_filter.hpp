// What the sweeps of the density solve may do to positions: part particles, but not move the water. Kernel sums of
// disordered water exceed those of the lattice of the same density by 0.4 %, and spread by 1 %; a constraint that only
// pushes would lift the water by that, and the dam break is 2 % too thin without this filter. Volume has one judge, the
// cells' fill. So the smooth part of the shifts, the mean of the fits of the cells around a particle (affine.hpp), is
// taken off where the grid acts, but for where water is compressed over more than a cell, as in impacts, and for single
// particles that are squeezed, as at walls.
//
// A shifted particle takes on the velocity of where it goes (Lind et al., J. Comput. Phys. 231, 2012, eq. 28): v += B Δ
// with the slope B of the water's motion there (Projection::carry_velocities). Without that, shear and vortices
// diffuse. Shifts oppose the noise by which particles meet, and B Δ makes that grow along the axis on which the flow
// closes in; what of B Δ goes along the noise of a cell is left out, the more the more noise there is.
//
// Sums and fits are of few planes at a time: as soon as the smooth part of a plane is known, sums of the planes before
// make room for those of the planes after. Collective: for_each_plane().
#pragma once

#include <functional>

#include "projection/cell_shifts.hpp"
#include "projection/free_surface.hpp"

namespace trevi {

class ShiftFilter {
 public:
  explicit ShiftFilter(const FreeSurface& surface) : surface_(surface) {}

  /// Shifts of the owned particles, their densities over that at rest, and the rows of which something is found.
  struct Input {
    const CellOrder& order;
    Motion shifts;
    Densities densities;
    RowsNearShifts near;
  };
  /// Calls use(planes) for runs of own planes, one after the other, which are all of them: find_smooth() is then for
  /// their rows that are near shifts.
  void for_each_plane(Halo& halo, const Input& input, const std::function<void(Range planes)>& use);
  /// What is taken off the shifts of the particles in a row of cells where the grid acts in full. One for each part of
  /// a loop of threads, in which rows come in their order.
  struct Smooth {
    std::vector<FourCells> row;
    TentMemory memory;
    AffineMap at(LocalId c) const { return cell_of<AffineMap>(row.data(), numbers::map, c); }
  };
  void find_smooth(Smooth& smooth, LocalId k, LocalId r) const;

 private:
  void borrow();
  void give_back();
  void sum_row(const Input& input, LocalId k, LocalId r);
  void fit_row(TentMemory& memory, const Input& input, LocalId k, LocalId r);
  bool is_water(std::size_t at) const { return surface_.is_wet(at) || surface_.is_wet(at - 1); }

  Real* kept_of(LocalId k, LocalId r) const {
    const ProjectionGrid& grid = surface_.grid();
    const LocalId place = k == 1 ? window_ : k == grid.planes() ? window_ + 1 : k % window_;
    return &kept_[static_cast<std::size_t>(place) * grid.step(0) + grid.index(0, r, 0)];
  }

  const FreeSurface& surface_;
  CellFields sums_{numbers::moments};  // `more`: Σ rho/rho0 − 1
  CellFields fit_{numbers::map};
  Borrowed<Real> kept_;  // fraction that is taken off
  LocalId window_ = 1;   // planes of which there are sums and fits at a time
};

}  // namespace trevi
