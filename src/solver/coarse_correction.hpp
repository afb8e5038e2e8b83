// Coarse-grid correction of the density solve. Sweeps over particles move a disturbance by about h each, so deep water
// needs as many of them as it has layers; pressure over longer ways is found here instead, on the cell grid: from what
// the grid can know without noise, the displacements that the particles mean to make (coarse_water.hpp), it finds those
// that keep the volume (coarse_pressure.hpp). Densities are left to the sweeps; their sign is rectified there, and a
// grid that followed them would lift deep water by their noise. Near to Kugelstadt et al., Implicit density projection
// for volume conserving liquids, IEEE TVCG 2019.
//
// Particles take the face displacements of their cell, linear in between (lowest-order Raviart-Thomas). Using
// displacements instead of multipliers leaves out their geometric stiffness, which explodes at large dt. In the top
// layer of water the correction fades out above the surface, so that what is thrown up falls back. Besides, the motion
// of each particle is drawn to that of its cell, with a time of `noise_time`: this takes the noise that no pressure
// acts on, and from a wave only what it shears within a cell. For gravity along −z. Collective.
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
  CoarseCorrection(MPI_Comm comm, const CellGrid& grid, const Box& box, const Model& model);

  /// Displacements, m, of the owned particles in `order`, which go from x to p in the time dt, s.
  template <class T>
  void displacements(const CellOrder& order, Halo& halo, Real dt, std::span<const Vec3> x, std::span<const Vec3> p,
                     std::span<Vec4<T>> out);

  std::size_t bytes() const { return water_.bytes() + pressure_.bytes(); }

 private:
  // The displacements through the lower and upper faces of a cell: of the correction, and those of the particles.
  struct Faces {
    Vec3 low, high, mean_low, mean_high;
    bool wet = false;
    Real surface = 0;  // height above the floor of the box, in cells; far up where the water goes on above
  };
  Faces faces_of(LocalId k, LocalId r, LocalId c) const;
  // The share of its motion against the cell that a slow particle loses, and how far it comes, m, with half of that.
  struct Damping {
    Real share, noise;
  };
  Vec3 displacement(const Faces& faces, const Damping& damping, const Vec3& x, const Vec3& p) const;

  Event event_{"CoarseGrid"};
  Model model_;
  CoarseWater water_;
  CoarsePressure pressure_;
};

}  // namespace trevi
