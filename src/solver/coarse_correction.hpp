// Coarse-grid correction of the density solve. One iteration over the particles carries a disturbance by about h, so
// deep water needs as many iterations as it has layers. This correction finds the long-range part of the pressure on
// the cell grid instead: it takes the mean displacements that the prediction gives the particles of each cell face
// (coarse_water.hpp) and finds those nearest to them that keep the volume (coarse_pressure.hpp). It does not use
// densities: they are noisy, the inequality constraint keeps only their positive part, and a grid that followed them
// would lift deep water by that noise. Similar in purpose to Kugelstadt et al., Implicit density projection for volume
// conserving liquids, IEEE TVCG 2019.
//
// A particle takes the displacement of the faces of its cell, linear in between (lowest-order Raviart-Thomas).
// Displacements are used rather than multipliers, whose geometric stiffness becomes unstable at large dt. Above the
// surface the correction fades out, so that water thrown up falls back. In addition each particle's motion relaxes to
// that of its cell, with the time constant `noise_time`: this damps noise on which no pressure acts, and of a wave only
// the shear within a cell. For gravity along −z. Collective.
#pragma once

#include <span>

#include "fluid/density.hpp"
#include "parallel/log.hpp"
#include "solver/coarse_pressure.hpp"

namespace trevi {

class CoarseCorrection {
 public:
  /// `spacing` of the start lattice, m; `gravity` downwards, m/s².
  struct Model {
    Real spacing, h, gravity;
  };
  /// `obstacles` may be null.
  CoarseCorrection(MPI_Comm comm, const CellGrid& grid, const Box& box, const Model& model,
                   Obstacles* obstacles = nullptr);

  /// Displacements, m, of the owned particles in `order` for their motion in the time dt, s.
  template <class T>
  void displacements(const CellOrder& order, Halo& halo, Real dt, const Motion& motion, std::span<Vec4<T>> out);

  std::size_t bytes() const { return water_.bytes() + pressure_.bytes(); }

 private:
  /// The share of the motion against its cell that a particle there loses in the substep.
  Real noise_share(std::size_t at) const;
  CellDisplacement displacement_of(LocalId k, LocalId r, LocalId c) const;
  bool is_closed(std::size_t a, std::size_t face, bool wall) const { return wall || water_.face(a, face) == 0; }
  Real through_closed(std::size_t a, std::size_t face) const;
  template <class T>
  void tell_of_row(LocalId k, LocalId r, std::span<const Vec4<T>> moved);
  void tell_of_cell(LocalId k, LocalId r, LocalId c);
  void tell_gauges();
  Real phi_at(LocalId k, LocalId r, Real height) const;

  Event event_{"CoarseGrid"};
  Model model_;
  CoarseWater water_;
  CoarsePressure pressure_;
  Obstacles* obstacles_;
  Real fall_ = 0;                    // g dt², m
  Real share_ = 0, per_noise2_ = 0;  // of the damping in this step, see CellDisplacement
};

}  // namespace trevi
