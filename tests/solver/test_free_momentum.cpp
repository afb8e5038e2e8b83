// FreeMomentum alone, around a density solver that gives every particle a velocity of its own: linear and angular
// momentum are those of before to rounding, by a rigid motion alone, and near a wall nothing is changed.
#include "solver/free_momentum.hpp"

#include <Eigen/Geometry>

#include "domain/migrate.hpp"
#include "support/cloud.hpp"

namespace trevi::test {
namespace {

constexpr Real h = 0.2, dt = 0.01;
const Box wide_box{Vec3::Zero(), Vec3(4, 2, 2)};

/// Velocities of the free paths, and something more.
class Disturbing : public DensitySolver<double> {
 public:
  static Vec3 disturbance(const Vec3& p) { return {0.3 * p.y() * p.y(), std::sin(5 * p.x()), 0.2 + p.x() * p.z()}; }
  SolveResult solve(DensityProblem<double>& problem) override {
    Particles& all = problem.particles();
    for (std::size_t i = 0; i < all.id.size(); ++i)
      all.velocity[i] = (all.predicted[i] - all.position[i]) / dt + disturbance(all.predicted[i]);
    return {};
  }
};

/// A block of 10 x 5 x 5 particles with its corner at `low`, or the first `count` of them.
struct Block {
  explicit Block(const Vec3& low, GlobalId count = 250)
      : grid(wide_box.min, wide_box.max, h, 0),
        slabs(std::vector<Real>(static_cast<std::size_t>(grid.planes()), 1.0), size_of(world)),
        near(world, grid, wide_box.min, h),
        boundary(make_boundary({Walls(wide_box, WallSettings{}, 1e-6 * h), nullptr, {}})),
        constraint(DensityModel{}, std::nullopt, std::nullopt) {
    for (GlobalId k = rank_of(world); k < count; k += size_of(world)) {
      const GlobalId i = k / 25, j = k / 5 % 5, l = k % 5;
      const Vec3 p = low + 0.1 * Vec3(static_cast<Real>(i), static_cast<Real>(j), static_cast<Real>(l));
      particles.id.push_back(k);
      particles.predicted.push_back(p);
      particles.position.push_back(p - dt * Vec3(1, p.x(), -p.y()));
      particles.velocity.push_back(Vec3::Zero());
    }
    migrate(world, particles, &Particles::predicted, grid, slabs);
    near.rebuild(particles, slabs);
  }
  void solve() {
    DensityProblem<double> problem(world, near, constraint, *boundary, Vec3::Zero());
    problem.start(particles, dt);
    FreeMomentum<double> solver({world, grid, wide_box, constraint.model(), h / 2, Vec3::Zero()},
                                std::make_unique<Disturbing>());
    solver.solve(problem);
  }
  // Linear, then angular.
  std::array<Real, 6> momenta(const std::function<Vec3(std::size_t)>& velocity) const {
    std::array<Real, 6> sums{};
    for (std::size_t i = 0; i < particles.id.size(); ++i) {
      const Vec3 v = velocity(i), spin = particles.predicted[i].cross(v);
      for (const int a : {0, 1, 2}) {
        sums[static_cast<std::size_t>(a)] += v[a];
        sums[static_cast<std::size_t>(a + 3)] += spin[a];
      }
    }
    MPI_Allreduce(MPI_IN_PLACE, sums.data(), 6, MPI_DOUBLE, MPI_SUM, world);
    return sums;
  }
  Vec3 free_velocity(std::size_t i) const { return (particles.predicted[i] - particles.position[i]) / dt; }
  Vec3 disturbed(std::size_t i) const { return free_velocity(i) + Disturbing::disturbance(particles.predicted[i]); }

  CellGrid grid;
  Slabs slabs;
  Neighbourhood<double> near;
  std::unique_ptr<Boundary> boundary;
  DensityConstraint<double> constraint;
  Particles particles;
};

TEST(FreeMomentum, IsThatOfTheFreePathsByARigidMotion) {
  Block block(Vec3(1.45, 0.75, 0.75));
  block.solve();
  const auto before = block.momenta([&](std::size_t i) { return block.free_velocity(i); });
  const auto after = block.momenta([&](std::size_t i) { return block.particles.velocity[i]; });
  for (std::size_t a = 0; a < 6; ++a) EXPECT_NEAR(after[a], before[a], 1e-10) << a;
  const std::vector<Vec3>& p = block.particles.predicted;
  for (std::size_t i = 1; i < p.size(); ++i) {  // what is taken off changes no distance
    const Vec3 off = block.disturbed(i) - block.particles.velocity[i];
    const Vec3 off_first = block.disturbed(0) - block.particles.velocity[0];
    EXPECT_NEAR((off - off_first).dot(p[i] - p[0]), 0, 1e-10);
  }
}

// One particle has no inertia, two and a row of them none about their line; wherever they lie in their cell.
TEST(FreeMomentum, IsThatOfTheFreePathsOfAFewParticles) {
  for (const GlobalId count : {1, 2, 3, 5, 7}) {
    for (const Real off : {0.0, 0.013, 0.1}) {
      SCOPED_TRACE(testing::Message() << count << " particles, " << off << " m");
      Block block(Vec3(1.45 + off, 0.75 - off, 0.75 + off / 3), count);
      block.solve();
      const auto before = block.momenta([&](std::size_t i) { return block.free_velocity(i); });
      const auto after = block.momenta([&](std::size_t i) { return block.particles.velocity[i]; });
      for (std::size_t a = 0; a < 6; ++a) EXPECT_NEAR(after[a], before[a], 1e-11) << a;
      for (const Vec3& v : block.particles.velocity) EXPECT_LT(v.norm(), 10);
    }
  }
}

// The floor takes what it takes upwards; along it nothing pushes.
TEST(FreeMomentum, BelongsToWallsAcrossThem) {
  Block block(Vec3(1.45, 0.75, 0.05));
  block.solve();
  const auto before = block.momenta([&](std::size_t i) { return block.free_velocity(i); });
  const auto after = block.momenta([&](std::size_t i) { return block.particles.velocity[i]; });
  for (const std::size_t a : {0U, 1U}) EXPECT_NEAR(after[a], before[a], 1e-10) << a;
  for (std::size_t i = 0; i < block.particles.id.size(); ++i) {
    const Vec3 off = block.disturbed(i) - block.particles.velocity[i];
    EXPECT_NEAR((off - (block.disturbed(0) - block.particles.velocity[0])).norm(), 0, 1e-10);
    EXPECT_EQ(off.z(), 0);
  }
}

}  // namespace
}  // namespace trevi::test
