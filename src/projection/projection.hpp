// The projection finds on the cell grid what sweeps over pairs of particles cannot, the pressure over long distances,
// and makes the motion of the water divergence-free. A sweep carries a disturbance by about h, so deep water would need
// as many sweeps as it has layers. The projection works with the displacements of the particles, not with their
// densities: densities are always noisy, and a grid that followed them would lift deep water by that noise. Its purpose
// is similar to that of Kugelstadt et al., Implicit density projection for volume conserving liquids, IEEE TVCG 2019.
//
// Its stages are in files of their own: particles_to_grid, free_surface (classify), pressure (assemble, solve),
// grid_to_particles, record_forces; and shift_filter after the sweeps. Displacements are used rather than multipliers,
// whose geometric stiffness becomes unstable at large dt. For gravity along −z, or none. Collective.
#pragma once

#include <memory>
#include <span>

#include "boundary/pressure_probes.hpp"
#include "fluid/constraint/density.hpp"
#include "parallel/log.hpp"
#include "projection/body_coupling.hpp"
#include "projection/face_shares.hpp"
#include "projection/grid_to_particles.hpp"
#include "projection/shift_filter.hpp"

namespace trevi {

class Projection {
 public:
  /// `spacing` of the initial lattice, m; `gravity` downwards, m/s², or 0.
  struct Model {
    Real spacing, h, gravity;
  };
  /// `obstacles` may be null.
  Projection(MPI_Comm comm, const CellGrid& grid, const Box& box, const Model& model, Obstacles* obstacles = nullptr,
             const std::shared_ptr<Scratch>& scratch = std::make_shared<Scratch>());

  /// From now on the projection shows its pressure to `probes`; may be null.
  void show_to(PressureProbes* probes) { probes_ = probes; }
  /// From now on water flows through `openings`; may be null.
  void open_to(Openings* openings) {
    openings_ = openings;
    surface_.open_to(openings);
  }

  /// Solves for the owned particles in `order` and their motion in the time dt, s; displacements() returns the result.
  void find(const CellOrder& order, Halo& halo, Real dt, const Motion& motion);
  /// To be called once after that. Writes displacements, m, and as the scalar the degree to which the grid acts on each
  /// particle, from 0 to 1. Memory that was borrowed in find() is given back, except for what filter_shifts() and
  /// carry_velocities() need.
  template <class T>
  void displacements(const CellOrder& order, Real dt, const Motion& motion, std::span<Vec4<T>> out);

  /// Writes minus the smooth part of the shifts, m, of the owned particles.
  template <class T>
  void filter_shifts(const CellOrder& order, Halo& halo, const Swept<T>& swept, std::span<Vec4<T>> out);
  /// Gives shifted particles the velocities of their new positions, m/s, for the time dt, s (carry_cell() of
  /// cell_shifts.hpp). The changes add up to 0 over a cell.
  template <class T>
  void carry_velocities(const CellOrder& order, const Swept<T>& swept, Real dt, std::span<Vec3> velocity) const;

  /// To be called when nothing of a substep is needed any more.
  void give_back();

  std::size_t bytes() const;

 private:
  void measure_rows(const CellOrder& order, Halo& halo);
  void solve(const CellOrder& order, Halo& halo, const Pressure::Step& step);
  CellRows own_rows() const { return grid_.rows_of({1, grid_.planes() + 1}); }
  template <class T>
  void record_forces(const CellOrder& order, Real g_dt2, const Motion& motion, std::span<Vec4<T>> out) const;

  Event event_{"CoarseGrid"};
  MPI_Comm comm_;
  Model model_;
  Box box_;
  ProjectionGrid grid_;
  ActiveRows rows_;
  std::unique_ptr<CutCells> cuts_;  // null if there are no obstacles
  ParticlesToGrid particles_to_grid_;
  FreeSurface surface_;
  Pressure pressure_;
  FaceShares shares_;
  GridToParticles grid_to_particles_;
  ShiftFilter shift_filter_;
  Obstacles* obstacles_;
  PressureProbes* probes_ = nullptr;
  Openings* openings_ = nullptr;
  std::unique_ptr<BodyCoupling> coupling_;  // null if no body moves freely
};

}  // namespace trevi
