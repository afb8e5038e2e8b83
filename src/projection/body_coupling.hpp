// Rigid bodies that move freely in the projection: their velocities are unknowns beside the pressure. A change of a
// body's twist changes the flux through the closed parts of faces, which is the right-hand side; the pressure on its
// surface changes the twist (RigidBodies::respond()). The two are brought together between the cycles of the multigrid,
// on cells that stay as they were cut where the body was expected. Collective: solve().
#pragma once

#include <vector>

#include "projection/pressure.hpp"
#include "projection/record_beside.hpp"

namespace trevi {

class BodyCoupling {
 public:
  BodyCoupling(MPI_Comm comm, CutCells& cuts, Obstacles& obstacles, Real h)
      : comm_(comm), cuts_(cuts), obstacles_(obstacles), pushes_(obstacles.floating()->count(), h) {}

  /// What moves the bodies: `forces` knows the pressure on cells, `beside` what else their closed faces give to the
  /// water, which is where `order` has particles.
  struct Water {
    const FreeSurface& surface;
    const RecordForces& forces;
    const RecordBeside& beside;
    const CellOrder& order;
  };
  /// Pressure, of which the equation is assembled, and bodies.
  void solve(Pressure& pressure, Halo& halo, const Water& water);

 private:
  std::vector<Six> pressed(const Water& water);
  void add_cell(LocalId k, LocalId r, LocalId c, const Water& water);

  MPI_Comm comm_;
  CutCells& cuts_;
  Obstacles& obstacles_;
  ImpulseLedger pushes_;  // of the pressure of the moment
};

}  // namespace trevi
