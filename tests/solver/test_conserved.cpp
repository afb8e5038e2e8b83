// What the default steps leave alone: a pool at rest stays at rest, jets that meet in free space keep their momentum,
// water that meets a wall gains no energy, and a drop that is stretched keeps it.
#include <fmt/format.h>

#include <array>
#include <cmath>

#include "support/cloud.hpp"
#include "support/kept_run.hpp"
#include "support/tank.hpp"

namespace trevi::test {
namespace {

// ---- water at rest ------------------------------------------------------------------------------------------------

std::string pool_of(int layers) {
  return fmt::format(
      "[domain]\nmin = [0.3, -0.2, 0.1]\nmax = [1.9, 0.8, 1.6]\n[fluid]\nspacing = 0.1\n[[particles]]\n"
      "min = [0.3, -0.2, 0.1]\nmax = [1.9, 0.8, {}]\n[time]\ndt = 0.0166666667\nend = 2\n[gravity]\n",
      0.1 + 0.1 * layers);
}

Real fastest(const Particles& particles) {
  Real v = 0;
  for (const Vec3& u : particles.velocity) v = std::max(v, u.norm());
  MPI_Allreduce(MPI_IN_PLACE, &v, 1, MPI_DOUBLE, MPI_MAX, world);
  return v;
}

// Layers that end at the top of a cell and in it, at h = 2.5 spacings at 0.6 of it, where a cell begins to count as
// wet. Found: 8e-14 m/s.
TEST(Pool, AtRestStaysAtRest) {
  for (const int layers : {4, 5, 9}) {
    for (const double ratio : {2.0, 2.5, 3.0}) {
      const Scene scene = scene_with(pool_of(layers), {fmt::format("fluid.kernel_radius={}", 0.1 * ratio)});
      const std::unique_ptr<Solver> solver = started(scene);
      for (int k = 0; k < 50; ++k) solver->step();
      EXPECT_LT(fastest(solver->particles()), 1e-6) << layers << " layers, h = " << ratio << " spacings";
    }
  }
}

/// Each coordinate off by up to a tenth of the spacing of 0.1 m.
void disturb(Particles& particles) {
  for (std::size_t i = 0; i < particles.id.size(); ++i) {
    for (Eigen::Index a = 0; a < 3; ++a) {
      const Real at_random = std::fmod(
          static_cast<Real>(particles.id[i]) * std::array{0.6180, 0.7549, 0.5698}[static_cast<std::size_t>(a)], 1.0);
      particles.position[i][a] += 0.02 * (at_random - 0.5);
    }
  }
}

// Cells at its surface are 0.58 to 0.59 full: some of them count as wet and others do not, where the surface stands
// above the middle of both. Found: 6e-5 and 9e-5 m²/s². When the surface of dry ones was never above their middle,
// water was driven to them and simmered at 2.5e-3 and 1.6e-3.
TEST(Pool, RestsWhereCellsAtItsSurfaceAreAsFullAsMakesThemWet) {
  for (const double height : {2.178, 2.182}) {
    const Scene scene = scene_with(
        pool_of(10), {fmt::format("domain.max=[1.3, 0.8, {}]", 0.1 + height), "particles.0.max=[1.3, 0.8, 1.1]"});
    const std::unique_ptr<Solver> solver = started(scene);
    solver->change_particles(disturb);
    Real sum = 0;
    for (int k = 0; k < 360; ++k) {
      solver->step();
      if (k < 300) continue;
      for (const Vec3& v : solver->particles().velocity) sum += v.squaredNorm() / 2 / 60;
    }
    const Real mean = sum / static_cast<Real>(solver->particles().id.size());
    EXPECT_LT(mean, 3e-4) << height;
  }
}

// ---- flight ----------------------------------------------------------------------------------------------------

// Thrown blocks, one of which turns, and a drop fly on the parabola, to rounding. By the new velocity alone they were
// g t dt/2 too low, 65 mm at a thirtieth of a second.
TEST(Flight, IsOnTheParabolaInAnyStep) {
  const std::string water = tank_with_gravity({.min = "0, 0, 0", .max = "4, 3, 4", .dt = "0.02", .end = "1"}) +
                            "[[particles]]\nmin = [1, 1, 2]\nmax = [1.8, 1.8, 2.7]\nvelocity = [1, -0.5, 2]\n"
                            "[[particles]]\nmin = [3, 1, 3]\nmax = [3.1, 1.1, 3.1]\nvelocity = [-0.5, 0.5, 0]\n";
  const auto middles = [](const Cloud& cloud) {
    std::array<Vec3, 2> sums{Vec3::Zero(), Vec3::Zero()};
    constexpr GlobalId in_block = 8 * 8 * 7;
    for (std::size_t i = 0; i < cloud.id.size(); ++i)
      sums[cloud.id[i] < in_block ? 0 : 1] += cloud.position[i] / (cloud.id[i] < in_block ? in_block : 1.0);
    return sums;
  };
  const std::array<Vec3, 2> velocity{Vec3(1, -0.5, 2), Vec3(-0.5, 0.5, 0)};
  for (const int rate : {30, 60, 240}) {
    for (const Real turn : {0.0, 2.0}) {
      const Scene scene = scene_with(water, {fmt::format("time.dt={}", 1.0 / rate), "time.cfl=0"});
      const std::unique_ptr<Solver> solver = started(scene);
      const std::array<Vec3, 2> first = middles(gathered(world, solver->particles()));
      solver->change_particles([&](Particles& particles) {
        for (std::size_t i = 0; i < particles.id.size(); ++i) {
          if (particles.id[i] < 8 * 8 * 7)
            particles.velocity[i] += turn * Vec3(0.6, 0.8, 0).cross(particles.position[i] - Vec3(1.4, 1.4, 2.35));
        }
      });
      for (int k = 0; k < rate * 2 / 5; ++k) solver->step();
      const Cloud last = gathered(world, solver->particles());
      if (rank_of(world) != 0) continue;
      const std::array<Vec3, 2> found = middles(last);
      const Real t = solver->clock().time();
      for (const std::size_t n : {0U, 1U})
        EXPECT_LT((found[n] - first[n] - t * velocity[n] - Vec3(0, 0, -9.8 * t * t / 2)).norm(), 1e-11) << rate << n;
    }
  }
}

// ---- jets that meet --------------------------------------------------------------------------------------------

const std::string jets_scene = tank_text({.min = "-2.0, -1.4, -1.4",
                                          .max = "2.0, 1.8, 1.8",
                                          .water = {{"-1.0, 0.0, 0.0", "-0.1, 0.3, 0.4", "velocity = [5, 0, 0]"},
                                                    {"0.0, 0.1, -0.1", "0.9, 0.4, 0.2", "velocity = [-4, 0.5, 0]"}},
                                          .dt = "0.0166666667",
                                          .end = "2"});

/// What the jets have changed beside what gravity does, in shares of the sums of |v| and |r||v| at the start, and how
/// far their speeds changed. Angular momentum is that about the centre of mass.
struct Changes {
  Real linear, angular, speeds;
};

/// The particles of the jets, which are the first ones.
Cloud jets_of(const Solver& solver) {
  constexpr GlobalId in_jets = 9 * 3 * 4 + 9 * 3 * 3;
  Cloud jets;
  const Cloud all = gathered(world, solver.particles());
  for (std::size_t i = 0; i < all.id.size(); ++i)
    if (all.id[i] < in_jets) jets.add(all.id[i], all.position[i], all.velocity[i]);
  return jets;
}

Changes changes(const std::vector<std::string>& overrides, const std::string& beside = "") {
  const Scene scene = scene_with(jets_scene + beside, overrides);
  const std::unique_ptr<Solver> solver = started(scene);
  const Cloud first = jets_of(*solver);
  const Vec3 kick = scene.gravity.value_or(Vec3::Zero()) * scene.dt;
  const std::int64_t steps = std::lround(0.2 / scene.dt);
  Vec3 linear = Vec3::Zero(), angular = Vec3::Zero();
  for (std::int64_t k = 0; k < steps; ++k) {
    const Cloud now = jets_of(*solver);
    for (std::size_t i = 0; i < now.id.size(); ++i) {
      linear -= kick;
      angular -= (now.position[i] + scene.dt / 2 * now.velocity[i]).cross(kick);  // at the mean of a parabola
    }
    solver->step();
  }
  const Cloud last = jets_of(*solver);
  Real speed = 0, moment = 0, changed = 0;
  for (std::size_t i = 0; i < last.id.size(); ++i) {
    speed += first.velocity[i].norm();
    moment += first.position[i].norm() * first.velocity[i].norm();
    changed += (last.velocity[i] - first.velocity[i] - static_cast<Real>(steps) * kick).norm();
    linear += last.velocity[i] - first.velocity[i];
    angular += last.position[i].cross(last.velocity[i]) - first.position[i].cross(first.velocity[i]);
  }
  for (const Vec3& p : last.position) EXPECT_GT((p - scene.domain.min).cwiseMin(scene.domain.max - p).minCoeff(), 0.3);
  return {linear.norm() / speed, angular.norm() / moment, changed / speed};
}

// Found: 4e-15 of the linear momentum in double and 4e-10 in single precision, 6e-15 of the angular one.
TEST(Jets, KeepTheirMomentum) {
  for (const char* precision : {"density.precision='double'", "density.precision='single'"}) {
    for (const char* dt : {"time.dt=0.0166666667", "time.dt=0.00208333333"}) {
      SCOPED_TRACE(std::string(precision) + " " + dt);
      const Changes found = changes({precision, dt});
      EXPECT_LT(found.linear, 1e-6);
      EXPECT_LT(found.angular, 1e-6);
      EXPECT_GT(found.speeds, 0.05) << "jets that do not meet prove nothing";
    }
  }
}

// Found: 0.016 with the report's vorticity confinement; projected 7e-16 in double and 2e-9 in single precision.
// 9 % of it were lost where the projection was left alone.
TEST(Jets, KeepTheirMomentumInFreeFall) {
  for (const std::string dt : {"0.0166666667", "0.004"}) {
    const Changes found = changes({"gravity.acceleration=[0, 0, -9.8]", "time.dt=" + dt});
    EXPECT_LT(found.linear, 1e-12) << dt;
    EXPECT_LT(found.angular, 1e-12) << dt;
    EXPECT_GT(found.speeds, 0.1) << dt;
  }
}

// Though other water lies on the floor. 14 to 18 % were lost where only water alone had its momentum back.
TEST(Jets, KeepTheirMomentumAboveAPool) {
  const std::string pool = "[[particles]]\nmin = [-2.0, -1.4, -1.4]\nmax = [2.0, 1.8, -1.2]\n";
  const Changes found = changes({"gravity.acceleration=[0, 0, -9.8]"}, pool);
  EXPECT_LT(found.linear, 1e-12);
  EXPECT_LT(found.angular, 1e-12);
  EXPECT_GT(found.speeds, 0.1);
}

TEST(Jets, KeepTheirMomentumWithProjectedVorticity) {
  const std::string strong = "vorticity.epsilon=0.002", projected = "vorticity.form='projected'";
  EXPECT_GT(changes({strong, "density.precision='double'"}).linear, 1e-3) << "nothing to mend";
  EXPECT_LT(changes({strong, projected, "density.precision='double'"}).linear, 1e-13);
  EXPECT_LT(changes({strong, projected, "density.precision='single'"}).linear, 1e-8);
}

// ---- impacts without gravity -----------------------------------------------------------------------------------

Real kinetic_energy(const Particles& particles) {
  Real sum = 0;
  for (const Vec3& v : particles.velocity) sum += v.squaredNorm() / 2;
  MPI_Allreduce(MPI_IN_PLACE, &sum, 1, MPI_DOUBLE, MPI_SUM, world);
  return sum;
}

// A layer and a block that are thrown at a wall at 1 m/s: what is pushed apart along the wall is stopped there, too.
TEST(Impact, OfWaterOnAWallGivesItNoEnergyInAnyStep) {
  const std::string box = tank_text({.max = "2, 1, 1", .dt = "0.0166666667", .end = "2"});
  const std::string layer = "[[particles]]\nmin = [0.2, 0.1, 0.4]\nmax = [1.2, 0.9, 0.5]\nvelocity = [0, 0, 1]\n";
  const std::string block = "[[particles]]\nmin = [0.5, 0.3, 0.3]\nmax = [0.9, 0.7, 0.7]\nvelocity = [1, 0, 0]\n";
  for (const std::string& water : {layer, block}) {
    for (const int rate : {60, 240}) {
      const Scene scene = scene_with(box + water, {fmt::format("time.dt={}", 1.0 / rate)});
      const std::unique_ptr<Solver> solver = started(scene);
      const Real before = kinetic_energy(solver->particles());
      Real least = before, rise = 0;
      for (int k = 0; k < 2 * rate; ++k) {
        solver->step();
        const Real now = kinetic_energy(solver->particles());
        least = std::min(least, now);
        rise = std::max(rise, now - least);
      }
      EXPECT_LT(least, 0.5 * before);
      EXPECT_LT(rise, 0.05 * before) << water << rate;
    }
  }
}

// ---- on a floor ---------------------------------------------------------------------------------------------------

// Nothing pushes along a smooth floor, but walls that stand across. Without that undone a block that falls askew into a
// pool between periodic ends lost half of its momentum in a second, and one on the floor of a box a sixth.
TEST(Splash, KeepsItsMomentumAlongTheFloor) {
  const Tank floor{.min = "-4, 0",
                   .max = "8, 1",
                   .water = {{"0.8, 0.5", "1.2, 0.8", "velocity = [2, -2]"}},
                   .spacing = "0.05",
                   .domain = "dimensions = 2"};
  Tank pool = floor;
  pool.min = "0, 0";
  pool.max = "2, 1";
  pool.water.push_back({"0, 0", "2, 0.3"});
  pool.domain += "\nperiodic = ['x']";
  for (const Tank& tank : {pool, floor}) {
    KeptRun run(world, parse_scene("splash.toml", tank_with_gravity(tank), {}));
    run.steps(40);
    EXPECT_NEAR(run.rows.back().momentum.x() / run.rows.front().momentum.x(), 1, 1e-9);
  }
}

// ---- a drop -------------------------------------------------------------------------------------------------------

// A circle with the motion A (-x, z) becomes an ellipse of half-axes a and b = R²/a, and keeps its energy, so that
// a'² + b'² = 2 A² R² (Monaghan 1994). Found: 1.021, and 1.009 with twice as many particles across.
TEST(Drop, ThatIsStretchedKeepsItsEnergy) {
  constexpr Real stretching = 2, radius = 1, dt = 0.01;
  constexpr int steps = 80, parts = 1000;
  const Tank around{.min = "0, 0",
                    .max = "6, 10",
                    .water = {{"2, 4", "4, 6", "velocity = ['-2*(x-3)', '2*(z-5)']"}},
                    .dt = "0.01",
                    .spacing = "0.05",
                    .domain = "dimensions = 2"};
  const Scene scene = parse_scene("drop.toml", tank_text(around), {});
  Particles water = initial_particles(world, scene);
  for (auto i = static_cast<std::ptrdiff_t>(water.id.size()); i-- > 0;) {
    const Vec3 off = water.position[static_cast<std::size_t>(i)] - Vec3(3, 0, 5);
    if (std::hypot(off.x(), off.z()) < radius) continue;
    water.for_each_field([&](auto& field) { field.erase(field.begin() + i); });
  }
  KeptRun run(world, scene, std::move(water));
  run.steps(steps);
  EXPECT_NEAR(run.rows.back().kinetic_energy / run.rows.front().kinetic_energy, 1, 0.03);
  Real a = radius;
  const auto shrinking = [&](Real at) { return std::sqrt(2 / (1 + std::pow(radius / at, 4))) * stretching * radius; };
  for (int n = 0; n < steps * parts; ++n) a -= dt / parts * shrinking(a - dt / parts / 2 * shrinking(a));
  const std::vector<Vec3> places = gathered(world, run.solver->particles()).position;
  const auto count = static_cast<Real>(places.size());
  Real mean = 0, square = 0;
  for (const Vec3& x : places) mean += x.z() / count;
  for (const Vec3& x : places) square += std::pow(x.z() - mean, 2) / count;
  EXPECT_NEAR(2 * std::sqrt(square) * a / (radius * radius), 1, 0.01);
}

}  // namespace
}  // namespace trevi::test
