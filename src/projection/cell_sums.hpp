// The vectorised loops over the particles of a cell of the projection's grid: sums over them, and their displacements.
// Lanes and the order in which they are added are the same on every processor: particle k of a cell belongs to lane k
// modulo 8. By coordinate x, y, z, not by direction of the grid. Not collective, on this thread.
#pragma once

#include <array>
#include <span>

#include "fluid/pairs/pair_sums.hpp"

namespace trevi {

using ByAxis = std::array<Real, 3>;

/// What in_cells() etc. of ProjectionGrid are made of, and how a particle is spread.
struct CellFrame {
  ByAxis per_length;   ///< cells per metre
  ByAxis flat, reach;  ///< a particle's density is even up to `flat` from its middle and falls linearly to nothing
                       ///< at `reach`, in cells
  ByAxis nearest, farthest;  ///< where its middle can be, in cells from the corner of the box
  ByAxis floor, ceiling;     ///< through which nothing reaches, in cells from the corner of the box
  Real per_full;             ///< volume of a particle, in cells
};

/// The positions, m, between which the prediction, or a shift, moves the particles.
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

/// Sums over the particles of a cell. y: where the motion of a particle is seen, midway of its path, in cells from the
/// corner of the cell; u: its displacement p − x, m.
struct MotionSums {
  ByAxis y;                  ///< Σ y
  std::array<Real, 6> yy;    ///< Σ y yᵀ: xx, yy, zz, xy, xz, yz
  ByAxis u;                  ///< Σ u
  std::array<ByAxis, 3> uy;  ///< uy[a][b]: Σ u_a y_b
  Real uu;                   ///< Σ |u|²
};
/// volume[i][j][k] is what they fill of the cell (1, 1, 1) itself and of the 26 around it, in cells. A particle is
/// placed at its surface position (FreeSurface), and what would be beyond a wall stays in the cell before it.
struct CellSums {
  MotionSums motion;
  std::array<std::array<ByAxis, 3>, 3> volume;
};
CellSums sum_cell(const CellFrame& frame, const Motion& motion, const CellParticles& cell);
/// The same without the volumes.
MotionSums sum_motion(const CellFrame& frame, const Motion& motion, const CellParticles& cell);

/// How particles of a cell are displaced: by low + f · rise, m, in each direction for itself (lowest-order Raviart and
/// Thomas), with f the place on the path that is `back` of its half before y, and by offset + slope y − own u, m
/// (pulling back and the damping of noise). It fades out at the surface: at `surface`, in cells along z, it is
/// `at_surface`, and `fade` less per cell above that. `act` is 1 where the grid acts, else 0.
struct CellDisplacement {
  ByAxis low{}, rise{}, offset{};
  std::array<ByAxis, 3> slope{};
  Real back = 1, own = 0;
  Real surface = 0, at_surface = 1, fade = 0;
  Real act = 0;
};
/// Writes displacements, m, and as the scalar how far the grid acts on each particle, from 0 to 1.
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
