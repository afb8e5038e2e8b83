// A run with bodies that move freely, and the pool in which they do.
#pragma once

#include <string>
#include <vector>

#include "boundary/rigid_bodies/rigid_body.hpp"
#include "support/kept_run.hpp"
#include "support/tank.hpp"

namespace trevi::test {

inline const std::string pool = tank_with_gravity({.max = "1.6, 1.2, 2.0", .water = {{"0, 0, 0", "1.6, 1.2, 1.0"}}});

struct BodyRun : KeptRun {
  BodyRun(MPI_Comm comm, const std::string& text, const std::vector<std::string>& overrides = {})
      : KeptRun(comm, parse_scene("test.toml", text, overrides)) {}
  BodyRun(MPI_Comm comm, const Scene& of) : KeptRun(comm, of) {}
  std::vector<BodyState> bodies() const { return solver->bodies(); }
  /// Of water and bodies, J.
  Real energy() const {
    Real sum = rows.back().kinetic_energy + rows.back().potential_energy;
    for (std::size_t k = 0; k < scene.bodies.size(); ++k) {
      RigidBody body(scene.bodies[k], *make_shape(scene.bodies[k]), *scene.gravity, 1000);
      body.set_state(bodies()[k]);
      sum += body.energy();
    }
    return sum;
  }
};

}  // namespace trevi::test
