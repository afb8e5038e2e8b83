// The vectorised loops over the particles of a cell that sweeps have shifted (shift_filter.hpp); lanes and orders are
// those of cell_sums.hpp. Not collective, on this thread.
#pragma once

#include "projection/affine.hpp"

namespace trevi {

/// Writes −act · (a + B y), m, of the particles of a cell, as the scalar 0; `act` is that of all particles.
template <class T>
void remove_smooth(const CellFrame& frame, const Motion& shifts, const CellParticles& cell, const AffineMap& smooth,
                   std::span<const T> act, Vec4<T>* out);
template <>
void remove_smooth(const CellFrame& frame, const Motion& shifts, const CellParticles& cell, const AffineMap& smooth,
                   std::span<const float> act, Vec4<float>* out);
template <>
void remove_smooth(const CellFrame& frame, const Motion& shifts, const CellParticles& cell, const AffineMap& smooth,
                   std::span<const double> act, Vec4<double>* out);

/// v += act · B (Δ − the mean of Δ over the particles of the cell, weighted by act) with the slopes B, 1/s.
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
