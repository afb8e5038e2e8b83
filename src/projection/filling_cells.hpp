// Part of assemble: cells beside air, and cells that solids cut, take in water that arrives until they are full. The
// divergence of a wet cell counts its faces as if it were full. Water that flew towards a solid was therefore stopped a
// cell in front of it: a fixed ball of 2.4 spacings got up to 2.4 times the impulse of one that moves into the same
// water. Not collective; on any thread for rows.
#pragma once

#include "projection/free_surface.hpp"

namespace trevi {

class FillingCells {
 public:
  /// Forgets what cells have taken in. With the planes and rows of the grid.
  void reset(const ProjectionGrid& grid);
  /// The divergence of a wet cell, `flow`, less the inflow that it has room for, both as shares of the cell; `g_dt2`,
  /// m. To be called for the cells of a row in ascending order.
  Real without_filling(const FreeSurface& surface, Real g_dt2, LocalId k, LocalId r, LocalId c, Real flow);
  /// The share, from 0 to 1, of the water that arrives in a cell that a solid cuts for which there is room.
  Real share(LocalId k, LocalId r, LocalId c) const;
  std::size_t bytes() const;

 private:
  struct Filling {
    LocalId column;
    Real share;
  };
  std::size_t row_index(LocalId k, LocalId r) const {
    return static_cast<std::size_t>(k - 1) * static_cast<std::size_t>(rows_of_plane_) + static_cast<std::size_t>(r);
  }

  LocalId rows_of_plane_ = 0;
  std::vector<std::vector<Filling>> rows_;  // in the order of their columns
};

}  // namespace trevi
