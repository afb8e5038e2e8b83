// The vectorised loops over the particles of a cell that sweeps have shifted (shift_filter.hpp); lanes and orders are
// those of cell_sums.hpp. Not collective, on this thread.
#pragma once

#include "projection/affine.hpp"

namespace trevi {

/// Densities of the owned particles, kg/m³, and that at rest.
struct Densities {
  std::span<const Real> rho;
  Real rest;
};

/// Of each own row of cells, plane by plane, whether there may be a shift within three rows of it: the smooth part of
/// shifts reaches over two.
struct RowsNearShifts {
  std::span<const char> marks;
  LocalId rows;  // of a plane
  bool has(LocalId k, LocalId r) const { return marks[static_cast<std::size_t>((k - 1) * rows + r)] != 0; }
};

/// What the sweeps have done: shifts of positions from x to p, where the grid acts (0 to 1), and the densities that
/// they have seen last; of all owned particles.
template <class T>
struct Swept {
  Motion shifts;
  std::span<const T> act;
  Densities densities;
  RowsNearShifts near;
};

/// Writes −act · (a + B y), m, of the particles of a cell, as the scalar 0; less of it, down to nothing, of those that
/// are squeezed (parameters.hpp).
template <class T>
void remove_smooth(const CellFrame& frame, const Swept<T>& swept, const CellParticles& cell, const AffineMap& smooth,
                   Vec4<T>* out);
template <>
void remove_smooth(const CellFrame& frame, const Swept<float>& swept, const CellParticles& cell,
                   const AffineMap& smooth, Vec4<float>* out);
template <>
void remove_smooth(const CellFrame& frame, const Swept<double>& swept, const CellParticles& cell,
                   const AffineMap& smooth, Vec4<double>* out);

/// v += act (u − g n − q a), with u = B (Δ − the mean of Δ over the particles of the cell, weighted by act) by the
/// slopes B, 1/s, the affine motion a = B y and the noise n, which is what v has beside a and the mean. g = Σ act n·u /
/// Σ act (n² + a²): noise that is more than the affine motion does not gain by u. q = withheld Σ act a·u / Σ act a².
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
