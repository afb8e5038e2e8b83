// Coarse-grid correction of the density solve. Sweeps over particles move a disturbance by about h each, so deep water
// needs as many of them as it has layers; the smooth part of the correction is found here instead, on the cell grid.
//
// A displacement field u changes the constraint by −b div u (b of the start lattice). With u = ∇phi:
//   ∇² phi = C/b  in cells that hold water,  phi = 0 in empty cells,  no flux through walls,
// C the mean constraint of a cell, not below 0, as surface cells miss neighbours. Finite volumes, Chebyshev sweeps
// whose number follows the depth of the water; no dot products, so the same bits on any rank count. Particles take the
// face displacements of their cell, linear in between (lowest-order Raviart-Thomas), so div u is C/b in each cell.
// Using the gradient instead of multipliers leaves out their geometric stiffness, which explodes at large dt.
// Collective.
#pragma once

#include <array>
#include <span>
#include <vector>

#include "trevi/domain/halo.hpp"
#include "trevi/domain/slabs.hpp"
#include "trevi/fluid/density.hpp"
#include "trevi/parallel/log.hpp"
#include "trevi/parallel/session.hpp"

namespace trevi {

class CoarseCorrection {
 public:
  /// `spacing` of the start lattice, m, gives b.
  CoarseCorrection(MPI_Comm comm, const DensityModel& model, Real spacing, const CellGrid& grid, const Box& box);

  /// Displacements, m, of the owned particles at p* in `order`, from their densities rho (kg/m³).
  template <class T>
  void displacements(const CellOrder& order, Halo& halo, std::span<const Real> rho, std::span<const Vec3> p,
                     std::span<Quad<T>> out);

  std::size_t bytes() const { return 4 * phi_.capacity() * sizeof(Real) + depth_.capacity() * sizeof(LocalId); }

 private:
  // Cells with a ring of empty ones around each plane, and a ghost plane on either side.
  std::size_t stride_row() const { return static_cast<std::size_t>(columns_) + 2; }
  std::size_t stride_plane() const { return (static_cast<std::size_t>(rows_) + 2) * stride_row(); }
  std::size_t row_start(LocalId k, LocalId r) const {
    return static_cast<std::size_t>(k) * stride_plane() + (static_cast<std::size_t>(r) + 1) * stride_row() + 1;
  }
  bool holds_water(const CellOrder& order, LocalId k, LocalId c) const {
    return static_cast<Real>(order.start(k, c + 1) - order.start(k, c)) >= least_particles_;
  }
  void fill_sources(const CellOrder& order, std::span<const Real> rho);
  int deepest_water(const CellOrder& order) const;
  void sweep_plane(LocalId k, Real omega);
  void solve(const CellOrder& order, Halo& halo);
  struct Faces;
  Faces faces_of(LocalId k, LocalId r, LocalId c) const;
  Real through_face(std::size_t low, std::size_t high, Real per_length, bool& known) const;

  MPI_Comm comm_;
  Event event_{"CoarseGrid"};
  DensityModel model_;
  Box box_;
  int slab_axis_;
  LocalId rows_, columns_;
  LocalId last_plane_ = 0;         // of this rank, in its own count
  std::array<Real, 3> last_cell_;  // of the box, along slab axis, rows, columns
  Vec3 cell_;                      // size along slab axis, rows, columns, m
  Vec3 weight_;                    // 1/size², 1/m²
  Real per_b_;
  Real full_, least_particles_;
  std::vector<Real> source_;          // C/b, 1
  std::vector<Real> per_diagonal_;    // 1/Σ weights of the faces that are no walls, m²; 0 in empty cells
  std::vector<Real> phi_, previous_;  // m²
  std::vector<LocalId> depth_;        // per row of owned planes: columns to be swept
};

}  // namespace trevi
