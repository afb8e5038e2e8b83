// Inlets: the amount and the places, on any ranks and for any step.
#include "flow_scenes.hpp"

namespace trevi::test {
namespace {

// Without gravity the jet stays a lattice, and with it the amount is the same.
TEST(Inlet, BringsWhatIsAskedInAnyStep) {
  constexpr Real flow = 0.25, seconds = 1.2;
  for (const Real dt : {0.003, 0.0166666667, 0.05}) {
    for (const char* weight : {"", "[gravity]\n"}) {
      SCOPED_TRACE(fmt::format("dt {} s {}", dt, weight));
      const Scene scene = scene_with(shaft + weight + jet + "flow = 0.25\n" + bottom, {fmt::format("time.dt={}", dt)});
      const std::unique_ptr<Solver> solver = solver_of(world, scene);
      run(*solver, seconds);
      const auto volume = static_cast<Real>(solver->flow()->inflow) * spacing * spacing * spacing;
      const Real layer = 12 * spacing * spacing * spacing;
      EXPECT_NEAR(volume, flow * solver->clock().time(), layer * 1.01);
      EXPECT_GT(volume, flow * solver->clock().time() * 0.95);
      EXPECT_EQ(solver->flow()->inflow - solver->flow()->outflow, total(*solver));
    }
  }
}

// Over a longer time the last layer hardly counts.
TEST(Inlet, BringsWhatIsAskedToOnePercent) {
  const Scene scene = scene_with(shaft + "[gravity]\n" + jet + bottom, {"inlet.0.speed=5.3"});
  const std::unique_ptr<Solver> solver = solver_of(world, scene);
  run(*solver, 2);
  const Real asked = 12 * 5.3 * solver->clock().time() / spacing;
  EXPECT_NEAR(static_cast<Real>(solver->flow()->inflow) / asked, 1, 0.01);
  EXPECT_GT(solver->flow()->outflow, 0);
}

TEST(Inlet, LayersAreASpacingApartInAnyStep) {
  for (const Real dt : {0.003, 0.0166666667, 0.05}) {
    for (const char* speed : {"0.7", "2.0", "7.0"}) {
      SCOPED_TRACE(fmt::format("dt {} s, {} m/s", dt, speed));
      const Scene scene =
          scene_with(shaft + jet, {fmt::format("inlet.0.speed={}", speed), fmt::format("time.dt={}", dt)});
      const std::unique_ptr<Solver> solver = solver_of(world, scene);
      run(*solver, 0.38);
      const Cloud water = gathered(world, solver->particles());
      ASSERT_GT(water.id.size(), 12U);
      EXPECT_EQ(water.id.size() % 12, 0U) << "a disc of 0.2 m has 12 places";
      for (std::size_t k = 0; k < water.id.size(); ++k) {
        EXPECT_EQ(water.id[k], static_cast<GlobalId>(k));
        const std::size_t below = k + 12;  // the place in the next layer
        if (below >= water.id.size()) continue;
        EXPECT_NEAR((water.position[below] - water.position[k] - Vec3(0, 0, spacing)).norm(), 0, 1e-9);
        EXPECT_NEAR((water.velocity[k] - Vec3(0, 0, -std::stod(speed))).norm(), 0, 1e-9);
      }
    }
  }
}

TEST(Inlet, WaitsForWaterWhereItRecycles) {
  const std::string small = "[[drain]]\nmin = [1.4, 0, 0]\nmax = [1.6, 0.9, 3]\n";
  const Scene scene = scene_with(shaft + "[gravity]\n" + jet + small, {"inlet.0.recycle=true", "inlet.0.speed=2"});
  const std::unique_ptr<Solver> solver = solver_of(world, scene);
  run(*solver, 0.5);
  EXPECT_EQ(total(*solver), 0);
  EXPECT_EQ(solver->flow()->inflow, 0);
}

// A full box has little room. With room again on one side, that side alone is filled.
TEST(Inlet, LeavesOutPlacesThatAreTaken) {
  const std::string full =
      tank_text({.max = "1.2, 0.6, 0.6", .water = {{"0, 0, 0", "1.2, 0.6, 0.6"}}, .dt = "0.01"}) + R"([[inlet]]
type = "rectangle"
center = [0.6, 0.3, 0.33]
direction = [0, 0, -1]
size = [0.4, 0.4]
speed = 1.0
)";
  // What enters pushes the water in a ring through the box, which makes 64 places free; the others are in the way.
  const std::unique_ptr<Solver> closed = solver_of(world, scene_with(full, {}));
  run(*closed, 0.5);
  EXPECT_LE(closed->flow()->inflow, 70) << "of 80 that were asked for";
  // The left half of the box is empty: only there places are free at first.
  const Scene half = scene_with(full, {"particles.0.min=[0.6, 0, 0]"});
  const std::unique_ptr<Solver> open = solver_of(world, half);
  for (int k = 0; k < 12; ++k) open->step();
  const Cloud water = gathered(world, open->particles());
  const GlobalId first_new = 6 * 6 * 6;
  EXPECT_EQ(open->flow()->inflow, 8);
  for (std::size_t k = 0; k < water.id.size(); ++k) {
    EXPECT_TRUE(water.id[k] < first_new || water.position[k].x() < 0.6);
  }
}

// No particle is made on top of another.
TEST(Inlet, KeepsHalfASpacingFromWater) {
  const Scene scene = scene_with(fountain, {"inlet.0.speed=1.0", "inlet.0.recycle=false"});
  const std::unique_ptr<Solver> solver = solver_of(world, scene);
  solver->start();
  GlobalId known = solver->flow()->next_id;
  for (int k = 0; k < 40; ++k) {
    const Cloud before = gathered(world, solver->particles());
    solver->step();
    // Those made in this step, where they were made: a step before where they are.
    const Cloud after = gathered(world, solver->particles());
    for (std::size_t i = 0; i < after.id.size(); ++i) {
      if (after.id[i] < known) continue;
      const Vec3 made = after.position[i] - solver->clock().dt * after.velocity[i];
      Real nearest = 1;
      for (const Vec3& p : before.position) nearest = std::min(nearest, (p - made).norm());
      EXPECT_GT(nearest, 0.45 * spacing);
    }
    known = solver->flow()->next_id;
  }
}
// Level jets: after x m beyond the nozzle all water has fallen for x/u s, however many layers a substep makes: it has
// that speed, and is on the parabola of its place in the nozzle. By the new velocity alone it was g dt/2 x/u too low.
TEST(Inlet, AJetHasOnePathInAnyStep) {
  const std::string level = "[[inlet]]\ncenter = [0.1, 0.45, 2.5]\ndirection = [1, 0, 0]\nradius = 0.2\n";
  for (const Real dt : {0.003, 0.0166666667, 0.05}) {
    for (const Real speed : {2.0, 7.0, 12.0}) {
      SCOPED_TRACE(fmt::format("dt {} s, {} m/s", dt, speed));
      const Scene scene = scene_with(shaft + "[gravity]\n" + level, {fmt::format("inlet.0.speed={}", speed),
                                                                     fmt::format("time.dt={}", dt), "time.cfl=0"});
      const std::unique_ptr<Solver> solver = solver_of(world, scene);
      run(*solver, 1.0 / speed);
      const Cloud water = gathered(world, solver->particles());
      ASSERT_GT(water.id.size(), 60U);
      for (std::size_t k = 0; k < water.id.size(); ++k) {
        const Real flown = std::max(0.0, water.position[k].x() - 0.1 - spacing) / speed;
        EXPECT_NEAR(water.velocity[k].z(), -9.8 * flown, 0.01) << water.position[k].x();
        EXPECT_NEAR(water.velocity[k].y(), 0, 1e-3);
        const Real place = (water.position[k].z() + 9.8 / 2 * flown * flown - 2.5) / spacing + 0.5;
        EXPECT_NEAR(place, std::round(place), 0.05) << water.position[k].x();
      }
    }
  }
}

// Of the energy of water that leaves a nozzle at `end` along `way` with that speed, what it has beyond, in the mean.
Real energy_kept(const Solver& solver, const Vec3& end, const Vec3& way, Real speed) {
  const Cloud water = gathered(world, solver.particles());
  EXPECT_EQ(solver.flow()->inflow, static_cast<GlobalId>(water.id.size()));
  Real sum = 0, count = 0;
  for (std::size_t k = 0; k < water.id.size(); ++k) {
    const Vec3 off = water.position[k] - end;
    if (off.dot(way) < 0) continue;
    sum += water.velocity[k].squaredNorm() / 2 + 9.8 * off.z();
    ++count;
  }
  EXPECT_GT(count, 50);
  return sum / count / (speed * speed / 2);
}

// Out of a wall in the air, beside it, and far from it. While the wall held it back the first had 0.54 of its energy.
TEST(Inlet, AJetOutOfAWallHasTheSpeedThatItIsGiven) {
  for (const Real dt : {0.0041666667, 0.0166666667}) {
    for (const Real from : {0.0, 0.05, 0.1, 0.15, 0.2, 0.3}) {
      for (const bool up : {false, true}) {
        SCOPED_TRACE(fmt::format("dt {} s, {} m, {}", dt, from, up ? "up" : "level"));
        const std::string way = up ? fmt::format("center = [0.8, 0.45, {}]\ndirection = [0, 0, 1]\n", from)
                                   : fmt::format("center = [{}, 0.45, 2.5]\ndirection = [1, 0, 0]\n", from);
        const Scene scene = scene_with(shaft + "[gravity]\n[[inlet]]\nradius = 0.15\nspeed = 7\n" + way,
                                       {fmt::format("time.dt={}", dt)});
        const std::unique_ptr<Solver> solver = solver_of(world, scene);
        run(*solver, 0.15);
        const Vec3 end = up ? Vec3(0.8, 0.45, from + spacing) : Vec3(from + spacing, 0.45, 2.5);
        EXPECT_NEAR(energy_kept(*solver, end, up ? Vec3::UnitZ() : Vec3::UnitX(), 7), 1, 0.05);
      }
    }
  }
}

// At the top of a plinth that ends on a face of the cells, or cuts them in the middle, and half a spacing above one
// that cuts them elsewhere. While it held the jet back the first had 0.5 to 0.66 of its energy.
TEST(Inlet, AJetOutOfASolidHasTheSpeedThatItIsGiven) {
  for (const Real dt : {0.0041666667, 0.0166666667}) {
    for (const auto& [top, from] : {std::pair(1.0, 1.0), {1.1, 1.1}, {1.05, 1.1}}) {
      SCOPED_TRACE(fmt::format("dt {} s, top at {} m", dt, top));
      const Scene scene = scene_with(
          tank_with_gravity({.max = "2, 2, 3", .dt = "0.01"}) +
              fmt::format("[[obstacle]]\ntype = \"box\"\nsize = [1, 1, 1]\ncenter = [1, 1, {}]\n"
                          "[[inlet]]\ncenter = [1, 1, {}]\ndirection = [0, 0, 1]\nradius = 0.15\nspeed = 6\n",
                          top - 0.5, from),
          {fmt::format("time.dt={}", dt)});
      const std::unique_ptr<Solver> solver = solver_of(world, scene);
      run(*solver, 0.2);
      EXPECT_NEAR(energy_kept(*solver, Vec3(1, 1, from + spacing), Vec3::UnitZ(), 6), 1, 0.05);
    }
  }
}

// A plate that is before half of the opening from the start, and one that comes to stand in all of it.
TEST(Inlet, MakesNothingInASolidNorBehindOne) {
  const std::string plate = "[[obstacle]]\ntype = \"box\"\nsize = [0.8, 0.9, 0.1]\n";
  const auto flow_of = [&](const std::string& more, const std::vector<std::string>& changes) {
    const Scene scene = scene_with(shaft + "[gravity]\n" + jet + "speed = 3\n" + bottom + plate + more, changes);
    const std::unique_ptr<Solver> solver = solver_of(world, scene);
    run(*solver, 1);
    for (const Vec3& v : solver->particles().velocity) EXPECT_LT(v.norm(), 8.5) << "3 m/s and a fall of 3 m";
    return solver->flow()->streams[0];
  };
  const FlowState::Stream open = flow_of("center = [0.4, 0.45, 0.9]\n", {});
  EXPECT_EQ(open.covered, 0);
  EXPECT_NEAR(open.made, open.asked(), 1e-9);
  const FlowState::Stream half = flow_of("center = [0.4, 0.45, 2.89]\n", {"inlet.0.center=[0.8, 0.45, 2.95]"});
  EXPECT_NEAR(half.covered, half.asked() / 2, half.asked() / 6);  // some flows off the plate just below
  const FlowState::Stream shut =
      flow_of("center = [0.8, 0.45, 2.3]\nvelocity = [0, 0, 0.8]\n", {"obstacle.0.size=[0.8, 0.9, 0.5]"});
  EXPECT_GT(shut.covered, shut.asked() / 3);
  EXPECT_LT(shut.made, 2 * shut.asked() / 3);
  EXPECT_NEAR(shut.asked(), open.asked(), 24);
}

// Water between an opening and a wall a spacing away falls, as nothing holds it there.
TEST(Inlet, FacingAWallLeavesNothingInTheAir) {
  const std::string facing = "[[inlet]]\ncenter = [1.5, 0.45, 2.0]\ndirection = [1, 0, 0]\nradius = 0.2\nspeed = 2\n";
  const Scene scene = scene_with(shaft + "[gravity]\n" + facing, {"inlet.0.stop=0.5"});
  const std::unique_ptr<Solver> solver = solver_of(world, scene);
  run(*solver, 0.5);
  EXPECT_GT(total(*solver), 12);
  for (int k = 0; k < 60; ++k) solver->step();
  for (const Vec3& p : solver->particles().position) EXPECT_FALSE(p.x() > 1.5 && std::abs(p.z() - 2) < 0.25) << p;
}

}  // namespace
}  // namespace trevi::test
