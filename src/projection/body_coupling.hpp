// Rigid bodies that move freely in the projection: their velocities are unknowns beside the pressure. A change of a
// body's twist changes the flux through the closed parts of faces, which is the right-hand side; the pressure on its
// surface changes the twist (RigidBodies::respond()). The two are brought together between the cycles of the multigrid,
// on cells that stay as they were cut where the body was expected. Collective: solve().
#pragma once

#include <vector>

#include "projection/pressure.hpp"
#include "projection/record_forces.hpp"

namespace trevi {

class BodyCoupling {
 public:
  BodyCoupling(MPI_Comm comm, CutCells& cuts, Obstacles& obstacles, Real h)
      : comm_(comm), cuts_(cuts), obstacles_(obstacles), pushes_(obstacles.floating()->count(), h) {}

  /// Pressure and bodies; `record` knows the pressure on cells.
  void solve(Pressure& pressure, const FreeSurface& surface, Halo& halo, const Pressure::Step& step,
             const RecordForces& record);

 private:
  std::vector<Six> pressed(const FreeSurface& surface, const RecordForces& record);

  MPI_Comm comm_;
  CutCells& cuts_;
  Obstacles& obstacles_;
  ImpulseLedger pushes_;  // of the pressure of the moment
};

}  // namespace trevi
