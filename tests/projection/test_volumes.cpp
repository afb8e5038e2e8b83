// The volumes of water in cells, and the levels of columns: what particles in and around a cell say of it, wherever
// they are and however far a step takes them.
#include <array>
#include <cmath>
#include <cstdio>
#include <numeric>

#include "stages.hpp"

namespace trevi::test {
namespace {

constexpr Real s = 0.1, h = 2 * s;
const Box box = Lattice{}.box;

// Calls visit(k, r, volumes of its cells, in cells) for each row of owned planes.
template <class Visit>
void for_each_row_of_volumes(const Stages& at, const Visit& visit) {
  std::vector<Real> volumes(static_cast<std::size_t>(at.grid.columns()));
  for (LocalId k = 1; k <= at.grid.planes(); ++k)
    for (LocalId r = 0; r < at.grid.rows(); ++r) {
      at.transfer.find_volumes(k, r, volumes);
      visit(k, r, volumes);
    }
}

TEST(ParticlesToGrid, VolumeIsThatOfTheParticles) {
  Water water([](const Vec3&) { return Vec3(Vec3::Zero()); }, {.jitter = 0.2});
  Stages at(water, s);
  at.gather();
  Real volume = 0;
  for_each_row_of_volumes(at, [&](LocalId, LocalId, const std::vector<Real>& volumes) {
    volume += std::accumulate(volumes.begin(), volumes.end(), 0.0);
  });
  Real all = 0;
  MPI_Allreduce(&volume, &all, 1, MPI_DOUBLE, MPI_SUM, world);
  const auto particles = static_cast<Real>(sum_over_ranks(world, GlobalId{water.particles.size()}));
  EXPECT_NEAR(all * at.grid.size().prod(), particles * s * s * s, 1e-10);
}

// Layers that a wave stretches fill all cells alike, wherever they lie in them: 1/(1 + stretch) of each. Spread evenly
// over one spacing they were off by a quarter of the stretch in turn, cells returned to their volume from there, and
// waves gained energy. The first cells that differ are those with the last layer but one.
TEST(ParticlesToGrid, StretchedLayersFillCellsEvenly) {
  constexpr Real stretch = 2e-4;
  for (const Real height : {2.0, 1.9, 1.95, 2.05}) {
    const Box tank{Vec3(-0.2, 0.1, 0.3), Vec3(2.2, 1.3, 0.3 + height)};
    const auto back = [&](const Vec3& p) { return Vec3(0, 0, -stretch * (p.z() - tank.min.z())); };
    Water water(back, {.at = 1, .box = tank});
    Stages at(water, s);
    at.gather();
    Real wrong = 0;
    for_each_row_of_volumes(at, [&](LocalId, LocalId, const std::vector<Real>& volumes) {
      for (LocalId c = 0; (c + 1) * at.grid.size().z() < 1.2 - 1.5 * s; ++c)
        wrong = std::max(wrong, std::abs(volumes[static_cast<std::size_t>(c)] * (1 + stretch) - 1));
    });
    EXPECT_LT(largest(wrong), 1e-5) << height << " m high";
  }
}

// The level changes by what passes the faces: the volume of a plane of cells, of particles that move through them
// anyhow, by what they say of its faces, with weights that fall linearly to nothing a cell away. With other volumes
// water that moves over a floor pulls itself along the cells.
TEST(ParticlesToGrid, VolumesChangeByWhatPassesTheFaces) {
  const auto motion = [](const Vec3& p) { return Vec3(1e-5 * std::sin(9 * p.x() + 7 * p.y() + 5 * p.z()), 0, 0); };
  Water water(motion, {.jitter = 0.3});
  const auto planes = static_cast<std::size_t>(water.grid.planes());
  const auto sum_over_ranks = [](std::vector<Real>& all) {
    MPI_Allreduce(MPI_IN_PLACE, all.data(), static_cast<int>(all.size()), MPI_DOUBLE, MPI_SUM, world);
  };
  const auto volumes = [&](Real path_before) {
    Water moved(motion, {.jitter = 0.3, .at = path_before});
    Stages at(moved, s);
    at.gather();
    std::vector<Real> sums(planes);
    for_each_row_of_volumes(at, [&](LocalId k, LocalId, const std::vector<Real>& of_row) {
      for (const Real volume : of_row)
        sums[static_cast<std::size_t>(moved.slabs.first_plane(rank_of(world)) + k - 1)] += volume;
    });
    sum_over_ranks(sums);
    return sums;
  };
  std::vector<Real> flux(planes + 1);  // through the lower face of each plane, cells
  for (std::size_t i = 0; i < water.particles.position.size(); ++i) {
    const Vec3 u = water.particles.predicted[i] - water.particles.position[i];
    const Real x = (water.particles.position[i] + u / 2 - box.min).x() / h;
    for (std::size_t f = 1; f < planes; ++f) flux[f] += std::max(0.0, 1 - std::abs(x - f)) * u.x() / h / 8;
  }
  sum_over_ranks(flux);
  const std::vector<Real> before = volumes(1), after = volumes(0);
  Real most = 0, wrong = 0;
  for (std::size_t k = 0; k < planes; ++k) {
    most = std::max(most, std::abs(flux[k]));
    wrong = std::max(wrong, std::abs(after[k] - before[k] - (flux[k] - flux[k + 1])));
  }
  std::printf("flux up to %.2e cells, volumes off by %.2e\n", most, wrong);
  EXPECT_LT(wrong, 1e-3 * most);
}

// However far a step takes them, up to a cell, the volumes of particles lie, in the mean, where the particles are in
// the middle of their paths.
TEST(ParticlesToGrid, VolumesOfFastWaterKeepItsMeanPosition) {
  const auto motion = [](const Vec3& p) { return Vec3(0.19 * std::sin(50 * p.x() + 30 * p.z()), 0, 0); };
  Water water(motion, {.jitter = 0.3, .holds = [](const Vec3& p) { return std::abs(p.x() - 1) < 0.6; }});
  Stages at(water, s);
  at.gather(1e-6);
  std::array<Real, 2> sums{};  // of positions along x over those of particles, in cells, and volumes
  for_each_row_of_volumes(at, [&](LocalId k, LocalId r, const std::vector<Real>& of_row) {
    const Real volume = std::accumulate(of_row.begin(), of_row.end(), 0.0);
    sums[0] += volume * (at.middle(k, r, 0).x() - box.min.x()) / h;
    sums[1] += volume;
  });
  for (std::size_t i = 0; i < water.particles.position.size(); ++i) {
    const Vec3 midway = (water.particles.position[i] + water.particles.predicted[i]) / 2;
    sums[0] -= (midway - box.min).x() / h / 8;
    sums[1] -= 1.0 / 8;
  }
  MPI_Allreduce(MPI_IN_PLACE, sums.data(), 2, MPI_DOUBLE, MPI_SUM, world);
  EXPECT_NEAR(sums[0], 0, 1e-10);
  EXPECT_NEAR(sums[1], 0, 1e-10);
}

// Water that has been squeezed together along x, and has risen, since its paths began: volumes are in the middle of
// paths, but levels those of the beginning, of water at rest. Without half of the rise they are 0.1 cells too high.
TEST(FreeSurface, LevelsAreThoseOfTheBeginningsOfPaths) {
  constexpr Real g_dt2 = 0.01;
  const auto levels = [&](Real stretch) {
    const auto motion = [&](const Vec3& p) {
      return Vec3(-stretch * (p.x() - 1), 0, stretch * (p.z() - box.min.z()) - g_dt2);
    };
    Water water(motion, {.at = 0});
    Stages at(water, s);
    at.classify(g_dt2);
    std::vector<Real> found;
    at.for_each_cell([&](LocalId k, LocalId r, LocalId c) {
      const std::size_t cell = at.grid.index(k, r, c);
      if (!at.surface->is_top(cell) || std::abs(at.middle(k, r, c).x() - 1) > 0.7) return;
      found.push_back(c + at.surface->height(cell));
    });
    return found;
  };
  const std::vector<Real> rest = levels(0);
  for (const Real stretch : {-0.04, 0.01, 0.04}) {
    const std::vector<Real> moved = levels(stretch);
    Real wrong = moved.size() == rest.size() ? 0 : INFINITY;
    for (std::size_t i = 0; i < std::min(moved.size(), rest.size()); ++i)
      wrong = std::max(wrong, std::abs(moved[i] - rest[i]));
    EXPECT_LT(largest(wrong), 0.01) << stretch;
  }
}

}  // namespace
}  // namespace trevi::test
