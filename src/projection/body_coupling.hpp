// Freely moving rigid bodies in the projection: their velocities are unknowns in addition to the pressure. A change of
// the twist of a body changes the flux through the closed parts of faces, which is the right-hand side; the pressure on
// its surface changes the twist (RigidBodies::respond()). The two are iterated between the cycles of the multigrid,
// while the cells remain as they were cut at the expected position of the body. Collective: solve().
#pragma once

#include <vector>

#include "projection/contact_films.hpp"
#include "projection/pressure.hpp"
#include "projection/record_beside.hpp"

namespace trevi {

class BodyCoupling {
 public:
  BodyCoupling(MPI_Comm comm, CutCells& cuts, Obstacles& obstacles, Real h)
      : comm_(comm),
        cuts_(cuts),
        obstacles_(obstacles),
        pushes_(obstacles.floating()->count(), h),
        films_(comm, cuts, obstacles, h) {}

  /// The water that moves the bodies: `forces` has the pressure on cells, and `beside` the further impulses that closed
  /// faces give to the water, which is where `order` has particles, `spacing` m apart.
  struct Water {
    const FreeSurface& surface;
    const RecordForces& forces;
    const RecordBeside& beside;
    const CellOrder& order;
    Real spacing;
  };
  /// Solves for the pressure, whose equation is assembled, and for the bodies.
  void solve(Pressure& pressure, Halo& halo, const Water& water);
  /// Records what the films between bodies and what they touch give, by the last pressure.
  void record_films() const { films_.record(); }

 private:
  std::vector<Six> pressed(const Water& water);
  void add_cell(LocalId k, LocalId r, LocalId c, const Water& water);

  MPI_Comm comm_;
  CutCells& cuts_;
  Obstacles& obstacles_;
  ImpulseLedger pushes_;  // of the present pressure
  ContactFilms films_;
};

}  // namespace trevi
