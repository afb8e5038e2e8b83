// The projection: finds on the cell grid what sweeps over pairs of particles cannot, the pressure over long ways, and makes
// the water's motion free of divergence by it. A sweep carries a disturbance by about h, so deep water would need as many
// as it has layers. The projection works with the particles' displacements, not with their densities: those are noisy for
// ever, and a grid that followed them would lift deep water by that noise. Similar in purpose to Kugelstadt et al.,
// Implicit density projection for volume conserving liquids, IEEE TVCG 2019.
//
// Its stages, each in a file of its own: particles_to_grid, free_surface (classify), pressure (assemble, solve),
// grid_to_particles, record_forces; and shift_filter after the sweeps. Displacements are used rather than multipliers,
// whose geometric stiffness becomes unstable at large dt. For gravity along −z, or none. Collective.
#pragma once

#include <memory>
#include <span>

#include "fluid/density.hpp"
#include "parallel/log.hpp"
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
  Projection(MPI_Comm comm, const CellGrid& grid, const Box& box, const Model& model, Obstacles* obstacles = nullptr);

  /// Displacements, m, of the owned particles in `order` for their motion in the time dt, s, and as the scalar how far the
  /// grid acts on each of them, from 0 to 1.
  template <class T>
  void displacements(const CellOrder& order, Halo& halo, Real dt, const Motion& motion, std::span<Vec4<T>> out);

  /// What the sweeps after that have done: shifts of positions from x to p, where the grid acts (0 to 1), and the density
  /// of the particles afterwards.
  template <class T>
  struct Swept {
    Motion shifts;
    std::span<const T> act;
    std::span<const Real> density;
    Real rest_density;
  };
  /// Finds the smooth part of the shifts.
  template <class T>
  void filter(const CellOrder& order, Halo& halo, const Swept<T>& swept);
  /// Calls use(i, correction of the position, slope of the motion) for the owned particles: the smooth part of the shift, to be
  /// taken off, and the displacement of the water along a shift, m per m.
  template <class T, class Use>
  void for_each_shift(const CellOrder& order, const Swept<T>& swept, const Use& use) const;

  std::size_t bytes() const;

 private:
  void measure_rows(const CellOrder& order, Halo& halo);
  void clear_row(LocalId k, LocalId r);
  template <class T>
  void displace_row(const CellOrder& order, const Motion& motion, LocalId k, LocalId r, std::span<Vec4<T>> out);

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
  GridToParticles grid_to_particles_;
  ShiftFilter shift_filter_;
  Obstacles* obstacles_;
};

template <class T, class Use>
void Projection::for_each_shift(const CellOrder& order, const Swept<T>& swept, const Use& use) const {
  const ByAxis& per_length = particles_to_grid_.frame().per_length;
  for_each_row(grid_.rows_of({1, grid_.planes() + 1}), [&](LocalId k, LocalId r) {
    for (LocalId c = 0; c < grid_.columns(k, r); ++c) {
      const CellParticles cell = particles_to_grid_.particles_of(order, swept.shifts, k, r, c);
      if (cell.begin == cell.end) continue;
      const std::size_t at = grid_.index(k, r, c);
      const AffineMap& fit = particles_to_grid_.fit(at);
      Eigen::Matrix3d slope;
      for (std::size_t a = 0; a < 3; ++a) {
        for (std::size_t b = 0; b < 3; ++b)
          slope(static_cast<Eigen::Index>(a), static_cast<Eigen::Index>(b)) = fit.b[a][b] * per_length[b];
      }
      for (std::size_t i = cell.begin; i < cell.end; ++i) {
        const Real act = static_cast<Real>(swept.act[i]);
        if (act == 0) continue;
        ByAxis y{};
        for (std::size_t a = 0; a < 3; ++a) {
          const auto b = static_cast<Eigen::Index>(a);
          y[a] = (0.5 * (swept.shifts.x[i][b] + swept.shifts.p[i][b]) - cell.place.origin[a]) * per_length[a] - cell.place.corner[a];
        }
        use(i, Vec3(act * shift_filter_.smooth(at, y)), Eigen::Matrix3d(act * slope));
      }
    }
  });
}

}  // namespace trevi
