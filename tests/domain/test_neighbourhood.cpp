// Who is near whom, on any number of ranks, ranks without particles included: neighbours equal brute force, a ghost is
// its owner's record, migration conserves every particle.
#include <map>
#include <set>

#include "base/simd.hpp"
#include "parallel/reductions.hpp"
#include "support/distributed.hpp"

namespace trevi::test {
namespace {

template <class T>
class NeighbourhoodOf : public testing::Test {};
using Precisions = testing::Types<float, double>;
TYPED_TEST_SUITE(NeighbourhoodOf, Precisions);

std::map<GlobalId, Vec3> places_by_id(const Cloud& all) {
  std::map<GlobalId, Vec3> places;
  for (std::size_t k = 0; k < all.id.size(); ++k) places[all.id[k]] = all.position[k];
  return places;
}

/// Pairs nearer to the cutoff than this, in units of h, may be found or not.
template <class T>
constexpr Real doubt = std::is_same_v<T, float> ? 1e-5 : 1e-14;

template <class T>
void expect_brute_force(const Distributed<T>& d, const Cloud& all) {
  std::map<GlobalId, Vec3> places = places_by_id(all);
  const auto owned_ids = d.id.begin() + d.near.order().low_ghosts();
  for (LocalId i = 0; i < d.near.list().size(); ++i) {
    const GlobalId self = owned_ids[i];
    const auto row = d.near.list()[i];
    const bool in_order = d.near.order().rows_are_cut() || std::is_sorted(row.begin(), row.end());
    EXPECT_TRUE(in_order) << "not in storage order";
    std::set<GlobalId> found;
    for (const LocalId j : row) EXPECT_TRUE(found.insert(d.id[static_cast<std::size_t>(j)]).second) << "twice";
    EXPECT_FALSE(found.contains(self));
    for (const auto& [id, place] : places) {
      const Real u = (place - places[self]).norm() / radius;
      if (id == self || std::abs(u - 1) < doubt<T>) continue;
      EXPECT_EQ(found.contains(id), u < 1) << "particles " << self << " and " << id << " at " << u << " h";
    }
  }
}

TYPED_TEST(NeighbourhoodOf, NeighboursEqualBruteForce) {
  for (const auto& [name, cloud] : clouds()) {
    for (const int axis : {0, 1}) {
      for (const int parts : parts_of_slabs(cloud_grid(axis))) {
        SCOPED_TRACE(name + ", slab axis " + std::to_string(axis) + ", parts " + std::to_string(parts));
        const Distributed<TypeParam> d(cloud, axis, parts);
        EXPECT_EQ(sum_over_ranks(world, d.near.list().size()), static_cast<GlobalId>(cloud.id.size()));
        expect_brute_force(d, cloud);
      }
    }
  }
}

TYPED_TEST(NeighbourhoodOf, NeighboursAreTheSameWithEveryInstructionSet) {
  const std::int64_t all = supported_instruction_sets();
  const Cloud cloud = random_cloud(500, cloud_box, 1);
  for (std::int64_t rest = all; rest != 0; rest &= rest - 1) {  // the lowest bit, one after the other
    restrict_instruction_sets(rest & -rest);
    SCOPED_TRACE(instruction_set_name());
    const Distributed<TypeParam> d(cloud);
    expect_brute_force(d, cloud);
  }
  restrict_instruction_sets(all);
}

// Within a cell by id, so that the order does not depend on who sent a particle.
TYPED_TEST(NeighbourhoodOf, ParticlesAreInCellOrder) {
  const Distributed<TypeParam> d(random_cloud(800, cloud_box, 1), 0, parts_of_slabs(cloud_grid()).back());
  const auto key = [&](std::size_t k) {
    const Vec3& p = d.particles.predicted[k];
    return std::tuple(d.grid.plane_of(p), d.grid.cell_in_plane(p), d.particles.id[k]);
  };
  for (std::size_t k = 1; k < d.particles.id.size(); ++k) EXPECT_LT(key(k - 1), key(k));
}

TYPED_TEST(NeighbourhoodOf, HaloRoundTrip) {
  const Encoding<TypeParam> encoding(cloud_box.min, radius);
  for (const auto& [name, cloud] : clouds()) {
    SCOPED_TRACE(name);
    Distributed<TypeParam> d(cloud, 0, parts_of_slabs(cloud_grid()).back());
    std::map<GlobalId, Vec3> places = places_by_id(cloud);
    const LocalId first = d.near.order().low_ghosts();
    for (const int round : {1, 2}) {  // the plan serves any number of exchanges
      for (LocalId i = 0; i < d.near.order().owned(); ++i)
        d.near.record(i).w = static_cast<TypeParam>(round * (d.particles.id[static_cast<std::size_t>(i)] % 1000));
      d.near.halo().exchange(d.near.records());
      for (std::size_t k = 0; k < d.id.size(); ++k) {
        const Packed<TypeParam>& found = d.near.records()[k];
        const auto owner = encoding(places[d.id[k]], static_cast<TypeParam>(round * (d.id[k] % 1000)));
        EXPECT_TRUE(found.x == owner.x && found.y == owner.y && found.z == owner.z && found.w == owner.w)
            << "record " << k << " of " << d.id.size() << ", owned from " << first;
      }
    }
  }
}

/// Ghosts are exactly the particles of the planes and rows next to the own ones.
TYPED_TEST(NeighbourhoodOf, GhostsAreThoseAroundTheWindow) {
  const Cloud cloud = random_cloud(800, cloud_box, 1);
  for (const int parts : parts_of_slabs(cloud_grid())) {
    SCOPED_TRACE(parts);
    const Distributed<TypeParam> d(cloud, 0, parts);
    const CellWindow own = d.slabs.window(rank_of(world), d.grid.rows());
    const auto is_around = [](LocalId k, const Range& range) { return k >= range.begin - 1 && k <= range.end; };
    std::multiset<GlobalId> expected, found(d.id.begin(), d.id.end());
    for (std::size_t k = 0; k < cloud.id.size(); ++k) {
      const Vec3& p = cloud.position[k];
      if (is_around(d.grid.plane_of(p), own.planes) && is_around(d.grid.row_of(p), own.rows))
        expected.insert(cloud.id[k]);
    }
    EXPECT_EQ(found, expected);
  }
}

/// The list of particles that one rank alone has.
template <class T>
std::unique_ptr<NeighbourList> list_of(const CellGrid& grid, const std::vector<Vec3>& places) {
  Particles particles;
  particles.predicted = places;
  particles.resize(places.size());
  std::iota(particles.id.begin(), particles.id.end(), GlobalId{0});
  CellOrder order(grid);
  order.sort(particles, {{0, grid.planes()}, {0, grid.rows()}}, Velocities::discard);
  order.add_ghosts({});
  const Encoding<T> encoding(Vec3::Zero(), radius);
  std::vector<Packed<T>> records;
  for (const Vec3& p : particles.predicted) records.push_back(encoding(p, T{0}));
  auto list = std::make_unique<NeighbourList>();
  list->rebuild(order, records);
  return list;
}

// Nine lines of particles along z. Around cells of the line in the middle they lie in more windows than a code tells
// apart, and indices stand in its place; around the others they do not.
TYPED_TEST(NeighbourhoodOf, RowsOfManyWindowsHaveTheirNeighbours) {
  const CellGrid grid(Vec3::Zero(), Vec3(0.6, 0.6, 40), radius, 0);
  constexpr LocalId count = 8160, reach = 40;
  constexpr Real apart = 0.0049;  // 40.8 times within h
  std::vector<Vec3> places;
  for (const Real x : {0.09, 0.3, 0.51}) {
    for (const Real y : {0.09, 0.3, 0.51})
      for (LocalId k = 0; k < count; ++k) places.emplace_back(x, y, apart * (k + 0.5));
  }
  const auto list = list_of<TypeParam>(grid, places);
  for (const LocalId line : {0, 1, 4, 8}) {
    const LocalId i = line * count + count / 2;
    EXPECT_EQ(list->row(i).coded == nullptr, line == 4);
    std::vector<LocalId> expected(2 * reach + 1);
    std::iota(expected.begin(), expected.end(), i - reach);
    expected.erase(expected.begin() + reach);
    EXPECT_EQ((*list)[i], expected);
  }
  EXPECT_EQ(list->pairs(), 9 * (GlobalId{2} * reach * count - GlobalId{reach} * (reach + 1)));
}

TYPED_TEST(NeighbourhoodOf, CrowdIsFoundBeforeItTakesMemory) {
  const CellGrid grid(Vec3::Zero(), Vec3::Ones(), radius, 0);
  const auto list = list_of<TypeParam>(grid, std::vector<Vec3>(6000, Vec3::Constant(0.1)));
  EXPECT_EQ(list->first_overfull_particle(), 0);
  EXPECT_LT(list->borrowed_bytes(), 200 * static_cast<std::size_t>(list->size()))
      << "rows of the whole cell would be 4 * 6000 a particle";
}

// Coordinates of single precision wrap around 512 h from the corner, here inside a cell.
TYPED_TEST(NeighbourhoodOf, CellsAcross512RadiiHaveTheirNeighbours) {
  const CellGrid grid(Vec3::Zero(), Vec3(110.1, 0.6, 0.6), radius, 0);
  const Real border = 512 * radius;
  ASSERT_EQ(grid.plane_of(Vec3(border - 0.05, 0, 0)), grid.plane_of(Vec3(border + 0.05, 0, 0)));
  std::vector<Vec3> places;
  places.reserve(20);
  for (int n = 0; n < 20; ++n) places.emplace_back(border - 0.29 + 0.03 * n, 0.3, 0.3);
  const auto list = list_of<TypeParam>(grid, places);  // within a cell by id, thus along x
  for (int i = 0; i < 20; ++i) EXPECT_EQ(list->count(i), std::min(i, 6) + std::min(19 - i, 6)) << "particle " << i;
}

/// Moves the predicted places of all particles by a function of their id, migrates, and looks for each particle.
template <class Move>
void expect_migration_conserves(const Cloud& all, Move&& move, int parts) {
  const CellGrid grid = cloud_grid();
  const Slabs slabs = even_slabs(grid, parts);
  Particles particles = particles_of(all);
  for (std::size_t k = 0; k < particles.id.size(); ++k)
    particles.predicted[k] = move(particles.id[k], particles.position[k]);
  migrate(world, particles, &Particles::predicted, grid, slabs);
  for (std::size_t k = 0; k < particles.id.size(); ++k) {
    EXPECT_EQ(slabs.owner(grid, particles.predicted[k]), rank_of(world));
    EXPECT_EQ(particles.predicted[k], move(particles.id[k], particles.position[k]));
  }
  const Cloud found = gathered(world, particles), expected = sorted_by_id(all);
  EXPECT_EQ(found.id, expected.id);
  EXPECT_EQ(found.position, expected.position);
  EXPECT_EQ(found.velocity, expected.velocity);
}

TEST(Migrate, ConservesParticlesOverAnyDistance) {
  const auto stay = [](GlobalId, const Vec3& p) { return p; };
  const auto mirror = [](GlobalId, const Vec3& p) { return Vec3(0.9 - p.x(), p.y(), p.z()); };
  const auto a_little = [](GlobalId id, const Vec3& p) {
    const Vec3 moved = p + 0.15 * Vec3(static_cast<Real>(id % 3) - 1, static_cast<Real>(id / 3 % 3) - 1, 0);
    return Vec3(moved.cwiseMax(cloud_box.min).cwiseMin(cloud_box.max));
  };
  const auto to_one_place = [](GlobalId, const Vec3&) { return Vec3(1.19, 0.5, 0.5); };
  const auto to_both_ends = [](GlobalId id, const Vec3& p) { return Vec3(id % 2 == 0 ? -0.3 : 1.2, p.y(), p.z()); };
  for (const auto& [name, cloud] : clouds()) {
    for (const int parts : parts_of_slabs(cloud_grid())) {
      SCOPED_TRACE(name + ", parts " + std::to_string(parts));
      expect_migration_conserves(cloud, stay, parts);
      expect_migration_conserves(cloud, mirror, parts);
      expect_migration_conserves(cloud, a_little, parts);
      expect_migration_conserves(cloud, to_one_place, parts);
      expect_migration_conserves(cloud, to_both_ends, parts);
    }
  }
}

TEST(Migrate, FollowsTheFieldThatIsNamedAndKeepsHues) {
  const CellGrid grid = cloud_grid();
  const Slabs slabs = even_slabs(grid);
  Particles particles = particles_of(random_cloud(300, cloud_box, 1));
  particles.has_hue = true;
  for (const GlobalId id : particles.id) particles.hue.push_back(static_cast<float>(id));
  for (Vec3& p : particles.predicted) p = cloud_box.min;
  migrate(world, particles, &Particles::position, grid, slabs);
  for (std::size_t k = 0; k < particles.id.size(); ++k) {
    EXPECT_EQ(slabs.owner(grid, particles.position[k]), rank_of(world));
    EXPECT_EQ(particles.hue[k], static_cast<float>(particles.id[k]));
  }
}

}  // namespace
}  // namespace trevi::test
