// Part of the last stage of the projection, in addition to record_forces: the impulses that closed faces give to the
// particles of a cut cell beyond the pressure of the cell, because they take the particles along with the solid and
// stop motion into it. These belong to the solid, while the remainder of the transfer belongs to no solid in
// particular. For a floating body they are computed as for water that fills the open part of the cell, if this holds
// any particle. Not collective; on any thread for rows.
#pragma once

#include "projection/grid_to_particles.hpp"
#include "projection/record_forces.hpp"

namespace trevi {

class RecordBeside {
 public:
  struct Sources {
    const FreeSurface& surface;
    const Pressure& pressure;
    const GridToParticles& transfer;
    const RecordForces& forces;
    const CellFrame& frame;
  };
  /// `spacing`, m; g dt², m.
  RecordBeside(const Sources& sources, Obstacles& obstacles, Real spacing, Real g_dt2)
      : from_(sources), obstacles_(obstacles), spacing_(spacing), g_dt2_(g_dt2) {}

  /// Records those of a row of cells.
  void of_row(LocalId k, LocalId r, const CellOrder& order, const Motion& motion) const;
  /// The impulse on a floating body in a cell that it cuts. It has no couple, because this would turn a light body. The
  /// pressure need not be the final one.
  Vec3 of_body(LocalId k, LocalId r, LocalId c, const CellOrder& order) const;

 private:
  CellParticles particles_of(LocalId k, LocalId r, LocalId c, const CellOrder& order) const;
  bool gives(std::size_t here) const;
  bool is_at_surface(std::size_t here) const;
  bool is_under_water(LocalId k, LocalId r, LocalId c) const;
  Vec3 of_full(const CellDisplacement& by, LocalId k, LocalId r, LocalId c, bool across) const;
  // Moments are about the centre of the box.
  TotalImpulse of_obstacle(LocalId k, LocalId r, LocalId c, const CellOrder& order, const Motion& motion) const;
  TotalImpulse of_particles(const CellDisplacement& by, const Motion& motion, const CellParticles& cell,
                            bool across) const;
  TotalImpulse of_pressure(LocalId k, LocalId r, LocalId c, bool across) const;
  Vec3 middle_of(const CellFace& face, LocalId k, LocalId r, LocalId c) const;
  Real beyond_own(const CellFace& face, LocalId k, LocalId r, LocalId c) const;

  Sources from_;
  Obstacles& obstacles_;
  Real spacing_, g_dt2_;
};

}  // namespace trevi
