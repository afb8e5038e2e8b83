// The projection: finds on the cell grid what sweeps over pairs of particles cannot, the pressure over long distances,
// and makes the water's motion free of divergence by it. A sweep carries a disturbance by about h, so deep water would
// need as many as it has layers. The projection works with the particles' displacements, not with their densities:
// those are noisy for ever, and a grid that followed them would lift deep water by that noise. Similar in purpose to
// Kugelstadt et al., Implicit density projection for volume conserving liquids, IEEE TVCG 2019.
//
// Its stages, each in a file of its own: particles_to_grid, free_surface (classify), pressure (assemble, solve),
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
  /// `spacing` of the start lattice, m; `gravity` downwards, m/s², or 0.
  struct Model {
    Real spacing, h, gravity;
  };
  /// `obstacles` may be null.
  Projection(MPI_Comm comm, const CellGrid& grid, const Box& box, const Model& model, Obstacles* obstacles = nullptr,
             const std::shared_ptr<Scratch>& scratch = std::make_shared<Scratch>());

  /// Shows its pressure from now on.
  void show_to(PressureProbes* probes) { probes_ = probes; }
  /// Water goes through them from now on; may be null.
  void open_to(Openings* openings) {
    openings_ = openings;
    surface_.open_to(openings);
  }

  /// Finds what displacements() tells of the owned particles in `order` for their motion in the time dt, s.
  void find(const CellOrder& order, Halo& halo, Real dt, const Motion& motion);
  /// To be called once after that: displacements, m, and as the scalar how far the grid acts on each of them, from 0 to
  /// 1. Memory that was borrowed in find() is given back, but for what filter_shifts() and carry_velocities() need.
  template <class T>
  void displacements(const CellOrder& order, Real dt, const Motion& motion, std::span<Vec4<T>> out);

  /// Minus the smooth part of the shifts, m, of the owned particles.
  template <class T>
  void filter_shifts(const CellOrder& order, Halo& halo, const Swept<T>& swept, std::span<Vec4<T>> out);
  /// Gives shifted particles, in the time dt, s, the velocities of where they are, m/s (carry_cell() of
  /// cell_shifts.hpp), of which the sum over a cell is 0.
  template <class T>
  void carry_velocities(const CellOrder& order, const Swept<T>& swept, Real dt, std::span<Vec3> velocity) const;

  /// To be called when no more is needed of a substep.
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
  std::unique_ptr<CutCells> cuts_;  // null where there are no obstacles
  ParticlesToGrid particles_to_grid_;
  FreeSurface surface_;
  Pressure pressure_;
  FaceShares shares_;
  GridToParticles grid_to_particles_;
  ShiftFilter shift_filter_;
  Obstacles* obstacles_;
  PressureProbes* probes_ = nullptr;
  Openings* openings_ = nullptr;
  std::unique_ptr<BodyCoupling> coupling_;  // null where no body moves freely
};

}  // namespace trevi
