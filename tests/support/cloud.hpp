// What the tests of the solver share: a seeded random cloud in a box whose corner is not the origin, its distribution
// over ranks, a solver that starts from it, and all particles of all ranks sorted by id.
// Collective: solver_of, gathered.
#pragma once

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cstring>
#include <numeric>
#include <random>
#include <string>
#include <vector>

#include "app/build.hpp"
#include "support/tank.hpp"
#include "trevi/session.hpp"

namespace trevi::test {

inline const MPI_Comm world = MPI_COMM_WORLD;

/// Particles of all ranks together, or of one.
struct Cloud {
  std::vector<GlobalId> id;
  std::vector<Vec3> position, velocity;

  void add(GlobalId i, const Vec3& p, const Vec3& v) {
    id.push_back(i);
    position.push_back(p);
    velocity.push_back(v);
  }
};

/// Uniform in the box but not nearer than `apart` to one another; velocities up to `speed` along each axis; every 20th
/// particle is ten times as fast, so that it crosses several slabs or bounces more than once. Ids are neither dense nor
/// in order.
inline Cloud random_cloud(int count, const Box& box, Real speed, Real apart = 0) {
  std::mt19937_64 random(5);
  std::uniform_real_distribution<Real> number(0, 1);
  const auto vector = [&] { return Vec3(number(random), number(random), number(random)); };
  Cloud cloud;
  for (GlobalId k = 0; k < count;) {
    const Vec3 p = box.min + vector().cwiseProduct(box.max - box.min);
    const Vec3 v = (k % 20 == 0 ? 10 : 1) * speed * (2 * vector() - Vec3::Ones());
    if (apart > 0 && std::any_of(cloud.position.begin(), cloud.position.end(),
                                 [&](const Vec3& q) { return (p - q).norm() < apart; }))
      continue;
    cloud.add(3 * ((7919 * k++) % 10007) + 1, p, v);
  }
  return cloud;
}

/// Seven planes along x, five along y, with everything explicit that an absent key would leave to the defaults.
inline const std::string cloud_scene =
    tank_with_gravity({.min = "-0.3, 0.2, 0.1",
                       .max = "1.2, 1.25, 1.0",
                       .water = {{"0.0, 0.3, 0.1", "0.2, 0.5, 0.3"}},
                       .dt = "0.0166666667",
                       .end = "1.0",
                       .fluid = "rest_density = 1000.0\nkernel_radius = 0.2\nmass = 'calibrated'",
                       .time = "cfl = 0.0"}) +
    R"(acceleration = [0.3, -0.2, -9.8]
[density]
method = "jacobi"
iterations = 4
coarse_grid = false
max_shift = 0.0
relaxation = 0.3
epsilon = 1.0
constraint = "equality"
precision = "double"
[walls]
restitution = 0.5
density = "none"
reflection = "normal"
[random]
seed = 9
)";

/// Obstacles: a cylinder along x, 0.3 m wide, and a ball that turns.
inline std::string rod_and_ball(const std::string& rod, Real length, const std::string& ball, Real radius) {
  return fmt::format(
      "[[obstacle]]\ntype = 'cylinder'\ncenter = [{}]\naxis = [1, 0, 0]\nradius = 0.15\nheight = {}\n"
      "[[obstacle]]\ntype = 'sphere'\ncenter = [{}]\nradius = {}\nangular_velocity = [0, 5, 0]\n",
      rod, length, ball, radius);
}

inline Scene scene_with(const std::string& text, const std::vector<std::string>& overrides) {
  return parse_scene("cloud.toml", text, overrides);
}

inline Box box_of(const Scene& scene) { return scene.domain; }

/// Rows [first, last) of rank `rank` among `size`, as even as they can be.
inline Cloud slice_of(const Cloud& all, int rank, int size) {
  const std::size_t n = all.id.size(), r = static_cast<std::size_t>(rank), ranks = static_cast<std::size_t>(size);
  Cloud slice;
  for (std::size_t k = n * r / ranks; k < n * (r + 1) / ranks; ++k)
    slice.add(all.id[k], all.position[k], all.velocity[k]);
  return slice;
}

/// A solver of the scene whose particles are those of the cloud.
inline std::unique_ptr<Solver> solver_of(MPI_Comm comm, const Scene& scene, const Cloud& all,
                                         SolverExtras extras = {}) {
  Cloud mine = slice_of(all, rank_of(comm), size_of(comm));
  Particles particles;
  particles.id = std::move(mine.id);
  particles.position = std::move(mine.position);
  particles.velocity = std::move(mine.velocity);
  return make_solver(comm, scene, std::move(particles), std::move(extras));
}

/// One as the program makes it, started, without a line of progress.
inline std::unique_ptr<Solver> started(const Scene& scene) {
  BuildOptions options;
  options.progress = ProgressMode::none;
  std::unique_ptr<Solver> solver = build_solver(world, scene, std::move(options));
  solver->start();
  return solver;
}

inline Cloud sorted_by_id(const Cloud& cloud) {
  std::vector<std::size_t> order(cloud.id.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) { return cloud.id[a] < cloud.id[b]; });
  Cloud sorted;
  for (const std::size_t k : order) sorted.add(cloud.id[k], cloud.position[k], cloud.velocity[k]);
  return sorted;
}

/// The rows of all ranks, in rank order.
template <class T>
std::vector<T> gathered(MPI_Comm comm, const std::vector<T>& mine) {
  const int bytes = static_cast<int>(mine.size() * sizeof(T));
  std::vector<int> counts(static_cast<std::size_t>(size_of(comm))), offsets(counts.size(), 0);
  MPI_Allgather(&bytes, 1, MPI_INT, counts.data(), 1, MPI_INT, comm);
  std::exclusive_scan(counts.begin(), counts.end(), offsets.begin(), 0);
  std::vector<T> all(static_cast<std::size_t>(offsets.back() + counts.back()) / sizeof(T));
  MPI_Allgatherv(mine.data(), bytes, MPI_BYTE, all.data(), counts.data(), offsets.data(), MPI_BYTE, comm);
  return all;
}

/// All particles of all ranks, sorted by id.
inline Cloud gathered(MPI_Comm comm, const Particles& particles) {
  return sorted_by_id(
      {gathered(comm, particles.id), gathered(comm, particles.position), gathered(comm, particles.velocity)});
}

inline bool same_bits(const std::vector<Vec3>& a, const std::vector<Vec3>& b) {
  return a.size() == b.size() && std::memcmp(a.data(), b.data(), a.size() * sizeof(Vec3)) == 0;
}

inline void expect_same_bits(const Cloud& many, const Cloud& one) {
  EXPECT_EQ(many.id, one.id);
  EXPECT_TRUE(same_bits(many.position, one.position));
  EXPECT_TRUE(same_bits(many.velocity, one.velocity));
}

}  // namespace trevi::test
