// The filter of the shifts of the density solve, which may separate particles but not move the water. Kernel sums of
// disordered water exceed those of a lattice of the same density by 0.4 %, with a spread of 1 %. A constraint that only
// pushes would lift the water by that, and without this filter the dam break is 2 % too thin. Volume has one judge, the
// fill of the cells. The smooth part of the shifts, the mean of the fits of the cells around a particle (affine.hpp),
// is therefore removed where the grid acts, except where water is compressed over more than a cell, as in impacts, and
// for single particles that are squeezed, as at walls.
//
// A shifted particle takes on the velocity of its new position (Lind et al., J. Comput. Phys. 231, 2012, eq. 28): v +=
// B Δ with the slope B of the motion of the water there (Projection::carry_velocities). Without this, shear and
// vortices diffuse. Shifts oppose the noise by which particles approach each other, and B Δ amplifies the noise along
// the axis on which the flow converges. The part of B Δ along the noise of a cell is left out, the more the more noise
// there is.
//
// Sums and fits are kept for few planes at a time: as soon as the smooth part of a plane is known, the sums of the
// planes before it make room for those of the planes after it. Collective: for_each_plane().
#pragma once

#include <functional>

#include "projection/cell_shifts.hpp"
#include "projection/free_surface.hpp"

namespace trevi {

class ShiftFilter {
 public:
  explicit ShiftFilter(const FreeSurface& surface) : surface_(surface) {}

  /// Shifts of the owned particles, their densities, and the rows for which something is computed.
  struct Input {
    const CellOrder& order;
    Motion shifts;
    Densities densities;
    RowsNearShifts near;
  };
  /// Calls use(planes) for consecutive runs that make up all owned planes. find_smooth() may then be called for those
  /// rows of these planes that are near shifts.
  void for_each_plane(Halo& halo, const Input& input, const std::function<void(Range planes)>& use);
  /// The part of the shifts of the particles in a row of cells that is removed where the grid acts in full. There is
  /// one for each part of a loop that threads share, in which the rows come in their order.
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
  Borrowed<Real> kept_;  // fraction that is removed
  LocalId window_ = 1;   // number of planes with sums and fits at a time
};

}  // namespace trevi
