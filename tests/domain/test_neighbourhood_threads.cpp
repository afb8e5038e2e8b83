// Sorting and the search for neighbours give the same result with any number of threads, on ranks without particles,
// too, and where water has collapsed into one place.
#include "base/threads.hpp"
#include "support/distributed.hpp"

namespace trevi::test {
namespace {

/// All that a rebuilt neighbourhood says; the same if and only if every member is.
struct Found {
  std::vector<GlobalId> id, ids_with_ghosts;
  std::vector<Vec3> position, velocity;
  std::vector<LocalId> starts;
  std::vector<std::vector<LocalId>> rows;
  LocalId first_overfull_particle = -1;
  bool operator==(const Found&) const = default;
};

template <class T>
Found found_in(const Distributed<T>& d) {
  Found found;
  found.id = d.particles.id;
  found.ids_with_ghosts = d.id;
  found.position = d.particles.position;
  found.velocity = d.particles.velocity;
  const CellOrder& order = d.near.order();
  for (LocalId k = 0; k < order.planes() + 2; ++k) {
    for (LocalId c = 0; c <= d.grid.cells_per_plane(); ++c) found.starts.push_back(order.start(k, c));
  }
  const NeighbourList& list = d.near.list();
  for (LocalId i = 0; i < list.size(); ++i) found.rows.push_back(list[i]);
  found.first_overfull_particle = list.first_overfull_particle();
  return found;
}

/// As a step leaves them: sorted by an earlier neighbourhood, so that pages and arrays have been used before.
template <class T>
Found found_with(int threads, const Cloud& first, const Cloud& then) {
  use_threads(threads);
  Distributed<T> d(first);
  d.rebuild(then);
  return found_in(d);
}

/// Two places on which 4500 particles each lie, in the first and in the last plane, and some water between them.
Cloud two_crowds() {
  Cloud cloud = random_cloud(9990, cloud_box, 1);
  const Vec3 low = cloud_box.min + Vec3::Constant(0.11), high = cloud_box.max - Vec3::Constant(0.11);
  for (std::size_t k = 0; k < 9000; ++k) cloud.position[k] = k % 2 == 0 ? low : high;
  return cloud;
}

template <class T>
class ThreadsOf : public testing::Test {
 protected:
  ~ThreadsOf() override { use_threads(before_); }
  void expect_same(const Cloud& first, const Cloud& then) {
    const Found expected = found_with<T>(1, first, then);
    for (const int threads : {2, 4, 7}) {
      SCOPED_TRACE(std::to_string(threads) + " threads");
      const Found found = found_with<T>(threads, first, then);
      EXPECT_EQ(found.id, expected.id);
      EXPECT_EQ(found.first_overfull_particle, expected.first_overfull_particle);
      EXPECT_TRUE(found.rows == expected.rows);
      EXPECT_TRUE(found == expected);
    }
  }

 private:
  int before_ = thread_count();
};
using Precisions = testing::Types<float, double>;
TYPED_TEST_SUITE(ThreadsOf, Precisions);

TYPED_TEST(ThreadsOf, GiveTheSameNeighbourhood) {
  const Cloud spread = random_cloud(5000, cloud_box, 1);
  for (const auto& [name, cloud] : clouds()) {  // ranks without particles, and a rank without any
    SCOPED_TRACE(name);
    this->expect_same(spread, cloud);
    this->expect_same(cloud, spread);
  }
}

TYPED_TEST(ThreadsOf, FindTheSameCrowd) {
  const Cloud crowds = two_crowds();
  const Found found = found_with<TypeParam>(1, random_cloud(100, cloud_box, 1), crowds);
  const int rank = rank_of(world), last = size_of(world) - 1;
  EXPECT_EQ(found.first_overfull_particle >= 0, rank == 0 || rank == last);
  for (std::size_t i = 0; i < found.rows.size() && found.first_overfull_particle >= 0; ++i) {
    EXPECT_TRUE(found.rows[i].empty() || static_cast<LocalId>(i) < found.first_overfull_particle) << "row " << i;
  }
  this->expect_same(random_cloud(100, cloud_box, 1), crowds);
}

}  // namespace
}  // namespace trevi::test
