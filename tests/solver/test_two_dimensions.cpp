// Scenes in two dimensions: the layer stays in its plane to the bit whatever is in the scene, obstacles are what the
// kernel's disc says, still water has its pressure and its buoyancy, vortices decay and a channel flows as they do in
// the plane, and settings that have no place there are refused. (The same bits on any ranks and threads:
// tests/regression/test_golden.py; whole steps against brute force: test_reference.cpp.)
#include <cmath>
#include <numbers>
#include <random>

#include "boundary/geometry/shape.hpp"
#include "boundary/volume_map/volume_map.hpp"
#include "fluid/in_two_dimensions.hpp"
#include "support/cloud.hpp"
#include "support/kept_run.hpp"
#include "trevi/error.hpp"

namespace trevi::test {
namespace {

struct Flow : KeptRun {
  Flow(MPI_Comm comm, const std::string& text, const std::vector<std::string>& overrides = {})
      : KeptRun(comm, parse_scene("test.toml", text, overrides)) {}
};

// With all that moves water, and solids that move.
const std::string all_kinds = R"(
[domain]
dimensions = 2
min = [0, 0]
max = [1.6, 1.6]
[fluid]
spacing = 0.05
[[particles]]
min = [0, 0]
max = [1.6, 0.5]
velocity = [1, 0.3]
[time]
dt = 0.0166666667
end = 1
[gravity]
acceleration = [1, 0, -9.8]
[walls]
floor_friction = 0.02
[tensile]
[vorticity]
[viscosity]
nu = 1e-4
no_slip = true
[[obstacle]]
type = "cylinder"
center = [0.8, 9, 0.45]
radius = 0.13
angular_velocity = [0, 3, 0]
[[obstacle]]
type = "box"
center = [1.3, 0.3]
size = [0.2, 5, 0.3]
rotate = [0, 30, 0]
motion = { type = "sine", amplitude = [0.1, 0.02], rotation = [0, 20, 0], period = 0.7 }
[[obstacle]]
type = "basin"
center = [0.4, 1.1]
size = [0.3, 0.2]
[[fountain]]
center = [0.3, 7]
diameter = 0.2
speed = 4.0
jitter = 1.0
[[inlet]]
center = [0.4, 1.5]
radius = 0.1
direction = [0, -1]
speed = 2.0
jitter = 0.5
[[drain]]
min = [1.5, 0]
max = [1.6, 0.1]
)";

TEST(TwoDimensions, TheLayerStaysInItsPlane) {
  for (const char* precision : {"density.precision='double'", "density.precision='single'"}) {
    Flow run(world, all_kinds, {precision});
    const std::size_t start = gathered(world, run.solver->particles()).id.size();
    run.steps(60);
    const Cloud all = gathered(world, run.solver->particles());
    EXPECT_NE(all.id.size(), start) << "the inlet makes nothing";
    Real fastest = 0;
    for (std::size_t i = 0; i < all.id.size(); ++i) {
      EXPECT_EQ(all.position[i].y(), 0) << all.id[i];
      EXPECT_EQ(all.velocity[i].y(), 0) << all.id[i];
      fastest = std::max(fastest, all.velocity[i].norm());
    }
    EXPECT_TRUE(rank_of(world) != 0 || fastest > 1) << "nothing moves";
  }
}

// ---- obstacles ----------------------------------------------------------------------------------------------------

constexpr Real h = 0.2, spacing = 0.1;

struct Solid {
  std::string name;
  ObstacleSettings settings;
  Vec3 from, to;  // a line of places, in the frame of the solid
};

std::vector<Solid> solids() {
  FluidSettings fluid{spacing};
  fluid.dimensions = 2;
  ObstacleSettings box, rod;
  box.shape = ShapeKind::box;
  ObstacleSettings plate = box;
  rod.shape = ShapeKind::cylinder;
  box.size = Vec3(2, 0, 2);
  plate.size = Vec3(2, 0, 0.25 * spacing);
  rod.radius = 2 * h;
  rod.axis = Vec3::UnitY();
  ObstacleSettings pipe = rod;
  pipe.inside = true;
  for (ObstacleSettings* one : {&box, &plate, &rod, &pipe}) lay_in_plane(*one, fluid);
  return {{"line", box, {0.1, 0, 1 + h}, {0.13, 0, 1}},
          {"corner", box, {1 + 0.7 * h, 0, 1 + 0.7 * h}, {1, 0, 1}},
          {"plate", plate, {0.1, 0, h}, {0.1, 0, 0.126 * spacing}},
          {"rod", rod, {3 * h, 0.1, 0}, {1.97 * h, 0.1, 0}},
          {"pipe", pipe, {0.5 * h, 0.1, 0}, {1.9 * h, 0.1, 0}}};
}

/// The fraction of the kernel's disc around p, across coordinate `along`, in the solid.
Real quadrature(const Kernel& kernel, const Shape& shape, const Vec3& p) {
  constexpr int parts = 400;
  const Eigen::Index along = shape.extruded_along().value(), a = (along + 1) % 3, b = (along + 2) % 3;
  Real inside = 0, all = 0;
  for (int k = 0; k < parts * parts; ++k) {
    Vec3 r = Vec3::Zero();
    r[a] = h * (2 * (k % parts + 0.5) / parts - 1);
    r[b] = h * (2 * (k / parts + 0.5) / parts - 1);
    const Real w = kernel.value(r, h);
    all += w;
    if (shape.distance(p + r) < 0) inside += w;
  }
  return inside / all;
}

TEST(TwoDimensions, ObstaclesTakeOfTheKernelsDiscWhatBruteQuadratureSays) {
  for (const Kernel& kernel : all_kernels(2)) {
    const PlaneVolume plane(kernel, h);
    EXPECT_DOUBLE_EQ(plane.fraction(0), 0.5);
    for (const Solid& solid : solids()) {
      const auto shape = make_shape(solid.settings);
      const VolumeMap map(*shape, kernel, h, {});
      Real worst = 0;
      for (int k = 0; k <= 7; ++k) {
        const Vec3 p = solid.from + (solid.to - solid.from) * k / 7;
        const EquivalentPlane at = map.at(p);
        worst = std::max(worst, std::abs(plane.fraction(at.distance) - quadrature(kernel, *shape, p)));
        EXPECT_NEAR(at.gradient[*shape->extruded_along()], 0, 1e-12);
      }
      std::printf("%-12s %-8s %.4f\n", kernel.name.data(), solid.name.c_str(), worst);
      EXPECT_LT(worst, 0.02) << solid.name;
    }
  }
}

// ---- flows --------------------------------------------------------------------------------------------------------

const std::string still = R"(
[domain]
dimensions = 2
min = [0, 0]
max = [2, 2]
[fluid]
spacing = 0.05
[[particles]]
min = [0, 0]
max = [2, 1.5]
[[obstacle]]
type = "cylinder"
center = [1, 0.75]
radius = 0.25
[time]
dt = 0.01
end = 6
[gravity]
)";

// Forces are those on a layer of one spacing. 0.6 % off when this was written.
TEST(TwoDimensions, ACylinderIsLiftedByTheWaterThatItTakesThePlaceOf) {
  Flow run(world, still);
  run.steps(200);
  Vec3 force = Vec3::Zero();
  constexpr int steps = 200;
  for (int k = 0; k < steps; ++k) {
    run.steps(1);
    force += run.forces.back()[0].force / steps;
  }
  const Real weight = 1000 * 9.8 * std::numbers::pi * 0.25 * 0.25 * 0.05;
  EXPECT_NEAR(force.z() / weight, 1, 0.02);
  EXPECT_NEAR(force.x() / weight, 0, 0.01);
  EXPECT_NEAR(force.y() / weight, 0, 1e-12);
}

const std::string repeating = R"(
[domain]
dimensions = 2
min = [0, 0]
max = [1, 1]
[fluid]
spacing = 0.05
[[particles]]
min = [0, 0]
max = [1, 1]
[time]
dt = 0.005
end = 3
[viscosity]
)";

// Times 2/m.
Real energy_of(const KeptRun& run) {
  Real sum = 0;
  for (const Vec3& v : gathered(world, run.solver->particles()).velocity) sum += v.squaredNorm();
  return sum;
}

// exp(-16 pi² nu t), Taylor & Green 1937; 20 across.
TEST(TwoDimensions, VorticesDecayAsNavierAndStokesSay) {
  Flow run(world, repeating + "nu = 0.01\n", {"domain.periodic=['x', 'z']", "particles.0.vortex=1.0"});
  const Real start = energy_of(run);
  run.steps(80);
  EXPECT_NEAR(energy_of(run) / start / std::exp(-16 * std::numbers::pi * std::numbers::pi * 0.01 * 0.4), 1, 0.03);
}

// A disordered shear without viscosity breaks up; nothing gives it energy. Where shifted particles took on velocities
// along the noise that they have, that grew along the axis on which the flow closes in, by 0.13 of all energy.
TEST(TwoDimensions, AShearThatBreaksUpGainsNothing) {
  const Scene scene = parse_scene("shear.toml", repeating + "nu = 0\n",
                                  {"domain.periodic=['x', 'z']", "particles.0.velocity=['sin(2*pi*z)', '0']"});
  Particles water = initial_particles(world, scene);
  for (std::size_t i = 0; i < water.position.size(); ++i) {
    std::mt19937_64 random(static_cast<std::uint64_t>(water.id[i]));
    std::uniform_real_distribution<Real> off(-0.01, 0.01);
    water.position[i] += Vec3(off(random), 0, off(random));
  }
  KeptRun run(world, scene, std::move(water));
  const Real start = energy_of(run);
  Real most = 0;
  for (int turn = 0; turn < 7; ++turn) {
    run.steps(200);
    most = std::max(most, energy_of(run) / start);
  }
  EXPECT_LT(most, 1.02);
  EXPECT_GT(energy_of(run) / start, 0.75);
}

// A shear across the lattice, which breaks that up, is steady. Where all particles of a face took as much of its
// displacement, however many they were, it lost 0.07 of its energy in a second.
TEST(TwoDimensions, AShearAcrossTheLatticeKeepsItsEnergy) {
  Flow run(
      world, repeating + "nu = 0\n",
      {"domain.periodic=['x', 'z']", "particles.0.velocity=['sin(2*pi*(x+z))/sqrt(2)', '-sin(2*pi*(x+z))/sqrt(2)']"});
  const Real start = energy_of(run);
  run.steps(200);
  EXPECT_GT(energy_of(run) / start, 0.97);
  EXPECT_LT(energy_of(run) / start, 1.02);
}

// Between plates that hold it the parabola stays, a z (1 - z)/(2 nu).
TEST(TwoDimensions, AChannelKeepsItsParabola) {
  Flow run(world, repeating + "nu = 0.05\nno_slip = true\n[gravity]\nacceleration = [0.6, 0]\n",
           {"domain.periodic=['x']", "particles.0.velocity=['6*z*(1-z)', '0']"});
  run.steps(400);
  const Cloud all = gathered(world, run.solver->particles());
  Real wrong = 0;
  for (std::size_t i = 0; i < all.id.size(); ++i) {
    const Real z = all.position[i].z();
    wrong = std::max(wrong, std::abs(all.velocity[i].x() - 6 * z * (1 - z)));
  }
  EXPECT_LT(wrong, 0.03);
}

// ---- settings of a program ----------------------------------------------------------------------------------------

Settings flat() {
  Settings settings;
  settings.domain = {Vec3(0, -3, 0), Vec3(2, 7, 2)};  // its extent along y is not used
  settings.fluid.dimensions = 2;
  return settings;
}

TEST(TwoDimensions, SettingsAreLaidInThePlane) {
  Settings settings = flat();
  ObstacleSettings rod;
  rod.shape = ShapeKind::cylinder;
  rod.center = Vec3(1, 5, 1);
  rod.axis = Vec3::UnitY();
  rod.radius = 0.3;
  settings.obstacles = {rod};
  const Settings once = resolved(settings), twice = resolved(once);
  EXPECT_EQ(once, twice);
  EXPECT_EQ(once.domain, (Box{Vec3(0, -0.05, 0), Vec3(2, 0.05, 2)}));
  EXPECT_EQ(once.obstacles[0].center.y(), 0);
  const auto shape = make_shape(once.obstacles[0]);
  EXPECT_NEAR(shape->distance(Vec3(0.1, 0, 50)), -0.2, 1e-12);
}

TEST(TwoDimensions, SettingsThatHaveNoPlaceThereAreRefused) {
  const auto refuses = [](const Settings& settings) {
    EXPECT_THROW(make_solver(world, settings, Particles{}), InputError);
  };
  const auto solver = make_solver(world, flat(), Particles{});
  Settings settings = flat();
  settings.periodic[1] = true;
  refuses(settings);
  settings = flat();
  settings.gravity = Vec3(0, 1, -9);
  refuses(settings);
  settings = flat();
  settings.slab_axis = 1;
  refuses(settings);
  settings = flat();
  settings.fluid.dimensions = 1;
  refuses(settings);
  settings = flat();
  settings.obstacles.resize(1);
  settings.obstacles[0].center = Vec3(1, 0, 1);
  settings.obstacles[0].radius = 0.3;  // a sphere
  refuses(settings);
  Particles off;
  off.id = {rank_of(world)};
  off.position = {Vec3(1, 0.01, 1)};
  off.velocity = {Vec3::Zero()};
  EXPECT_THROW(make_solver(world, flat(), off), InputError);
}

// Disordered water that moves over a floor as a whole, through the cells: it goes on, and is calm. Where volumes
// changed by other than what passes the faces, 0.033 m/s of 0.3 were lost in 15 s, the noise was five times as much,
// and in three dimensions it was the same.
TEST(TwoDimensions, WaterThatMovesAsAWholeIsNotHeldByTheCells) {
  const Scene scene = parse_scene("stream.toml", R"(
[domain]
dimensions = 2
min = [0, 0]
max = [4.8, 2.4]
periodic = ["x"]
[fluid]
spacing = 0.1
[[particles]]
min = [0, 0]
max = [4.8, 1.2]
velocity = [0.3, 0]
[time]
dt = 0.0166666667
end = 15
[gravity]
)",
                                  {});
  constexpr int lattices = 6;  // which differ by as much as the means below
  Real lost = 0, noise = 0;
  for (int lattice = 0; lattice < lattices; ++lattice) {
    Particles water = initial_particles(world, scene);
    for (std::size_t i = 0; i < water.position.size(); ++i) {
      std::mt19937_64 random(static_cast<std::uint64_t>(lattices * water.id[i] + lattice));
      std::uniform_real_distribution<Real> off(-0.03, 0.03);
      water.position[i] += Vec3(off(random), 0, off(random));
    }
    KeptRun run(world, scene, std::move(water));
    run.steps(900);
    const std::vector<Diagnostics>& rows = run.rows;
    const Real mass = 1000 * 0.1 * 0.1 * 0.1 * static_cast<Real>(rows.front().particles);
    for (std::size_t k = 450; k < 900; ++k)
      noise += (rows[k].kinetic_energy / mass - (rows[k].momentum / mass).squaredNorm() / 2) / (450 * lattices);
    lost += (0.3 - rows.back().momentum.x() / mass) / lattices;
  }
  std::printf("of 0.3 m/s %.4f are lost; noise %.2e m²/s²\n", lost, noise);
  EXPECT_LT(std::abs(lost), 0.02);
  EXPECT_LT(noise, 1.5e-3);
}

}  // namespace
}  // namespace trevi::test
