// The stages of the projection, each alone: affine motion passes the transfer exactly however particles lie, damping
// and the filter of shifts keep what they should, water that moves as a whole has no pressure, and a full box rests.
// Volumes and levels are in test_volumes.cpp, the Poisson equation in test_poisson.cpp, what pressure gives in all in
// test_momentum.cpp.
#include <Eigen/Geometry>
#include <cmath>
#include <random>

#include "stages.hpp"

namespace trevi::test {
namespace {

constexpr Real s = 0.1, h = 2 * s;
const Box box = Lattice{}.box;

Vec3 affine_motion(const Vec3& p) {
  Eigen::Matrix3d slope;
  slope << 0.02, -0.05, 0.01, 0.04, -0.03, 0.02, -0.01, 0.03, 0.01;
  return Vec3(0.011, -0.007, 0.004) + slope * (p - Vec3(0.9, 0.7, 0.8));
}

TEST(ParticlesToGrid, AffineMotionIsExactAtFaces) {
  for (const Real jitter : {0.0, 0.4}) {
    Water water(affine_motion, {.jitter = jitter, .offset = Vec3(0.03, 0.017, 0.041)});
    Stages at(water, s);
    at.gather();
    Real wrong = 0;
    int faces = 0;
    at.for_each_cell([&](LocalId k, LocalId r, LocalId c) {
      const std::size_t cell = at.grid.index(k, r, c);
      if (at.transfer.moments(cell).at.n == 0) return;
      for (const int a : {0, 1, 2}) {
        const Real exact = affine_motion(at.middle(k, r, c, a))[a];
        wrong = std::max(wrong, std::abs(at.transfer.displacement(static_cast<std::size_t>(a), cell) - exact));
        ++faces;
      }
    });
    EXPECT_LT(largest(wrong), 1e-8) << "of 0.05 m";
    EXPECT_GT(sum_over_ranks(world, GlobalId{faces}), 500);
  }
}

/// How fast particles move along an axis, and the faces beside them; and how far these are from `motion`.
struct FacesMove {
  FacesMove(Water& water, const Field& motion) {
    for (std::size_t i = 0; i < water.particles.id.size(); ++i)
      fastest = std::max(fastest, (water.particles.predicted[i] - water.particles.position[i]).cwiseAbs().maxCoeff());
    Stages stages(water, s);
    stages.gather();
    stages.for_each_cell([&](LocalId k, LocalId r, LocalId c) {
      const std::size_t cell = stages.grid.index(k, r, c);
      if (stages.transfer.moments(cell).at.n == 0) return;
      for (const int a : {0, 1, 2}) {
        const Real moved = stages.transfer.displacement(static_cast<std::size_t>(a), cell);
        most = std::max(most, std::abs(moved));
        wrong = std::max(wrong, std::abs(moved - motion(stages.middle(k, r, c, a))[a]));
      }
    });
    fastest = largest(fastest), most = largest(most), wrong = largest(wrong);
  }
  Real fastest = 0, most = 0, wrong = 0;
};

// Four particles within a third of a cell say little of its faces: continued to these their motion was 3.3 times as
// fast as any of them, and the cell threw them out at its top. So do four that meet, however far apart. A motion that
// keeps volumes, or swells, of particles within two thirds of a cell is continued, and so is any one of full water.
// Cells are not cubes.
TEST(ParticlesToGrid, FewParticlesSayLittleOfFacesFarAway) {
  const Box long_box{box.min, box.max + Vec3(0.1, 0, 0.1)};
  const Vec3 middle = box.min + Vec3(5.5 * 2.5 / 12, 2.5 * 0.2, 2.5 * 0.21);
  const auto few = [&](const Vec3& p) { return (p - middle).cwiseAbs().maxCoeff() < s && p.z() < middle.z(); };
  Eigen::Matrix3d meeting = Eigen::Vector3d(-0.3, -0.3, 0).asDiagonal(), keeping;
  keeping << -0.3, 0.1, -0.2, 0.3, 0.1, 0.2, 0.05, -0.1, 0.2;
  const Eigen::Matrix3d swelling = -meeting;
  for (const auto& [slope, reach] :
       {std::pair{meeting, 0.15}, {keeping, 0.15}, {swelling, 0.15}, {meeting, 0.3}, {keeping, 0.3}, {swelling, 0.3}}) {
    const auto motion = [&](const Vec3& p) { return Vec3(slope * (p - middle)); };
    Water four(motion, {.box = long_box, .holds = few});
    EXPECT_EQ(sum_over_ranks(world, four.particles.size()), 4);
    for (std::size_t i = 0; i < four.particles.id.size(); ++i) {
      const Vec3 side = ((four.particles.position[i] + four.particles.predicted[i]) / 2 - middle).cwiseSign();
      const Vec3 at = middle + reach * h * Vec3(side.x(), side.y(), side.x() * side.y());
      four.particles.position[i] = at - motion(at) / 2;
      four.particles.predicted[i] = at + motion(at) / 2;
    }
    migrate(world, four.particles, &Particles::predicted, four.grid, four.slabs);
    four.sort();
    const FacesMove of_few(four, motion);
    std::printf("within %g of a cell: faces move %.2f times as fast\n", 2 * reach, of_few.most / of_few.fastest);
    if (slope == meeting) {
      EXPECT_LT(of_few.most, 2 * of_few.fastest);
    } else if (reach < 0.2) {
      EXPECT_LT(of_few.most, 3 * of_few.fastest);
    } else {
      EXPECT_LT(of_few.wrong, 2e-4 * of_few.most);
    }
    EXPECT_GT(of_few.most, reach < 0.2 ? of_few.fastest : 0.8 * of_few.fastest);
    const auto slow = [&](const Vec3& p) { return Vec3(motion(p) / 10); };
    Water full(slow, {.jitter = 0.2, .box = long_box});
    const FacesMove of_full(full, slow);
    EXPECT_LT(of_full.wrong, 1e-7);
    EXPECT_GT(of_full.most, 0.01);
  }
}

Real longest(const std::vector<Vec4<double>>& all) {
  Real most = 0;
  for (const auto& one : all) most = std::max(most, vector_of(one).norm());
  return largest(most);
}

// Half-filled rows of cells, and lattices that lie anyhow: whatever the fill, there is no pressure. Nor where a layer
// lies a fortieth of a spacing from a face and goes towards it, but not as far: the cell beyond is told much by it, and
// holds no particle. Nor in a corner that is left out, told by two sides.
TEST(Projection, WaterThatFliesIsLeftAlone) {
  struct Flight {
    Vec3 offset, path{0.03, -0.02, 0.05}, off_walls{0.45, 0.45, 0.45};
    bool corner = false;
  };
  for (const Flight& flight :
       {Flight{Vec3(0, 0, 0.5)}, Flight{Vec3(0.037, 0.051, 0.513)},
        Flight{Vec3(0, 0.0485, 0.513), Vec3(0.01, 0.002, 0.01), Vec3(0.45, 0.35, 0.45)},
        Flight{Vec3(0.005, 0.022, 0.53), Vec3(0.042, -0.022, 0.007), Vec3(0.48, 0.28, 0.45), true}}) {
    const auto holds = [&](const Vec3& p) {
      const Vec3 low = p - box.min, high = box.max - p;
      if (flight.corner && low.x() > 1.05 && low.y() > 0.6) return false;
      return (low.cwiseMin(high).array() > flight.off_walls.array()).all();
    };
    Water water([&](const Vec3&) { return flight.path; }, {.top = 1.6, .offset = flight.offset, .holds = holds});
    EXPECT_GT(sum_over_ranks(world, GlobalId{water.particles.size()}), 100);
    for (const Real gravity : {9.8, 0.0})
      EXPECT_LT(longest(displacements(water, s, gravity)), 1e-12) << gravity << ", " << flight.path.y();
  }
}

// What gravity would move is held: water at rest up to the ceiling, and below a surface.
TEST(Projection, StillWaterIsHeldExactly) {
  constexpr Real g_dt2 = 9.8 / 3600;
  for (const Real top : {box.max.z(), 1.5}) {
    Water water([](const Vec3&) { return Vec3(0, 0, -g_dt2); }, {.top = top, .at = 0});
    Real wrong = 0;
    for (const auto& one : displacements(water, s, 9.8))
      wrong = std::max(wrong, (vector_of(one) - Vec3(0, 0, g_dt2)).norm());
    EXPECT_LT(largest(wrong), 1e-12);
  }
}

// What the damping of a substep gives to all particles.
struct Damped {
  std::array<Real, 6> impulse_and_torque{};
  Real size = 0, energy_lost = 0;

  void add(const Vec3& x, const Vec3& p, const Vec3& u) {
    const Vec3 path = p - x, torque = ((p + x) / 2).cross(u);
    for (const int a : {0, 1, 2}) {
      impulse_and_torque[static_cast<std::size_t>(a)] += u[a];
      impulse_and_torque[static_cast<std::size_t>(a + 3)] += torque[a];
    }
    size += u.norm();
    energy_lost -= path.dot(u) + u.squaredNorm() / 2;
  }
  void sum() {
    for (Real* one : {&impulse_and_torque[0], &impulse_and_torque[1], &impulse_and_torque[2], &impulse_and_torque[3],
                      &impulse_and_torque[4], &impulse_and_torque[5], &size, &energy_lost})
      MPI_Allreduce(MPI_IN_PLACE, one, 1, MPI_DOUBLE, MPI_SUM, world);
  }
};

// The displacements without those of the pressure.
Damped damped(const Field& motion) {
  Water water(motion, {.jitter = 0.2});
  Stages at(water, s);
  at.classify();
  at.back->prepare(water.near.halo(), {1, 0.1});
  at.solve(0);
  at.back->find_mean_rises(at.pressure);
  GridToParticles::Damping damping;
  Damped sums;
  at.for_each_cell([&](LocalId k, LocalId r, LocalId c) {
    if (c == 0) at.back->find_damping(damping, k, r);
    const CellParticles cell = at.transfer.particles_of(water.near.order(), k, r, c);
    if (cell.begin == cell.end) return;
    CellDisplacement by = at.back->displacement_of(at.pressure, damping, k, r, c);
    by.low = by.rise = {};
    const CellDisplacement by_faces = at.back->displacement_by_faces(at.pressure, k, r, c);
    for (std::size_t a = 0; a < 3; ++a) {
      by.offset[a] -= by_faces.offset[a];
      for (std::size_t b = 0; b < 3; ++b) by.slope[a][b] -= by_faces.slope[a][b];
    }
    by.fade = 0;
    by.at_surface = 1;
    std::vector<Vec4<double>> out(cell.end - cell.begin);
    displace_cell(at.transfer.frame(), water.motion(), cell, by, out.data());
    for (std::size_t i = cell.begin; i < cell.end; ++i)
      sums.add(water.particles.position[i], water.particles.predicted[i], vector_of(out[i - cell.begin]));
  });
  sums.sum();
  return sums;
}

// Noise is damped without a net impulse or torque; affine motion without noise is not damped at all.
TEST(GridToParticles, DampingKeepsMomenta) {
  std::mt19937_64 random(11);
  std::uniform_real_distribution<Real> number(-1, 1);
  const Damped noise =
      damped([&](const Vec3&) { return Vec3(1e-3 * Vec3(number(random), number(random), number(random))); });
  for (const Real one : noise.impulse_and_torque) EXPECT_LT(std::abs(one), 2e-2 * noise.size);
  EXPECT_GT(noise.energy_lost, 0) << "noise loses energy";
  const Damped affine = damped([](const Vec3& p) { return Vec3(0.05 * affine_motion(p)); });
  EXPECT_LT(affine.size, 1e-5 * noise.size);
}

// Largest difference of what particles are displaced by from `exact` of where their paths begin, m; by(low, at) has the
// displacements of the cell `at` with the lower corner `low`.
template <class By, class Exact>
Real worst_displacement(Water& water, Stages& at, const By& by, const Exact& exact) {
  Real wrong = 0;
  int particles = 0;
  at.gather();
  at.for_each_cell([&](LocalId k, LocalId r, LocalId c) {
    const CellParticles cell = at.transfer.particles_of(water.near.order(), k, r, c);
    if (cell.begin == cell.end) return;
    std::vector<Vec4<double>> out(cell.end - cell.begin);
    const Vec3 low = at.middle(k, r, c) - at.grid.size() / 2;
    displace_cell(at.transfer.frame(), water.motion(), cell, by(low, at.grid.index(k, r, c)), out.data());
    for (std::size_t i = cell.begin; i < cell.end; ++i, ++particles)
      wrong = std::max(wrong, (vector_of(out[i - cell.begin]) - exact(water.particles.position[i])).norm());
  });
  EXPECT_GT(sum_over_ranks(world, GlobalId{particles}), 500);
  return largest(wrong);
}

// Displacements start + slope · p, by faces.
CellDisplacement linear(const Vec3& start, const Vec3& slope, const Vec3& low, const Vec3& size) {
  CellDisplacement by;
  for (const int a : {0, 1, 2}) {
    by.low[static_cast<std::size_t>(a)] = start[a] + slope[a] * low[a];
    by.rise[static_cast<std::size_t>(a)] = slope[a] * size[a];
  }
  return by;
}

// What a particle is displaced by is linear between the faces of its cell, so a linear field passes exactly: phi that
// is a parabola along each axis, whose displacements of the faces are those of its gradient.
TEST(GridToParticles, ALinearDisplacementIsExact) {
  Water water([](const Vec3&) { return Vec3(Vec3::Zero()); }, {.top = box.max.z(), .jitter = 0.2, .at = 0});
  Stages at(water, s);
  const Vec3 slope(0.02, -0.05, 0.03), start(0.004, -0.002, 0.001);
  const Real wrong = worst_displacement(
      water, at, [&](const Vec3& low, std::size_t) { return linear(start, slope, low, at.grid.size()); },
      [&](const Vec3& p) { return Vec3(start + slope.cwiseProduct(p)); });
  EXPECT_LT(wrong, 1e-12);
}

// Water that turns about an axis, and moves on with it: each particle is drawn to where the axis is when its path
// begins, however fast the water moves on, so without a torque. What the middle of a cell bears stays as it is.
TEST(GridToParticles, WaterThatTurnsIsDrawnToItsAxis) {
  constexpr Real draw = 1e-3;
  Eigen::Matrix3d turning;
  turning << 0, -0.03, 0.01, 0.03, 0, -0.02, -0.01, 0.02, 0;
  const Vec3 axis = box.max / 2, held(0, 0, 2e-3);
  for (const Vec3& moving : {Vec3(0, 0, 0), Vec3(0.03, -0.02, 0.015)}) {
    Water water([&](const Vec3& y) { return Vec3(moving + turning * (y - axis)); }, {.jitter = 0.2});
    Stages at(water, s);
    const auto by_faces = [&](const Vec3& low, std::size_t cell) {
      CellDisplacement by = linear(held + draw * axis, Vec3::Constant(-draw), low, at.grid.size());
      pull_back(at.transfer.fit(cell), at.grid.per_length(), held.z(), by);
      return by;
    };
    const auto exact = [&](const Vec3& p) { return Vec3(held - draw * (p - (axis - moving / 2))); };
    EXPECT_LT(worst_displacement(water, at, by_faces, exact), 1e-9);
  }
}

}  // namespace
}  // namespace trevi::test
