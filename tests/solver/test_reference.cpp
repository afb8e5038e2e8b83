// Whole steps of the distributed solver against the brute-force reference, from the definitions, in double precision:
// positions agree within 1e-9 m after one and after three steps, whatever is switched on, and those of pools that are
// solved as by default within 1e-11 m.
#include <array>

#include "reference/reference.hpp"

namespace trevi::test {
namespace {

/// Largest distance between two arrays of vectors, which may be whole periods apart.
Real farthest(const std::vector<Vec3>& a, const std::vector<Vec3>& b, const Vec3& period = Vec3::Zero()) {
  Real largest = 0;
  for (std::size_t k = 0; k < a.size(); ++k) {
    Vec3 way = a[k] - b[k];
    for (int i = 0; i < 3; ++i)
      if (period[i] > 0) way[i] -= period[i] * std::round(way[i] / period[i]);
    const Real d = way.norm();
    if (!(d <= largest)) largest = d;  // a NaN stays
  }
  return largest;
}

struct Deviation {
  Real position = 0, velocity = 0;
};

/// Lengths of the axes along which the box repeats, 0 of others.
Vec3 period_of(const Scene& scene) {
  Vec3 period = scene.domain.max - scene.domain.min;
  for (int a = 0; a < 3; ++a) period[a] = scene.periodic[static_cast<std::size_t>(a)] ? period[a] : 0;
  return period;
}

/// Deviation from the reference, which counts cells from the corner of the box, after 1 and after 3 steps; rank 0
/// compares, the others see zero.
std::array<Deviation, 2> deviations(const Scene& scene, const Cloud& cloud) {
  SolverExtras extras;
  extras.first_cell.emplace();
  const std::unique_ptr<Solver> solver = solver_of(world, scene, cloud, std::move(extras));
  Reference reference(scene, cloud);
  std::array<Deviation, 2> result;
  for (int step = 1; step <= 3; ++step) {
    solver->step();
    const Cloud found = gathered(world, solver->particles());
    if (rank_of(world) != 0) continue;
    reference.step(solver->clock().substeps);
    if (step == 2) continue;
    EXPECT_EQ(found.id, reference.cloud().id);
    result[step == 1 ? 0 : 1] = {farthest(found.position, reference.cloud().position, period_of(scene)),
                                 farthest(found.velocity, reference.cloud().velocity)};
  }
  return result;
}

// Enough for densities on both sides of rest density, so that both constraints have work.
constexpr int particles = 1400;

void expect_reference(const std::string& text, const std::vector<std::string>& overrides) {
  const Scene scene = scene_with(text, overrides);
  const Cloud cloud = random_cloud(particles, box_of(scene), 1, 0.06);
  for (const Deviation& d : deviations(scene, cloud)) {
    EXPECT_LT(d.position, 1e-9);
    EXPECT_LT(d.velocity, 1e-7);
  }
}

const std::vector<std::string> tensile = {"tensile.k=0.001", "tensile.n=4", "tensile.dq=0.2"};
const std::vector<std::string> filters = {"vorticity.epsilon=0.002", "viscosity.c=0.0005"};

std::vector<std::string> joined(std::vector<std::string> a, const std::vector<std::string>& b) {
  a.insert(a.end(), b.begin(), b.end());
  return a;
}

TEST(Reference, PlainDensitySolve) { expect_reference(cloud_scene, {}); }

TEST(Reference, EveryConstraintMassAndReflectionWithAllFeatures) {
  for (const char* constraint : {"equality", "inequality"}) {
    for (const char* mass : {"calibrated", "volume"}) {
      for (const char* reflection : {"normal", "report"}) {
        SCOPED_TRACE(std::string(constraint) + " " + mass + " " + reflection);
        expect_reference(cloud_scene,
                         joined(joined(tensile, filters), {std::string("density.constraint='") + constraint + "'",
                                                           std::string("fluid.mass='") + mass + "'",
                                                           std::string("walls.reflection='") + reflection + "'"}));
      }
    }
  }
}

TEST(Reference, EachFeatureAlone) {
  expect_reference(cloud_scene, tensile);
  expect_reference(cloud_scene, {"tensile.k=0.002", "tensile.n=3", "tensile.dq=0.3"});
  expect_reference(cloud_scene, {"vorticity.epsilon=0.005"});
  expect_reference(cloud_scene, {"viscosity.c=0.0008"});
  expect_reference(cloud_scene, {"density.relaxation=1", "density.epsilon=600", "density.iterations=6"});
  expect_reference(cloud_scene, {"walls.restitution=0"});
  expect_reference(cloud_scene, {"walls.restitution=1", "walls.reflection='report'"});
}

TEST(Reference, KernelsOfDensityAndGradient) {
  expect_reference(cloud_scene, {"fluid.density_kernel='wendland_c2'"});
  expect_reference(cloud_scene, {"fluid.density_kernel='poly6'", "fluid.gradient_kernel='wendland_c2'"});
  expect_reference(cloud_scene, {"fluid.density_kernel='spiky'", "fluid.gradient_kernel='poly6'"});
  expect_reference(cloud_scene, {"fluid.density_kernel='spiky'"});
  expect_reference(cloud_scene, joined(joined(tensile, filters), {"fluid.density_kernel='spiky'"}));
}

// The box of the clouds with nothing but what every scene has: all else are the defaults.
const std::string default_scene = tank_with_gravity({.min = "-0.3, 0.2, 0.1",
                                                     .max = "1.2, 1.25, 1.0",
                                                     .water = {{"0.0, 0.3, 0.1", "0.2, 0.5, 0.3"}},
                                                     .dt = "0.0166666667",
                                                     .end = "1.0"}) +
                                  R"(acceleration = [0.3, -0.2, -9.8]
[random]
seed = 9
)";

/// Water whose surface slopes from `low` to `high` shares of the box along x, and above it every 15th particle as
/// spray.
Cloud sloping_pool(const Scene& scene, Real low, Real high) {
  const Cloud all = random_cloud(particles, box_of(scene), 0.3, 0.06);
  const Vec3 extent = scene.domain.max - scene.domain.min;
  Cloud pool;
  for (std::size_t k = 0; k < all.id.size(); ++k) {
    const Vec3 place = (all.position[k] - scene.domain.min).cwiseQuotient(extent);
    if (k % 15 == 0 || place.z() < low + (high - low) * place.x())
      pool.add(all.id[k], all.position[k], all.velocity[k]);
  }
  return pool;
}

/// Found: 6e-15 m after a step and 2e-13 m after three.
void expect_reference_of_pool(const std::vector<std::string>& overrides, Real low = 0.3, Real high = 0.8) {
  const Scene scene = scene_with(default_scene, overrides);
  SCOPED_TRACE(::testing::PrintToString(overrides));
  for (const Deviation& d : deviations(scene, sloping_pool(scene, low, high))) {
    EXPECT_LT(d.position, 1e-11);
    EXPECT_LT(d.velocity, 1e-9);
  }
}

TEST(Reference, WallsContributionToDensity) {
  expect_reference(cloud_scene, {"walls.density='analytic'"});
  expect_reference(cloud_scene,
                   {"walls.density='analytic'", "fluid.density_kernel='poly6'", "fluid.kernel_radius=0.27"});
}

TEST(Reference, AccelerationByChebyshevWeights) {
  expect_reference(cloud_scene,
                   {"density.method='chebyshev'", "density.constraint='inequality'", "density.iterations=6"});
  expect_reference(cloud_scene,
                   {"density.method='chebyshev'", "density.constraint='inequality'", "density.max_shift=0.002"});
}

TEST(Reference, ProjectionGridAlone) {
  expect_reference_of_pool({"density.method='jacobi'", "density.coarse_grid=true", "density.iterations=2",
                            "density.relaxation=0.000001", "walls.density='none'"});
}

TEST(Reference, DefaultStep) {
  expect_reference_of_pool({});
  expect_reference_of_pool({}, 0.9, 1.0);  // up to the ceiling
  expect_reference_of_pool({}, 0.05, 0.3);
}

/// Water of the given density in layers of the given shares of the box's height.
Cloud layered(const Scene& scene, const std::vector<std::pair<Real, Real>>& layers, int count) {
  const Cloud all = random_cloud(count, box_of(scene), 0.3, 0.06);
  Cloud some;
  for (std::size_t k = 0; k < all.id.size(); ++k) {
    const Real z = (all.position[k].z() - scene.domain.min.z()) / (scene.domain.max.z() - scene.domain.min.z());
    for (const auto& [low, high] : layers)
      if (z >= low && z < high) some.add(all.id[k], all.position[k], all.velocity[k]);
  }
  return some;
}

// A slab of water above the pool, with nothing in between; and a column of thin spray from the floor on.
TEST(Reference, DefaultStepOfWaterInTheAir) {
  const Scene scene = scene_with(default_scene, {"domain.max=[1.2, 1.25, 1.6]"});
  for (const Cloud& cloud : {layered(scene, {{0, 0.2}, {0.5, 0.75}}, 2200), layered(scene, {{0, 0.8}}, 900)}) {
    for (const Deviation& d : deviations(scene, cloud)) {
      EXPECT_LT(d.position, 1e-11);
      EXPECT_LT(d.velocity, 1e-9);
    }
  }
}

TEST(Reference, DefaultStepWithWiderAndOtherKernels) {
  expect_reference_of_pool({"fluid.kernel_radius=0.25"});
  expect_reference_of_pool({"fluid.kernel_radius=0.187", "fluid.density_kernel='poly6'"});
  expect_reference_of_pool({"fluid.kernel_radius=0.24", "fluid.density_kernel='wendland_c2'"});
  expect_reference_of_pool({"domain.slab_axis='y'"});
  expect_reference_of_pool({"time.dt=0.05"});  // in substeps
}

// An odd and an even number of cells around, as many as 3; the slabs along an axis that repeats or across it.
TEST(Reference, DefaultStepInAPeriodicTank) {
  const std::string wide = "domain.max=[1.3, 1.2, 1.0]", odd = "domain.max=[1.1, 1.2, 1.0]";
  expect_reference_of_pool({wide, "domain.periodic=['x', 'y']"});
  expect_reference_of_pool({odd, "domain.periodic=['x', 'y']", "domain.slab_axis='y'"});
  expect_reference_of_pool({odd, "domain.periodic=['x']"});
  expect_reference_of_pool({wide, "domain.periodic=['y']"}, 0.05, 0.3);
  expect_reference_of_pool({"domain.max=[1.1, 0.8, 1.0]", "domain.periodic=['x', 'y']"});
  const Scene narrow = scene_with(default_scene, {"domain.max=[1.1, 0.8, 1.0]", "domain.periodic=['x', 'y']"});
  for (const Deviation& d : deviations(narrow, layered(narrow, {{0, 0.7}}, 800))) {
    EXPECT_LT(d.position, 1e-11);
    EXPECT_LT(d.velocity, 1e-9);
  }
}

/// The lattice of a scene's box or of a part of it, each coordinate off by up to 0.2 spacings.
Cloud shaken_lattice(const Scene& scene, const Vec3& low, const Vec3& high) {
  const Real spacing = scene.fluid.spacing;
  const Cloud noise = random_cloud(4000, Box{Vec3::Constant(-0.2 * spacing), Vec3::Constant(0.2 * spacing)}, 0.3);
  const Vec3 extent = scene.domain.max - scene.domain.min;
  const auto in_space = [&](const Vec3& v) { return scene.fluid.dimensions == 2 ? Vec3(v.x(), 0, v.z()) : v; };
  Cloud lattice;
  for (Real x = 0.5; x < extent.x() / spacing; ++x) {
    for (Real y = 0.5; y < extent.y() / spacing; ++y) {
      for (Real z = 0.5; z < extent.z() / spacing; ++z) {
        const Vec3 p = scene.domain.min + spacing * Vec3(x, y, z);
        const std::size_t k = lattice.id.size();
        if ((p.array() > low.array()).all() && (p.array() < high.array()).all())
          lattice.add(noise.id[k], in_space(p + noise.position[k]), in_space(noise.velocity[k]));
      }
    }
  }
  return lattice;
}

void expect_reference_of_cloud(const Scene& scene, const Cloud& cloud) {
  for (const Deviation& d : deviations(scene, cloud)) {
    EXPECT_LT(d.position, 1e-11);
    EXPECT_LT(d.velocity, 1e-9);
  }
}

// Two blocks that meet above a pool, and a drop far from them: pieces of water that touch nothing, beside one that
// does.
TEST(Reference, DefaultStepOfBlocksThatMeetAboveAPool) {
  const Scene scene = scene_with(default_scene, {"domain.min=[0, 0, 0]", "domain.max=[2.2, 1.6, 2.2]"});
  Cloud cloud = shaken_lattice(scene, Vec3(0, 0, 0), Vec3(2.2, 1.6, 0.3));
  const auto add = [&](const Vec3& low, const Vec3& high, const Vec3& velocity) {
    const Cloud block = shaken_lattice(scene, low, high);
    for (std::size_t k = 0; k < block.id.size(); ++k)
      cloud.add(block.id[k] + 100000 * static_cast<GlobalId>(cloud.id.size()), block.position[k],
                velocity + block.velocity[k]);
  };
  add(Vec3(0.5, 0.5, 0.9), Vec3(1.0, 1.0, 1.4), Vec3(2, 0, 0));
  add(Vec3(1.0, 0.6, 1.0), Vec3(1.5, 1.1, 1.5), Vec3(-2, 0, 0.5));
  add(Vec3(1.8, 1.1, 1.7), Vec3(1.9, 1.3, 1.9), Vec3(-1, 0, 0.5));
  expect_reference_of_cloud(scene, cloud);
}

// With gravity and without. Without a surface there are more cycles, nothing returns, and phi has its origin at its
// largest value.
TEST(Reference, DefaultStepOfClosedWater) {
  for (const char* gravity : {"gravity.acceleration=[0.3, -0.2, -9.8]", "gravity.acceleration=[0, 0, 0]"}) {
    const std::vector<std::string> closed{gravity, "time.cfl=0", "particles.0.max=[0.1, 0.5, 0.3]"};
    SCOPED_TRACE(gravity);
    const Scene scene = scene_with(default_scene, joined(closed, {"domain.max=[1.1, 1.0, 1.1]"}));
    expect_reference_of_cloud(scene, shaken_lattice(scene, scene.domain.min, scene.domain.max));
    if (size_of(world) > 1) continue;  // a single column of cells is on a single rank
    const Scene column = scene_with(default_scene, joined(closed, {"domain.max=[0.1, 0.6, 0.9]"}));
    expect_reference_of_cloud(column, shaken_lattice(column, column.domain.min, column.domain.max));
  }
}

// In a closed box, half full of water that moves; and of water that touches nothing.
TEST(Reference, DefaultStepWithoutGravity) {
  const Scene scene = scene_with(default_scene, {"gravity.acceleration=[0, 0, 0]", "time.cfl=0"});
  expect_reference_of_cloud(scene, sloping_pool(scene, 0.3, 0.8));
  const Scene wide = scene_with(default_scene, {"gravity.acceleration=[0, 0, 0]", "time.cfl=0", "domain.min=[0, 0, 0]",
                                                "domain.max=[2.2, 2.1, 2.0]"});
  expect_reference_of_cloud(wide, shaken_lattice(wide, Vec3(0.6, 0.6, 0.6), Vec3(1.6, 1.3, 1.2)));
}

// Repeating along z, too; full and with a surface.
TEST(Reference, DefaultStepWithoutGravityInAPeriodicBox) {
  for (const char* axes : {"domain.periodic=['z']", "domain.periodic=['x', 'z']", "domain.periodic=['x', 'y', 'z']"}) {
    for (const char* max : {"domain.max=[1.25, 1.0, 1.0]", "domain.max=[1.5, 1.25, 0.75]"}) {
      SCOPED_TRACE(std::string(axes) + " " + max);
      const Scene scene = scene_with(default_scene, {"gravity.acceleration=[0, 0, 0]", "time.cfl=0", axes, max,
                                                     "domain.min=[0, 0, 0]", "fluid.kernel_radius=0.25"});
      expect_reference_of_cloud(scene, shaken_lattice(scene, scene.domain.min, scene.domain.max));
      expect_reference_of_cloud(scene, sloping_pool(scene, 0.3, 0.8));
      expect_reference_of_cloud(scene, sloping_pool(scene, 0.9, 0.8));
    }
  }
}

/// A random cloud in the layer of a scene of two dimensions.
Cloud flat_cloud(const Scene& scene, int count, Real speed) {
  Box layer = scene.domain;
  layer.min.y() = layer.max.y() = 0;
  Cloud cloud = random_cloud(count, layer, speed, 0.06);
  for (Vec3& v : cloud.velocity) v.y() = 0;
  return cloud;
}

// Found: 7e-16 m, and 2e-13 m with Wendland's kernel.
TEST(Reference, TwoDimensions) {
  const std::vector<std::string> plane{"domain.dimensions=2", "gravity.acceleration=[0.3, -9.8]"};
  const std::vector<std::vector<std::string>> by_default{{},
                                                         joined(tensile, filters),
                                                         {"fluid.kernel_radius=0.25"},
                                                         {"fluid.density_kernel='wendland_c2'"},
                                                         {"domain.max=[1.3, 1.0]", "domain.periodic=['x']"},
                                                         {"gravity.acceleration=[0, 0]", "time.cfl=0"}};
  for (const std::vector<std::string>& more : by_default) {
    SCOPED_TRACE(::testing::PrintToString(more));
    const Scene scene = scene_with(default_scene, joined(plane, more));
    expect_reference_of_cloud(scene, flat_cloud(scene, 110, 0.3));
  }
  // Water that touches nothing keeps its momenta.
  const Scene wide = scene_with(default_scene, joined(plane, {"gravity.acceleration=[0, 0]", "time.cfl=0",
                                                              "domain.min=[0, 0]", "domain.max=[2.2, 2]"}));
  expect_reference_of_cloud(wide, shaken_lattice(wide, Vec3(0.6, -1, 0.6), Vec3(1.6, 1, 1.2)));
  for (const char* mass : {"fluid.mass='calibrated'", "fluid.mass='volume'"}) {
    const Scene scene = scene_with(cloud_scene, joined(joined(plane, joined(tensile, filters)), {mass}));
    expect_reference_of_cloud(scene, flat_cloud(scene, 150, 1));
  }
}

TEST(Reference, DefaultStepWithAllFeatures) {
  expect_reference_of_pool(joined(joined(tensile, filters), {"walls.reflection='report'"}));
}

TEST(Reference, OtherSlabAxisAndOddKernelRadius) {
  expect_reference(cloud_scene, joined(filters, {"domain.slab_axis='y'"}));
  expect_reference(cloud_scene, joined(tensile, {"fluid.kernel_radius=0.187"}));
}

TEST(Reference, FinerSpacingScalesTheConstants) {
  expect_reference(cloud_scene, joined(joined(tensile, filters), {"fluid.spacing=0.08", "fluid.rest_density=850"}));
}

TEST(Reference, FountainInPlaceOfGravity) {
  const std::string fountain =
      "[[fountain]]\ncenter = [0.45, 0.7]\ndiameter = 0.6\nheight = 0.4\ndirection = [0.1, 0, 0.9]\nspeed = 3\n"
      "jitter = 2\nstart = 0.01\n[[fountain]]\ncenter = [0.0, 0.7]\ndiameter = 0.3\nheight = 0.9\nspeed = 2\n"
      "jitter = 1\nstop = 0.03\n";
  expect_reference(cloud_scene + fountain, {});
}

// The preset is literal: nothing but what the report names. Its plain iteration throws a random cloud about, which
// doubles an error at each turn, so one step is compared.
TEST(Reference, PresetOfTheReport) {
  const std::string bare = cloud_scene.substr(0, cloud_scene.find("[density]")) + "[density]\npreset = 'report'\n";
  const Scene scene = scene_with(bare, {"fluid.mass='volume'"});
  const auto [one, three] = deviations(scene, random_cloud(500, box_of(scene), 1, 0.06));
  EXPECT_LT(one.position, 1e-9);
  EXPECT_TRUE(scene.tensile && scene.vorticity && scene.viscosity);
}

// n is chosen by the solver; the reference follows it once it is seen to obey the rule of inputs/README.md, "Time".
TEST(Reference, Substeps) {
  const Scene scene = scene_with(cloud_scene, joined(filters, {"time.cfl=0.4"}));
  const Cloud cloud = random_cloud(particles, box_of(scene), 1, 0.06);
  Real fastest = 0;
  for (const Vec3& v : cloud.velocity) fastest = std::max(fastest, v.norm());
  const std::unique_ptr<Solver> solver = solver_of(world, scene, cloud);
  solver->step();
  const int n = solver->clock().substeps;
  const Real limit = 0.4 * scene.fluid.kernel_radius, g = scene.gravity->norm();
  EXPECT_GE(n, static_cast<int>(std::ceil(scene.dt * fastest / limit - 1e-6)));
  EXPECT_LE(n, static_cast<int>(std::ceil(scene.dt * (fastest + g * scene.dt) / limit)));
  EXPECT_GT(n, 2);
  const auto [one, three] = deviations(scene, cloud);
  EXPECT_LT(one.position, 1e-9);
  EXPECT_LT(three.position, 1e-8);  // each step is several
}

// Pairs in single precision: a coordinate is kept to 2^-22 h, 5e-8 m, and a sum to about 1e-7 of its terms.
// Stated bound: 1e-6 m (5e-6 h) after a step, ten times that after three.
TEST(Reference, SinglePrecision) {
  const Scene scene = scene_with(cloud_scene, joined(joined(tensile, filters), {"density.precision='single'"}));
  const auto [one, three] = deviations(scene, random_cloud(particles, box_of(scene), 1, 0.06));
  EXPECT_LT(one.position, 1e-6);
  EXPECT_LT(three.position, 1e-5);
  EXPECT_TRUE(rank_of(world) != 0 || one.position > 1e-12) << "single precision is not in use";
}

}  // namespace
}  // namespace trevi::test
