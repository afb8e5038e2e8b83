// The Poisson equation of the coarse-grid correction: displacements u = ∇phi that, added to the predicted displacements
// d of the cell faces, leave no divergence,
//   div(u + d) = r  in wet cells,   phi = 0 at the free surface,   u + d = 0 through walls,
// where r slowly returns each cell to its volume. The surface lies where the water ends, not at the edge of a cell (the
// ghost-fluid method: Gibou et al., J. Comput. Phys. 176, 2002; Enright et al. 2003): the face above a top cell has the
// weight 1/theta, theta being the height of the surface above the middle of the cell in cells; a face at its side has
// the share of its area that is under water as its weight.
//
// Solved by V-cycles of a multigrid (coarse_multigrid.hpp) from the hydrostatic pressure of each column, which is the
// exact solution for water at rest. Their number is fixed: no dot products, hence the same bits on any rank count.
// Where water is torn apart phi would pull it together, so it is limited to values ≤ 0. Collective.
#pragma once

#include "solver/coarse_multigrid.hpp"
#include "solver/coarse_water.hpp"

namespace trevi {

class CoarsePressure {
 public:
  CoarsePressure(MPI_Comm comm, const Repeats& repeats) : multigrid_(comm, repeats) {}

  /// `fall`: how far gravity moves a particle down in the step, g dt², m. `return_share`: the share of a cell's
  /// deviation from its volume that this step undoes.
  void solve(const CoarseWater& water, Halo& halo, Real fall, Real return_share);

  /// Displacement through face (a, at) between two cells at least one of which is wet, m.
  Real displacement(const CoarseWater& water, std::size_t a, std::size_t at) const {
    const std::vector<Real>& phi = multigrid_.finest().phi;
    const std::size_t below = at - water.grid().step(a);
    const Real u = (phi[at] - phi[below]) / water.grid().size()[static_cast<Eigen::Index>(a)];
    return a == 2 && water.is_wet(below) && !water.is_wet(at) ? u / water.above_middle(below) : u;
  }

  /// phi of a cell, m².
  Real phi(std::size_t at) const { return multigrid_.finest().phi[at]; }

  std::size_t bytes() const { return multigrid_.bytes(); }

 private:
  void weigh_row(const CoarseWater& water, LocalId k, LocalId r);
  void find_sources(const CoarseWater& water, Real return_share, LocalId k, LocalId r);
  void leave_water(const CoarseWater& water, LocalId k, LocalId r);
  Real divergence(const CoarseWater& water, std::size_t at) const;
  void start_at_rest(const CoarseWater& water, Real fall, LocalId k, LocalId r);

  // Its links first hold the weight of each face: its area under water, as a share of the whole area, over the distance
  // between the points on its two sides where phi is given, in cells; 0 where nothing passes.
  CoarseMultigrid multigrid_;
};

}  // namespace trevi
