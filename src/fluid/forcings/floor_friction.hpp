// Friction of the floor of the box (walls.floor_friction). Not collective.
#pragma once

#include "parallel/log.hpp"
#include "trevi/forcing.hpp"

namespace trevi {

/// Skin friction of the floor: a shear stress c_f/2 rho |u| u against the horizontal velocity u, with c_f the
/// coefficient of a flat plate (White, Fluid Mechanics, 7.4). The stress acts on the water within h of the floor with
/// the weight w(d) = 2/h (1 − d/h) at height d, whose integral is 1, so that the force per area does not depend on the
/// spacing: du/dt = −c_f/2 w(d) |u| u, solved exactly over a step at constant d. It never adds energy or reverses a
/// velocity.
class FloorFriction : public Forcing {
 public:
  /// `floor` is the height of the floor, m; h the kernel radius, m.
  FloorFriction(Real coefficient, Real floor, Real h)
      : event_("FloorFriction"), coefficient_(coefficient), floor_(floor), h_(h) {}
  void apply(Particles& particles, const StepInfo& info) override;

 private:
  Event event_;
  Real coefficient_, floor_, h_;
};

}  // namespace trevi
