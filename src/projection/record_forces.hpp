// Last stage of the projection: it records the impulses of the pressure on obstacles, box and gauges in the impulse
// sums of the obstacles. Not collective; on any thread for rows.
#pragma once

#include <array>
#include <span>

#include "projection/pressure.hpp"

namespace trevi {

class RecordForces {
 public:
  /// `fall`: g dt², m.
  RecordForces(const FreeSurface& surface, const Pressure& pressure, Obstacles& obstacles, Real spacing, Real g_dt2)
      : surface_(surface), pressure_(pressure), obstacles_(obstacles), spacing_(spacing), g_dt2_(g_dt2) {}

  /// Obstacles and box receive the pressure of the cells on their surface. The difference between this and the impulses
  /// on the particles of the row, which are displaced by `moved` at the positions `from`, is recorded as the remainder
  /// (Obstacles::total()).
  template <class T>
  void of_row(LocalId k, LocalId r, std::span<const Vec4<T>> moved, std::span<const Vec3> from) const;
  void of_gauges(const Box& box) const;
  /// The impulses that the pressure of a cut cell gives to the water (CutCells::pushes()), for all of its particles.
  Pushes pushes_of_cell(LocalId k, LocalId r, LocalId c) const;
  /// The pressure on a vertical side of a cell up to the height of the water, averaged over the whole side, m².
  Real on_side(std::size_t at) const;
  /// The pressure at a height in a cell, which is 0 to 1 from its lower to its upper face, or beyond these, m².
  Real at_height(std::size_t at, Real height) const;
  /// The growth of the pressure of water at rest downwards, m.
  Real g_dt2() const { return g_dt2_; }

 private:
  Pushes shifts_of_cell(LocalId k, LocalId r, LocalId c) const;
  TotalImpulse of_cell(LocalId k, LocalId r, LocalId c) const;
  Real fall_at(std::size_t top) const;
  TotalImpulse of_walls(LocalId k, LocalId r, LocalId c) const;
  Real phi_at(LocalId k, LocalId r, Real height) const;

  const FreeSurface& surface_;
  const Pressure& pressure_;
  Obstacles& obstacles_;
  Real spacing_, g_dt2_;
};

}  // namespace trevi
