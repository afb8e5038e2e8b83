// The Poisson equation of the coarse-grid correction: displacements u = ∇phi that make what the particles mean to do
// free of divergence,
//   div(u + d) = r  in wet cells,   phi = 0 at the free surface,   u + d = 0 through walls,
// with d the displacements of the faces and r a slow return of each cell to its volume. The surface is where the water
// ends, not at the edge of a cell: the face above a top cell has the weight 1/theta, theta the height of the surface
// above the middle of the cell in cells (the ghost-fluid method: Gibou et al., J. Comput. Phys. 176, 2002; Enright et
// al. 2003), and the faces at its sides the area that is under water.
//
// Chebyshev semi-iteration over damped Jacobi sweeps, whose number follows the depth of the water, from the hydrostatic
// pressure of each column, so that water at rest is solved exactly from the start: no dot products, thus the same bits
// on any rank count. Where water is torn apart phi would pull; it is cut at 0. Collective.
#pragma once

#include "solver/coarse_water.hpp"

namespace trevi {

class CoarsePressure {
 public:
  /// `fall`: how far gravity moves a particle down in the step, g dt², m. `return_share` of a cell's deviation from its
  /// volume is undone.
  void solve(const CoarseWater& water, Halo& halo, Real fall, Real return_share);

  /// Displacement through face (a, at) between two cells at least one of which is wet, m.
  Real displacement(const CoarseWater& water, std::size_t a, std::size_t at) const;

  std::size_t bytes() const;

 private:
  void weigh_faces(const CoarseWater& water);
  void weigh_row(const CoarseWater& water, LocalId k, LocalId r);
  void find_sources(const CoarseWater& water, Real return_share);
  Real divergence(const CoarseWater& water, std::size_t at) const;
  void start_at_rest(const CoarseWater& water, Real fall);
  void sweep_plane(const CoarseGrid& grid, LocalId k, Real omega);
  static std::size_t row_of(const CoarseGrid& grid, LocalId k, LocalId r) {
    return static_cast<std::size_t>(k) * static_cast<std::size_t>(grid.rows()) + static_cast<std::size_t>(r);
  }

  // Area of each face under water, in shares of the whole, over the distance between what is on either side, in cells.
  // 0 where nothing passes.
  std::array<std::vector<Real>, 3> weight_;
  std::vector<std::size_t> wet_columns_;  // of each row: those that a sweep must look at; phi is 0 above them
  std::vector<Real> source_;              // div u, 1
  std::vector<Real> per_diagonal_;        // 1/Σ weights of the faces over their size², m²; 0 in dry cells
  std::vector<Real> phi_, previous_;      // m²
};

}  // namespace trevi
