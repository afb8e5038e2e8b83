// What solids receive against what the water has: its angular momentum, and what each of them takes where several do.
#include <Eigen/Geometry>
#include <cmath>

#include "support/cloud.hpp"
#include "support/kept_run.hpp"
#include "support/tank.hpp"
#include "trevi/scene.hpp"

namespace trevi::test {
namespace {

struct MomentaRun : KeptRun {
  explicit MomentaRun(const std::string& text, const std::vector<std::string>& sets = {})
      : MomentaRun(MPI_COMM_SELF, text, sets) {}
  MomentaRun(MPI_Comm comm, const std::string& text, const std::vector<std::string>& sets = {})
      : KeptRun(comm, parse_scene("test.toml", text, sets)) {}
  Real mass() const { return scene.fluid.rest_density * std::pow(scene.fluid.spacing, 3); }
  /// About the origin, of the water.
  Vec3 angular_momentum() const {
    Vec3 sum = Vec3::Zero();
    const Particles& water = solver->particles();
    for (std::size_t i = 0; i < water.id.size(); ++i) sum += water.position[i].cross(water.velocity[i]);
    return mass() * sum;
  }
  Vec3 torque_of_weight() const {
    Vec3 sum = Vec3::Zero();
    for (const Vec3& x : solver->particles().position) sum += x.cross(*scene.gravity);
    return mass() * sum;
  }
  /// About the origin, on all that stands or turns about its centre.
  Vec3 torque_taken() const {
    Vec3 sum = Vec3::Zero();
    for (std::size_t k = 0; k < forces.back().size(); ++k) {
      sum += forces.back()[k].torque;
      if (k < scene.obstacles.size()) sum += scene.obstacles[k].center.cross(forces.back()[k].force);
    }
    return sum;
  }
};

const std::string plate_in_cylinder =
    tank_with_gravity({.min = "-0.65, -0.65, 0",
                       .max = "0.65, 0.65, 1",
                       .water = {{"-0.5, -0.5, 0", "0.5, 0.5, 0.5"}},
                       .dt = "0.0083333333333",
                       .spacing = "0.05",
                       .time = "cfl = 0"}) +
    "[[obstacle]]\ntype = 'cylinder'\ninside = true\ncenter = [0, 0, 0.5]\nradius = 0.5\nheight = 2\n"
    "[[obstacle]]\ntype = 'box'\ncenter = [0.1, 0.03, 0.5]\nsize = [0.4, 0.1, 2]\n";

// To rounding: sweeps that shift nothing leave it to what is recorded.
TEST(Momenta, AngularMomentumBalances) {
  for (const char* const turning : {"angular_velocity = [0, 0, 2]\n", "angular_velocity = [0.3, -0.2, 2]\n"}) {
    MomentaRun run(plate_in_cylinder + turning, {"density.max_shift=1e-9"});
    Real largest = 0;
    for (int k = 0; k < 40; ++k) {
      const Vec3 before = run.angular_momentum(), weight = run.torque_of_weight();
      run.steps(1);
      const Vec3 change = (run.angular_momentum() - before) / run.scene.dt, taken = run.torque_taken();
      largest = std::max(largest, std::abs(taken.z()));
      ASSERT_LT((change - (weight - taken)).norm(), 1e-8 * largest) << "step " << k;
    }
    EXPECT_GT(largest, 1);
  }
}

// Sweeps that shift particles change it by a little, at no solid.
TEST(Momenta, TorqueOnAPlateIsWhatItsWaterTakesOn) {
  MomentaRun run(plate_in_cylinder + "angular_velocity = [0, 0, 2]\n");
  Real taken = 0;
  for (int k = 0; k < 60; ++k) {
    run.steps(1);
    taken -= run.torque_taken().z() * run.scene.dt;
  }
  EXPECT_NEAR(taken / run.angular_momentum().z(), 1, 0.04);
}

// Two channels that repeat along y, in which water goes past a cylinder, this way and that. Walls take nothing along y,
// so that each cylinder takes what its own water loses.
TEST(Momenta, EachSolidTakesWhatItsWaterLoses) {
  MomentaRun run(tank_with_gravity({.max = "2.2, 1.6, 1.2",
                                    .water = {{"0, 0, 0", "1, 1.6, 0.8", "velocity = [0, 0.5, 0]"},
                                              {"1.2, 0, 0", "2.2, 1.6, 0.8", "velocity = [0, -0.5, 0]"}},
                                    .domain = "periodic = ['y']",
                                    .time = "cfl = 0"}) +
                 "[[obstacle]]\ntype = 'cylinder'\ncenter = [0.5, 0.83, 0.6]\nradius = 0.25\nheight = 2\n"
                 "[[obstacle]]\ntype = 'cylinder'\ncenter = [1.7, 0.77, 0.6]\nradius = 0.25\nheight = 2\n"
                 "[[obstacle]]\ntype = 'box'\ncenter = [1.1, 0.8, 0.6]\nsize = [0.2, 4, 4]\n");
  const auto momenta = [&] {
    std::array<Real, 2> sums{};
    const Particles& water = run.solver->particles();
    for (std::size_t i = 0; i < water.id.size(); ++i)
      sums[water.position[i].x() < 1.1 ? 0 : 1] += run.mass() * water.velocity[i].y();
    return sums;
  };
  run.steps(20);  // the start is an impact
  const std::array<Real, 2> before = momenta();
  std::array<Real, 2> taken{};
  for (int k = 0; k < 60; ++k) {
    run.steps(1);
    for (std::size_t n = 0; n < 2; ++n) taken[n] += run.forces.back()[n].force.y() * run.scene.dt;
    EXPECT_LT(std::abs(run.forces.back().back().force.y()), 1e-9);
  }
  const std::array<Real, 2> after = momenta();
  for (std::size_t n = 0; n < 2; ++n) {
    std::printf("taken over lost: %.3f\n", taken[n] / (before[n] - after[n]));
    EXPECT_NEAR(taken[n] / (before[n] - after[n]), 1, 0.1) << n;
  }
}

// Without gravity: two blocks of water in flight meet a ball each, and splash from
// it, but not as far as the walls. Dry cells beside the balls have particles, too.
TEST(Momenta, EachSolidInFlightTakesWhatItsWaterLoses) {
  MomentaRun run(tank_text({.max = "6, 3, 2.5",
                            .water = {{"1.6, 0.8, 0.85", "2.4, 1.3, 1.65", "velocity = [0, 1, 0]"},
                                      {"3.6, 0.8, 0.85", "4.4, 1.3, 1.65", "velocity = [0, 0.4, 0]"}}}) +
                 "[[obstacle]]\ntype = 'sphere'\ncenter = [2.03, 1.7, 1.27]\nradius = 0.25\n"
                 "[[obstacle]]\ntype = 'sphere'\ncenter = [4.03, 1.7, 1.27]\nradius = 0.25\n");
  const auto momenta = [&] {
    std::array<Vec3, 2> sums{Vec3::Zero(), Vec3::Zero()};
    const Particles& water = run.solver->particles();
    for (std::size_t i = 0; i < water.id.size(); ++i)
      sums[water.position[i].x() < 3 ? 0 : 1] += run.mass() * water.velocity[i];
    return sums;
  };
  const std::array<Vec3, 2> before = momenta();
  std::array<Vec3, 2> taken{Vec3::Zero(), Vec3::Zero()};
  for (int k = 0; k < 60; ++k) {
    run.steps(1);
    for (std::size_t n = 0; n < 2; ++n) taken[n] += run.forces.back()[n].force * run.scene.dt;
    EXPECT_TRUE(run.forces.back().back().force.isZero(0)) << "of the walls";
  }
  const std::array<Vec3, 2> after = momenta();
  for (std::size_t n = 0; n < 2; ++n) {
    const Real off = (taken[n] - before[n] + after[n]).norm(), lost = (before[n] - after[n]).norm();
    std::printf("taken over lost: %.4f, off by %.4f of it\n", taken[n].y() / (before[n] - after[n]).y(), off / lost);
    EXPECT_LT(off, 0.05 * lost) << n;
  }
}

// Of the water and of what obstacles and box receive: a jet that hits a ball at one end of a long box, where some ranks
// have no water.
TEST(Momenta, SameBitsOfAJetOnABall) {
  const std::string scene = tank_with_gravity({.max = "4, 1, 1.2", .end = "0.7"}) +
                            "[[inlet]]\ncenter = [0.4, 0.47, 1]\nradius = 0.15\ndirection = [0.1, 0, -1]\nspeed = 2\n"
                            "[[obstacle]]\ntype = 'sphere'\ncenter = [0.5, 0.5, 0.4]\nradius = 0.2\n";
  MomentaRun alone(MPI_COMM_SELF, scene), together(MPI_COMM_WORLD, scene);
  for (MomentaRun* run : {&alone, &together}) run->steps(42);
  expect_same_bits(gathered(MPI_COMM_WORLD, together.solver->particles()),
                   gathered(MPI_COMM_SELF, alone.solver->particles()));
  ASSERT_EQ(together.forces.size(), alone.forces.size());
  Real most = 0;
  for (std::size_t step = 0; step < alone.forces.size(); ++step) {
    for (std::size_t k = 0; k < alone.forces[step].size(); ++k) {
      EXPECT_EQ(together.forces[step][k].force, alone.forces[step][k].force) << step;
      EXPECT_EQ(together.forces[step][k].torque, alone.forces[step][k].torque) << step;
    }
    most = std::max(most, -alone.forces[step].front().force.z());
  }
  EXPECT_GT(most, 50);
}

}  // namespace
}  // namespace trevi::test
