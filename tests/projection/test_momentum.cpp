// What the pressure gives to all particles together: nothing, but through floor and walls.
#include <cmath>
#include <cstdio>

#include "stages.hpp"

namespace trevi::test {
namespace {

constexpr Real spacing = 0.1;
const Vec3 corner = Lattice{}.box.min;

// A heap with one side that overhangs and one that leans as much, and one with an upright side: what floor and air do
// to them has no sum along the floor. The pressure at a side so gives its particles what it has taken from those behind
// them. As if those at the side were as many as inside, heaps gained 0.01 to 0.04 of their weight.
TEST(Projection, HeapsKeepTheirMomentumAlongTheFloor) {
  constexpr Real g_dt2 = 9.8 / 3600;
  const Box wide{corner, corner + Vec3(4, 1.2, 1.4)};
  struct Sides {
    Real left, right;
  };
  for (const Sides& leans : {Sides{0.36, 0.36}, Sides{1, 1}, Sides{0, -0.36}, Sides{0, -1}}) {
    const auto holds = [&](const Vec3& p) {
      const Real height = p.z() - wide.min.z(), along = p.x() - wide.min.x();
      return height < 0.8 && along > 1 + leans.left * height && along < 2.4 + leans.right * height;
    };
    Water water([](const Vec3&) { return Vec3(0, 0, -g_dt2); }, {.top = 1.2, .at = 0, .box = wide, .holds = holds});
    Vec3 given = Vec3::Zero();
    const auto all = displacements(water, spacing, 9.8);
    for (const auto& one : all) given += vector_of(one);
    MPI_Allreduce(MPI_IN_PLACE, given.data(), 3, MPI_DOUBLE, MPI_SUM, world);
    const auto count = static_cast<Real>(sum_over_ranks(world, GlobalId{water.particles.size()}));
    given /= g_dt2 * count;
    std::printf("sides %g, %g: %.4f of the weight along the floor, %.2f upwards\n", leans.left, leans.right, given.x(),
                given.z());
    EXPECT_GT(given.z(), 0.3);
    EXPECT_LT(std::abs(given.x()), 0.03);
  }
}

// Water of which a cell holds three eighths less goes against full water in a wide box that it fills to the ceiling:
// what the pressure takes from the one it gives to the other, its sides in air included, but in the rows of cells at
// walls, which weigh as full ones: there the thin water gets what its particles are of these. As if all cells were full
// a third of it came from nowhere.
TEST(Pressure, KeepsTheMomentumOfThinWaterThatMeetsFullWater) {
  const Box wide{corner, corner + Vec3(2.4, 4, 4)};
  const auto holds = [](const Vec3& p) {
    const Eigen::Vector3i half = ((p - corner) / spacing).array().floor().cast<int>();
    const Eigen::Vector3i in_cell(half.x() % 2, half.y() % 2, half.z() % 2);
    const bool left_out = in_cell == Eigen::Vector3i(0, 0, 0) || in_cell == Eigen::Vector3i(1, 1, 0) ||
                          in_cell == Eigen::Vector3i(1, 0, 1);
    return std::abs(p.x() - 1) < 0.8 && !(p.x() > 1 && left_out);
  };
  Water water([](const Vec3& p) { return Vec3(p.x() < 1 ? 0.01 : -0.01, 0, 0); },
              {.top = wide.max.z(), .box = wide, .holds = holds});
  Stages at(water, spacing);
  at.classify();
  at.solve(0);
  std::array<Real, 4> given{};  // to full water, to thin; the same in rows at walls
  at.for_each_cell([&](LocalId k, LocalId r, LocalId c) {
    const bool at_wall = r == 0 || r + 1 == at.grid.rows() || c == 0 || c + 1 == at.grid.columns();
    const std::size_t low = at.grid.index(k, r, c);
    const auto through = [&](std::size_t face) { return at.pressure.displacement(*at.surface, 0, face); };
    const ParticlesToGrid::Means held = at.transfer.means(low);
    if (held.n == 0) return;
    const Real from_low = held.y[at.grid.axis(0)];
    given[(at_wall ? 2U : 0U) + (at.middle(k, r, c).x() < 1 ? 0U : 1U)] +=
        (held.n - from_low) * through(low) + from_low * through(low + at.grid.step(0));
  });
  MPI_Allreduce(MPI_IN_PLACE, given.data(), 4, MPI_DOUBLE, MPI_SUM, world);
  std::printf("given %.4f, %.4f m; at walls %.4f, %.4f m\n", given[0], given[1], given[2], given[3]);
  EXPECT_LT(given[0], -1);
  EXPECT_NEAR(given[1] / given[0], -1, 0.1);
  EXPECT_LT(given[2], -0.1);
  EXPECT_NEAR(given[3] / given[2], -5.0 / 8, 0.1);
}

}  // namespace
}  // namespace trevi::test
