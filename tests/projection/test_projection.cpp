// The stages of the projection, each alone: affine motion passes the transfer exactly however particles lie, damping
// and the filter of shifts keep what they should, water that moves as a whole has no pressure, a full box rests, and
// the Poisson equation has the order that it should.
#include <Eigen/Geometry>
#include <cmath>
#include <numbers>
#include <numeric>
#include <random>

#include "domain/migrate.hpp"
#include "domain/neighbourhood.hpp"
#include "parallel/reductions.hpp"
#include "projection/projection.hpp"
#include "support/cloud.hpp"

namespace trevi::test {
namespace {

constexpr Real s = 0.1, h = 2 * s;
const Box box{Vec3(-0.2, 0.1, 0.3), Vec3(2.2, 1.3, 2.3)};

using Field = std::function<Vec3(const Vec3&)>;

Vec3 affine_motion(const Vec3& p) {
  Eigen::Matrix3d slope;
  slope << 0.02, -0.05, 0.01, 0.04, -0.03, 0.02, -0.01, 0.03, 0.01;
  return Vec3(0.011, -0.007, 0.004) + slope * (p - Vec3(0.9, 0.7, 0.8));
}

/// A lattice up to `top`, each coordinate off by up to `jitter` spacings, where particles are after the fraction `at`
/// of their paths.
struct Water {
  Water(const Field& motion, Real top, Real jitter, const Vec3& offset = Vec3::Zero(), Real at = 0.5,
        const Box& all = box)
      : grid(all.min, all.max, h, 0),
        slabs(std::vector<Real>(static_cast<std::size_t>(grid.planes()), 1.0), size_of(world)),
        near(world, grid, all.min, h) {
    std::mt19937_64 random(7);
    std::uniform_real_distribution<Real> off(-jitter * s, jitter * s);
    const Vec3 first = all.min + Vec3::Constant(s / 2) + offset;
    GlobalId id = 0;
    for (Real x = first.x(); x < all.max.x() - 0.3 * s; x += s) {
      for (Real y = first.y(); y < all.max.y() - 0.3 * s; y += s) {
        for (Real z = first.z(); z < top - 0.3 * s; z += s) {
          const Vec3 middle = Vec3(x + off(random), y + off(random), z + off(random));
          const Vec3 u = motion(middle);
          if (id++ % size_of(world) != rank_of(world)) continue;
          particles.id.push_back(id);
          particles.position.push_back(middle - at * u);
          particles.predicted.push_back(middle + (1 - at) * u);
          particles.velocity.push_back(u);
        }
      }
    }
    migrate(world, particles, &Particles::predicted, grid, slabs);
    near.rebuild(particles, {slabs.first_plane(rank_of(world)), slabs.end_plane(rank_of(world))});
  }
  Motion motion() const { return {particles.position, particles.predicted}; }

  CellGrid grid;
  Slabs slabs;
  Particles particles;
  Neighbourhood<double> near;
};

Real largest(Real value) { return max_over_ranks(world, value); }

/// The middle of the first plane of this rank.
Vec3 in_first_plane(const Water& water) {
  return box.min + (water.slabs.first_plane(rank_of(world)) + 0.5) * h * Vec3::UnitX();
}

struct Transferred {
  explicit Transferred(Water& water) : grid(world, water.grid, box), transfer(grid, s) {
    grid.resize(water.near.order().planes(), water.grid.columns());
    grid.set_plane(1, in_first_plane(water));
    transfer.resize();
    transfer.gather(water.near.order(), water.near.halo(), water.motion(), nullptr);
  }
  ProjectionGrid grid;
  ParticlesToGrid transfer;
};

TEST(ParticlesToGrid, AffineMotionIsExactAtFaces) {
  for (const Real jitter : {0.0, 0.4}) {
    Water water(affine_motion, 1.5, jitter, Vec3(0.03, 0.017, 0.041));
    const Transferred at(water);
    const LocalId first = water.slabs.first_plane(rank_of(world));
    Real wrong = 0;
    int faces = 0;
    for (LocalId k = 1; k <= at.grid.planes(); ++k) {
      for (LocalId r = 0; r < at.grid.rows(); ++r) {
        for (LocalId c = 0; c < at.grid.columns(); ++c) {
          const std::size_t cell = at.grid.index(k, r, c);
          if (at.transfer.moments(cell).at.n == 0) continue;
          for (std::size_t a = 0; a < 3; ++a) {
            Vec3 middle = Vec3(first + k - 1 + 0.5, r + 0.5, c + 0.5) - Vec3::Unit(static_cast<Eigen::Index>(a)) / 2;
            const Vec3 place = box.min + middle.cwiseProduct(at.grid.size());
            const Real exact = affine_motion(place)[static_cast<Eigen::Index>(a)];
            wrong = std::max(wrong, std::abs(at.transfer.displacement(a, cell) - exact));
            ++faces;
          }
        }
      }
    }
    EXPECT_LT(largest(wrong), 1e-8) << "of 0.05 m";
    EXPECT_GT(sum_over_ranks(world, GlobalId{faces}), 500);
  }
}

TEST(ParticlesToGrid, VolumeIsThatOfTheParticles) {
  Water water([](const Vec3&) { return Vec3(Vec3::Zero()); }, 1.5, 0.2);
  const Transferred at(water);
  Real volume = 0;
  for (LocalId k = 1; k <= at.grid.planes(); ++k)
    for (LocalId r = 0; r < at.grid.rows(); ++r) {
      std::vector<Real> volumes(static_cast<std::size_t>(at.grid.columns()));
      at.transfer.find_volumes(k, r, volumes);
      volume += std::accumulate(volumes.begin(), volumes.end(), 0.0);
    }
  Real all = 0;
  MPI_Allreduce(&volume, &all, 1, MPI_DOUBLE, MPI_SUM, world);
  const auto particles = static_cast<Real>(sum_over_ranks(world, GlobalId{water.particles.size()}));
  EXPECT_NEAR(all * at.grid.size().prod(), particles * s * s * s, 1e-10);
}

/// What the projection does to the particles in a step of 1/60 s.
std::vector<Vec4<double>> displacements(Water& water, Real gravity) {
  Projection projection(world, water.grid, box, {s, h, gravity});
  std::vector<Vec4<double>> out(static_cast<std::size_t>(water.particles.size()));
  projection.displacements<double>(water.near.order(), water.near.halo(), 1.0 / 60, water.motion(), out);
  return out;
}
Real longest(const std::vector<Vec4<double>>& all) {
  Real most = 0;
  for (const auto& one : all) most = std::max(most, vector_of(one).norm());
  return largest(most);
}

// Half-filled rows of cells, and lattices that lie anyhow: whatever the fill, there is no pressure.
TEST(Projection, WaterThatFliesIsLeftAlone) {
  for (const Vec3& offset : {Vec3(0, 0, 0.5), Vec3(0.037, 0.051, 0.513)}) {
    Water water([](const Vec3&) { return Vec3(0.03, -0.02, 0.05); }, 1.6, 0.0, offset);
    std::vector<std::size_t> keep;
    Particles& all = water.particles;
    for (std::size_t i = 0; i < all.id.size(); ++i)  // off the walls
      if (((all.position[i] - box.min).array() > 0.45).all() && ((box.max - all.position[i]).array() > 0.45).all())
        keep.push_back(i);
    Particles some;
    for (const std::size_t i : keep) {
      some.id.push_back(all.id[i]);
      some.position.push_back(all.position[i]);
      some.predicted.push_back(all.predicted[i]);
      some.velocity.push_back(all.velocity[i]);
    }
    all = some;
    water.near.rebuild(all, {water.slabs.first_plane(rank_of(world)), water.slabs.end_plane(rank_of(world))});
    EXPECT_GT(sum_over_ranks(world, GlobalId{all.size()}), 100);
    for (const Real gravity : {9.8, 0.0}) EXPECT_LT(longest(displacements(water, gravity)), 1e-12) << gravity;
  }
}

// What gravity would move is held: water at rest up to the ceiling, and below a surface.
TEST(Projection, StillWaterIsHeldExactly) {
  constexpr Real g_dt2 = 9.8 / 3600;
  for (const Real top : {box.max.z(), 1.5}) {
    Water water([](const Vec3&) { return Vec3(0, 0, -g_dt2); }, top, 0.0, Vec3::Zero(), 0);
    Real wrong = 0;
    for (const auto& one : displacements(water, 9.8))
      wrong = std::max(wrong, (vector_of(one) - Vec3(0, 0, g_dt2)).norm());
    EXPECT_LT(largest(wrong), 1e-12);
  }
}

// Noise is damped without a net impulse or torque; affine motion without noise is not damped at all.
TEST(GridToParticles, DampingKeepsMomenta) {
  std::mt19937_64 random(11);
  std::uniform_real_distribution<Real> number(-1, 1);
  const auto displaced = [&](const Field& motion) {
    Water water(motion, 1.5, 0.2);
    ProjectionGrid grid(world, water.grid, box);
    ActiveRows rows(world, {2, 3});
    rows.measure(water.near.order(), water.near.halo());
    grid.resize(water.near.order().planes(), water.grid.columns());
    grid.set_plane(1, in_first_plane(water));
    ParticlesToGrid transfer(grid, s);
    FreeSurface surface({grid, rows, transfer, nullptr, true});
    GridToParticles back(surface, s, h);
    Pressure none(world, grid.repeats());
    transfer.resize();
    surface.resize();
    back.resize();
    transfer.gather(water.near.order(), water.near.halo(), water.motion(), nullptr);
    surface.classify(water.near.halo());
    back.prepare(water.near.halo(), {0, 0.1});
    none.solve(surface, water.near.halo(), {0, 0, 1});
    GridToParticles::Damping damping;
    std::array<Real, 8> sums{};  // impulse, torque, size, energy that is taken
    for (LocalId k = 1; k <= grid.planes(); ++k) {
      for (LocalId r = 0; r < grid.rows(); ++r) {
        back.find_damping(damping, k, r);
        for (LocalId c = 0; c < grid.columns(); ++c) {
          const CellParticles cell = transfer.particles_of(water.near.order(), k, r, c);
          if (cell.begin == cell.end) continue;
          CellDisplacement by = back.displacement_of(none, damping, k, r, c);
          by.low = by.rise = {};
          by.fade = 0;
          by.at_surface = 1;
          std::vector<Vec4<double>> out(cell.end - cell.begin);
          displace_cell(transfer.frame(), water.motion(), cell, by, out.data());
          for (std::size_t i = cell.begin; i < cell.end; ++i) {
            const Vec3 &x = water.particles.position[i], &p = water.particles.predicted[i];
            const Vec3 u = vector_of(out[i - cell.begin]), way = p - x, torque = ((p + x) / 2).cross(u);
            for (std::size_t a = 0; a < 3; ++a) {
              sums[a] += u[static_cast<Eigen::Index>(a)];
              sums[3 + a] += torque[static_cast<Eigen::Index>(a)];
            }
            sums[6] += u.norm();
            sums[7] -= way.dot(u) + u.squaredNorm() / 2;
          }
        }
      }
    }
    MPI_Allreduce(MPI_IN_PLACE, sums.data(), 8, MPI_DOUBLE, MPI_SUM, world);
    return sums;
  };
  const auto noise =
      displaced([&](const Vec3&) { return Vec3(1e-3 * Vec3(number(random), number(random), number(random))); });
  for (std::size_t a = 0; a < 6; ++a) EXPECT_LT(std::abs(noise[a]), 2e-2 * noise[6]) << a;
  EXPECT_GT(noise[7], 0) << "noise loses energy";
  const auto affine = displaced([](const Vec3& p) { return Vec3(0.05 * affine_motion(p)); });
  EXPECT_LT(affine[6], 1e-5 * noise[6]);
}

// cos(pi x/L) cos(pi z/H)-like pressure in a closed box: what the operator makes of it converges with the second order.
TEST(Multigrid, PoissonOnAManufacturedSolutionIsOfSecondOrder) {
  Real error[2] = {};
  for (const int level : {0, 1}) {
    const LocalId cells = level == 0 ? 8 : 16;
    const Real size = 1.0 / cells, link = 1 / (size * size);
    Multigrid multigrid(world);
    const LocalId ranks = size_of(world), rank = rank_of(world);
    const LocalId begin = cells * rank / ranks, end = cells * (rank + 1) / ranks;
    multigrid.resize(end - begin, cells, cells, cells);
    MultigridLevel& finest = multigrid.finest();
    const auto middle = [&](LocalId i) { return std::numbers::pi * (i + 0.5) * size; };
    const auto exact = [&](LocalId k, LocalId r,
                           LocalId c) {  // 0 at the top: a surface half a cell above the last cell
      return std::cos(middle(k)) * std::cos(middle(r)) * std::cos(middle(c) / 2);
    };
    Halo halo(world);
    for (LocalId k = 0; k <= end - begin + 1; ++k) {
      for (LocalId r = 0; r < cells; ++r) {
        for (LocalId c = 0; c < cells; ++c) {
          const std::size_t at = finest.shape().index(k, r, c);
          const LocalId plane = begin + k - 1;
          finest.link[0][at] = plane > 0 && plane < cells ? link : 0;
          finest.link[1][at] = r > 0 && plane >= 0 && plane < cells ? link : 0;
          finest.link[2][at] = c > 0 && plane >= 0 && plane < cells ? link : 0;
          finest.dirichlet[at] = c + 1 == cells ? 2 * link : 0;
          finest.rhs[at] = 2.25 * std::numbers::pi * std::numbers::pi * exact(plane, r, c);
        }
      }
    }
    multigrid.solve(halo, 30);
    Real wrong = 0;
    for (LocalId k = 1; k <= end - begin; ++k)
      for (LocalId r = 0; r < cells; ++r)
        for (LocalId c = 0; c < cells; ++c)
          wrong = std::max(wrong, std::abs(finest.phi[finest.shape().index(k, r, c)] - exact(begin + k - 1, r, c)));
    error[level] = largest(wrong);
  }
  const Real order = std::log2(error[0] / error[1]);
  if (rank_of(world) == 0) std::printf("errors %.2e, %.2e: order %.2f\n", error[0], error[1], order);
  EXPECT_NEAR(order, 2, 0.25);
}

}  // namespace
}  // namespace trevi::test
