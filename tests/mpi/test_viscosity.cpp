// Viscosity in m²/s: waves decay as the Navier–Stokes equations say, whatever the time step, the spacing and the
// kernel.
#include <cmath>
#include <numbers>

#include <fmt/format.h>

#include "cloud.hpp"
#include "domain/migrate.hpp"
#include "fluid/xsph_viscosity.hpp"

namespace trevi::test {
namespace {

constexpr Real pi = std::numbers::pi, length = 1.2;

std::string filled_box(Real spacing, Real dt) {
  return fmt::format(
      "[domain]\nmin = [0, 0, 0]\nmax = [{0}, {0}, {0}]\n[fluid]\nspacing = {1}\n[[particles]]\nmin = [0, 0, 0]\n"
      "max = [{0}, {0}, {0}]\n[time]\ndt = {2}\nend = 1\n",
      length, spacing, dt);
}

template <class Velocity>
Cloud lattice(const Scene& scene, Velocity&& velocity) {
  Cloud cloud;
  const Real s = scene.fluid.spacing;
  const Eigen::Array3i n = ((scene.domain.max - scene.domain.min) / s).array().round().cast<int>();
  for (int k = 0; k < n.prod(); ++k) {
    const int row = k / n.x(), layer = row / n.y();
    const Vec3 p = s * Vec3(k % n.x() + 0.5, row % n.y() + 0.5, layer + 0.5);
    cloud.add(k, p, velocity(p));
  }
  return cloud;
}

/// Part of the velocities that has the shape of the wave.
template <class Velocity>
Real amplitude(const Cloud& cloud, Velocity&& wave) {
  Real product = 0, square = 0;
  for (std::size_t i = 0; i < cloud.id.size(); ++i) {
    product += cloud.velocity[i].dot(wave(cloud.position[i]));
    square += wave(cloud.position[i]).squaredNorm();
  }
  return product / square;
}

/// Rate at which a filter slows a wave of particles that stand still, 1/s, away from the walls across x and y; and the
/// momentum per particle at the end.
struct Slowed {
  Real rate;
  Vec3 momentum;
};

template <class T, class Wave>
Slowed slowed(const Scene& scene, Wave&& wave) {
  const Cloud mine = slice_of(lattice(scene, wave), rank_of(world), size_of(world));
  const Real h = scene.fluid.kernel_radius, seconds = 0.4;
  const CellGrid grid(scene.domain.min, scene.domain.max, h, 0);
  const Slabs slabs(std::vector<Real>(static_cast<std::size_t>(grid.planes()), 1.0), size_of(world));
  Particles particles;
  particles.id = mine.id;
  particles.position = particles.predicted = particles.velocity = mine.position;
  migrate(world, particles, &Particles::predicted, grid, slabs);
  Neighbourhood<T> near(world, grid, scene.domain.min, h);
  near.rebuild(particles, {slabs.first_plane(rank_of(world)), slabs.last_plane(rank_of(world))});
  // Only now, as the sort uses their memory.
  std::transform(particles.predicted.begin(), particles.predicted.end(), particles.velocity.begin(), wave);
  particles.position = particles.predicted;
  KinematicViscosity<T> filter(*scene.kinematic_viscosity, scene.fluid.spacing, h,
                               std::make_shared<VelocityField<T>>());
  const auto inside = [&](const Vec3& p) -> Vec3 {
    const Vec3 room = p.cwiseMin(scene.domain.max - p);
    return room.head<2>().minCoeff() > 0.35 ? wave(p) : Vec3::Zero();
  };
  for (int k = 0; k < std::lround(seconds / scene.dt); ++k) filter.apply(near, particles, scene.dt);
  const Cloud end = gathered(world, particles);
  const Vec3 momentum = std::accumulate(end.velocity.begin(), end.velocity.end(), Vec3(Vec3::Zero()));
  return {-std::log(amplitude(end, inside)) / seconds, momentum / static_cast<Real>(end.id.size())};
}

// Layers that slide without friction at the walls, v_x = cos(π z/H): the rate is nu (π/H)².
TEST(Viscosity, SlidingLayersSlowDownAtTheirRate) {
  constexpr Real nu = 0.02, exact = nu * pi * pi / (length * length);
  const auto layers = [](const Vec3& p) { return Vec3(std::cos(pi * p.z() / length), 0, 0); };
  for (const Real spacing : {0.1, 0.05}) {
    for (const Real dt : {0.02, 0.005}) {
      for (const Real ratio : {2.0, 3.0}) {
        SCOPED_TRACE(fmt::format("spacing {} m, dt {} s, h {} spacings", spacing, dt, ratio));
        const Scene scene = scene_with(filled_box(spacing, dt),
                                       {"viscosity.nu=0.02", fmt::format("fluid.kernel_radius={}", ratio * spacing)});
        const Slowed fine = slowed<double>(scene, layers), coarse = slowed<float>(scene, layers);
        EXPECT_NEAR(fine.rate / exact, 1, 0.02);
        EXPECT_NEAR(coarse.rate / exact, 1, 0.02);
        EXPECT_LT(fine.momentum.norm(), 1e-13);
      }
    }
  }
}

// A vortex that fills the box (Taylor & Green 1937), a solution with frictionless walls, whose rate is 2 nu (π/L)².
Vec3 vortex(const Vec3& p) {
  const Real x = pi * p.x() / length, z = pi * p.z() / length;
  return {std::sin(x) * std::cos(z), 0, -std::cos(x) * std::sin(z)};
}

struct Decay {
  Real rate;  // 1/s
  std::int64_t substeps;
};

Decay vortex_decay(Real spacing, Real dt, const std::string& more) {
  const Scene scene = scene_with(filled_box(spacing, dt), {more});
  constexpr Real slow = 1e-3, seconds = 0.5;  // m/s, so that hardly any particle leaves its place
  const Cloud start = lattice(scene, [&](const Vec3& p) { return Vec3(slow * vortex(p)); });
  const std::unique_ptr<Solver> solver = solver_of(world, scene, start);
  for (int k = 0; k < std::lround(seconds / dt); ++k) solver->step();
  const Cloud end = gathered(world, solver->particles());
  return {-std::log(amplitude(end, vortex) / slow) / seconds, solver->counters().substeps};
}

// Through the whole solver. Within h of a wall the neighbours behind it are missing, which leaves out a share of the
// friction that goes with the spacing; the step and its parts leave it alone.
TEST(Viscosity, VortexInABoxSlowsDownWhateverTheStep) {
  constexpr Real nu = 0.05, exact = 2 * nu * pi * pi / (length * length);
  const char* thick = "viscosity.nu=0.05";
  Real missing[2] = {};
  for (const int k : {0, 1}) {
    const Real spacing = k == 0 ? 0.1 : 0.05;
    const Decay idle = vortex_decay(spacing, 0.025, "walls.density='none'");
    const Decay walled = vortex_decay(spacing, 0.025, "random.seed=1");
    const Decay whole = vortex_decay(spacing, 0.00625, thick), split = vortex_decay(spacing, 0.025, thick);
    EXPECT_LT(std::abs(idle.rate), 1e-4 * exact) << "what is left of the rate is that of viscosity";
    // Sweeps push at the walls' share, which knows how water moves against a wall and not how it moves along it.
    EXPECT_LT(std::abs(walled.rate), 0.2 * spacing * spacing * exact);
    EXPECT_NEAR(split.rate, whole.rate, 0.01 * exact);
    EXPECT_EQ(whole.substeps, 80);
    EXPECT_EQ(split.substeps, k == 0 ? 20 : 60) << "nu dt is 0.66 and 2.6 times what a step can take";
    missing[k] = 1 - whole.rate / exact;
  }
  EXPECT_LT(missing[0], 0.25);
  EXPECT_NEAR(missing[1] / missing[0], 0.5, 0.1);
}

}  // namespace
}  // namespace trevi::test
