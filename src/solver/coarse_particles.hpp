// The vectorised loops over the particles of a cell of the coarse grid: sums over them, and their displacements. Lanes
// and the order in which they are added are the same on every processor: particle k of a cell belongs to lane k modulo
// 8. By coordinate x, y, z, not by direction of the grid. Not collective, on this thread.
#pragma once

#include <array>
#include <span>

#include "fluid/pair_sums.hpp"

namespace trevi {

using ByAxis = std::array<Real, 3>;

/// What in_cells() etc. of CoarseGrid are made of, and the cube of a particle.
struct CellFrame {
  ByAxis per_length;         ///< cells per metre
  ByAxis half;               ///< of a cube's edge, in cells
  ByAxis nearest, farthest;  ///< where a cube's middle can be between walls, in cells from the corner of the box
  Real per_full;             ///< volume of a particle, in cells
};

/// The positions, m, between which the prediction moves the particles.
struct Motion {
  std::span<const Vec3> x, p;
};

/// Where a cell is: its lower corner lies `corner` cells from `origin`, m.
struct CellPlace {
  ByAxis origin, corner;
};

/// The particles [begin, end) of a cell.
struct CellParticles {
  std::size_t begin, end;
  CellPlace place;
};

/// Sums over the particles of a cell of powers of their fraction f, which is 0 at the lower face and 1 at the upper
/// one, and of their displacement u, m. volume[i][j][k] is what they fill of the cell (1, 1, 1) itself and of the 26
/// around it, in cells. The cube of a particle is placed at its surface position (CoarseWater), but moved to lie inside
/// the walls.
struct CellSums {
  ByAxis f, f2, f3, u, fu, f2u;
  std::array<std::array<ByAxis, 3>, 3> volume;
};
CellSums sum_cell(const CellFrame& frame, const Motion& motion, const CellParticles& cell);

/// How particles of a cell are displaced: by low + f · rise, m, plus a share of what leads from their own motion to
/// their cell's, mean_low + f · mean_rise, where it is small: half as much at the distance 1/sqrt(per_noise2), m. It
/// fades out at the surface: at `surface`, in cells along z, it is `at_surface`, and `fade` less per cell above that.
struct CellDisplacement {
  ByAxis low, rise, mean_low, mean_rise;
  Real share, per_noise2;
  Real surface, at_surface, fade;
};
template <class T>
void displace_cell(const CellFrame& frame, const Motion& motion, const CellParticles& cell,
                   const CellDisplacement& displacement, Vec4<T>* out);
template <>
void displace_cell(const CellFrame& frame, const Motion& motion, const CellParticles& cell,
                   const CellDisplacement& displacement, Vec4<float>* out);
template <>
void displace_cell(const CellFrame& frame, const Motion& motion, const CellParticles& cell,
                   const CellDisplacement& displacement, Vec4<double>* out);

}  // namespace trevi
