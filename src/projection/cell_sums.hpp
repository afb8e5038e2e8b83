// Vectorised loops over the particles of a cell of the projection's grid: sums over them, and their displacements.
// Lanes and the order in which they are added are the same on every processor: particle k of a cell belongs to lane k
// modulo 8. Components are along the coordinates x, y, z, not the directions of the grid. Not collective, on this
// thread.
#pragma once

#include <array>
#include <span>

#include "fluid/pairs/pair_sums.hpp"

namespace trevi {

using ByAxis = std::array<Real, 3>;

/// The conversion from lengths to cells of ProjectionGrid, and how the volume of a particle is distributed.
struct CellFrame {
  ByAxis per_length;   ///< cells per metre
  ByAxis flat, reach;  ///< the density of a particle is uniform up to `flat` from its centre and falls linearly to zero
                       ///< at `reach`, in cells
  ByAxis nearest, farthest;  ///< limits of its centre, in cells from the corner of the box
  ByAxis floor, ceiling;     ///< limits through which nothing extends, in cells from the corner of the box
  Real per_full;             ///< volume of a particle, in cells
  Real by_gravity = 0;       ///< g dt²/2, in cells. Volumes are placed in the middle of paths as they would be without
                             ///< gravity; where there is none, at their beginnings, at most max_path before their ends
};

/// The positions, m, from which and to which the prediction, or a shift, moves the particles.
struct Motion {
  std::span<const Vec3> x, p;
};

/// Position of a cell: its lower corner lies `corner` cells from `origin`, m.
struct CellPlace {
  ByAxis origin, corner;
};

/// The particles [begin, end) of a cell.
struct CellParticles {
  std::size_t begin, end;
  CellPlace place;
};

/// Sums over the particles of a cell. y is the midpoint of the path of a particle, at which its motion is evaluated, in
/// cells from the corner of the cell; u is its displacement p − x, m.
struct MotionSums {
  ByAxis y;                  ///< Σ y
  std::array<Real, 6> yy;    ///< Σ y yᵀ: xx, yy, zz, xy, xz, yz
  ByAxis u;                  ///< Σ u
  std::array<ByAxis, 3> uy;  ///< uy[a][b]: Σ u_a y_b
  Real uu;                   ///< Σ |u|²
};
/// volume[i][j][k] is the volume that they fill of the cell (1, 1, 1) itself and of the 26 around it, in cells. A
/// particle is placed as CellFrame says, and the part that would be beyond a wall stays in the cell in front of it. The
/// part that would be beyond the cells around counts in these, so that the mean position is kept.
struct CellSums {
  MotionSums motion;
  std::array<std::array<ByAxis, 3>, 3> volume;
};
CellSums sum_cell(const CellFrame& frame, const Motion& motion, const CellParticles& cell);
/// The same without the volumes.
MotionSums sum_motion(const CellFrame& frame, const Motion& motion, const CellParticles& cell);

/// The displacement of the particles of a cell, m. It is low + f · rise, separately in each direction (lowest-order
/// Raviart–Thomas), plus offset + slope y − own u (pulling back and the damping of noise). f is the point of the path
/// that lies before y by `back` times half of the path. The displacement fades out at the surface: for a path whose
/// middle, without gravity, is at `surface`, in cells along z, its factor is `at_surface`, and it decreases by `fade`
/// per cell above that. No path counts further than max_fade_shift from its beginning.
/// `act` is 1 where the grid acts, otherwise 0.
struct CellDisplacement {
  ByAxis low{}, rise{}, offset{};
  std::array<ByAxis, 3> slope{};
  Real back = 1, own = 0;
  Real surface = 0, at_surface = 1, fade = 0;
  Real act = 0;
};
/// Writes displacements, m, and as the scalar the degree to which the grid acts on each particle, from 0 to 1.
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
