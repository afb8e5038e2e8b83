#include "projection/body_coupling.hpp"

#include "projection/parameters.hpp"

namespace trevi {

void BodyCoupling::add_cell(LocalId k, LocalId r, LocalId c, const Water& water) {
  const RigidBodies& bodies = *obstacles_.floating();
  const std::size_t at = water.surface.grid().index(k, r, c);
  if (!cuts_.is_pushed(at)) return;
  const Pushes pushes = water.forces.pushes_of_cell(k, r, c);
  for (std::size_t n = 0; n < pushes.count; ++n) {
    if (!bodies.holds(pushes.solid[n])) continue;
    const auto& [shift, arm] = pushes.all[n];
    const Impulse push{shift, arm - bodies.center(pushes.solid[n])};
    pushes_.add(pushes.solid[n] - bodies.first(), {&push, 1});
  }
  if (!cuts_.floats(at)) return;
  const Vec3 given = water.beside.of_body(k, r, c, water.order);
  if (!given.isZero(0)) pushes_.add(cuts_.nearest(at) - bodies.first(), TotalImpulse{given, Vec3::Zero()});
}

// Each thread sums its rows in integers, so the result does not depend on the order.
std::vector<Six> BodyCoupling::pressed(const Water& water) {
  const ProjectionGrid& grid = water.surface.grid();
  RigidBodies& bodies = *obstacles_.floating();
  pushes_.clear();
  for_each_row(grid.rows_of({1, grid.planes() + 1}), [&](LocalId k, LocalId r) {
    const Range cut = cuts_.cut_columns(k, r);
    for (LocalId c = cut.begin; c < std::min(cut.end, grid.columns(k, r)); ++c) add_cell(k, r, c, water);
  });
  std::vector<TotalImpulse> all = pushes_.total(comm_);
  const std::vector<TotalImpulse>& films = films_.press(water.surface, water.forces, water.spacing);
  for (std::size_t k = 0; k < films.size(); ++k) all[k] += films[k];
  std::vector<Six> impulses;
  for (std::size_t k = 0; k < all.size(); ++k) impulses.push_back(bodies.take_pressure(k, all[k]));
  return impulses;
}

void BodyCoupling::solve(Pressure& pressure, Halo& halo, const Water& water) {
  RigidBodies& bodies = *obstacles_.floating();
  const FreeSurface& surface = water.surface;
  films_.find(surface);
  films_.displace(surface, pressure);
  pressure.balance(surface, halo);
  pressure.begin(halo);
  pressure.show(surface, halo);
  std::vector<Six> pressure_on = pressed(water);
  for (int iteration = 0; iteration < projection::max_coupling_iterations; ++iteration) {
    if (iteration >= projection::min_coupling_iterations &&
        bodies.is_settled(pressure_on, projection::coupling_tolerance))
      break;
    bodies.respond(pressure_on);
    cuts_.move_faces([&](std::size_t a, std::size_t at, Real change) { pressure.move_face(surface, a, at, change); });
    films_.displace(surface, pressure);
    pressure.balance(surface, halo);
    pressure.improve(halo, projection::cycles_per_answer);
    pressure.show(surface, halo);
    pressure_on = pressed(water);
  }
  bodies.hear(pressure_on);
  pressure.finish(surface, halo);
}

}  // namespace trevi
