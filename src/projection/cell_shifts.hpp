// Vectorised loops over the particles of a cell that sweeps have shifted (shift_filter.hpp). Lanes and order are those
// of cell_sums.hpp. Not collective, on this thread.
#pragma once

#include "projection/affine.hpp"

namespace trevi {

/// Densities of the owned particles, kg/m³, and the rest density.
struct Densities {
  std::span<const Real> rho;
  Real rest;
};

/// For each owned row of cells, plane by plane, whether there may be a shift within three rows of it. The smooth part
/// of shifts extends over two rows.
struct RowsNearShifts {
  std::span<const char> marks;
  LocalId rows;  // of a plane
  bool has(LocalId k, LocalId r) const { return marks[static_cast<std::size_t>((k - 1) * rows + r)] != 0; }
};

/// The result of the sweeps for all owned particles: shifts of positions from x to p, how far the grid acts on each
/// particle (0 to 1), and the densities that the last sweep saw.
template <class T>
struct Swept {
  Motion shifts;
  std::span<const T> act;
  Densities densities;
  RowsNearShifts near;
};

/// Writes −act · (a + B y), m, for the particles of a cell, and 0 as the scalar. For squeezed particles this is
/// reduced, down to nothing (parameters.hpp).
template <class T>
void remove_smooth(const CellFrame& frame, const Swept<T>& swept, const CellParticles& cell, const AffineMap& smooth,
                   Vec4<T>* out);
template <>
void remove_smooth(const CellFrame& frame, const Swept<float>& swept, const CellParticles& cell,
                   const AffineMap& smooth, Vec4<float>* out);
template <>
void remove_smooth(const CellFrame& frame, const Swept<double>& swept, const CellParticles& cell,
                   const AffineMap& smooth, Vec4<double>* out);

/// v += act (u − g n − q a). Here u = B (Δ − the mean of Δ over the particles of the cell, weighted by act) with the
/// slopes B, 1/s; a = B y is the affine motion, and the noise n is the rest of v beyond a and the mean. g = Σ act n·u /
/// Σ act (n² + a²), so that noise larger than the affine motion does not gain by u. q = withheld Σ act a·u / Σ act a².
template <class T>
void carry_cell(const Motion& shifts, const CellParticles& cell, const std::array<ByAxis, 3>& slope,
                std::span<const T> act, std::span<Vec3> velocity);
template <>
void carry_cell(const Motion& shifts, const CellParticles& cell, const std::array<ByAxis, 3>& slope,
                std::span<const float> act, std::span<Vec3> velocity);
template <>
void carry_cell(const Motion& shifts, const CellParticles& cell, const std::array<ByAxis, 3>& slope,
                std::span<const double> act, std::span<Vec3> velocity);

}  // namespace trevi
