// What the benchmarks run on: a cube of water at rest density, a lattice of spacing 1 whose points are jittered and
// whose ids are shuffled (seeded), so that the order within a cell is arbitrary while the cells stay in order. One
// rank.
#pragma once

#include <cmath>
#include <memory>
#include <numeric>
#include <random>

#include "domain/neighbourhood.hpp"
#include "fluid/pairs/pair_sums.hpp"

namespace trevi::bench {

/// Size and list length of a cloud; h in units of the spacing.
struct Case {
  LocalId particles = 0;
  Real h = 2;
  bool operator==(const Case&) const = default;
};

inline LocalId edge_of(const Case& c) { return static_cast<LocalId>(std::lround(std::cbrt(c.particles))); }

inline Particles jittered_lattice(LocalId edge) {
  std::mt19937_64 random(7);
  std::uniform_real_distribution<Real> jitter(-0.2, 0.2), speed(-1, 1);
  const auto n = static_cast<std::size_t>(edge) * static_cast<std::size_t>(edge) * static_cast<std::size_t>(edge);
  Particles particles;
  particles.resize(n);
  std::iota(particles.id.begin(), particles.id.end(), GlobalId{0});
  std::shuffle(particles.id.begin(), particles.id.end(), random);
  for (std::size_t i = 0; i < n; ++i) {
    const auto e = static_cast<std::size_t>(edge);
    const Vec3 point(static_cast<Real>(i / (e * e)), static_cast<Real>(i / e % e), static_cast<Real>(i % e));
    particles.position[i] = point + Vec3(0.5 + jitter(random), 0.5 + jitter(random), 0.5 + jitter(random));
    particles.velocity[i] = Vec3(speed(random), speed(random), speed(random));
  }
  particles.predicted = particles.position;
  return particles;
}

template <class T>
struct Water {
  explicit Water(const Case& size)
      : edge(edge_of(size)),
        grid(Vec3::Zero(), Vec3::Constant(edge), size.h, 0),
        particles(jittered_lattice(edge)),
        near(MPI_COMM_SELF, grid, Vec3::Zero(), size.h) {
    const std::vector<Vec3> velocities = particles.velocity;  // any will do; sorting costs those of the particles
    rebuild();
    for (LocalId i = 0; i < near.order().owned(); ++i) {
      const Vec3& v = velocities[static_cast<std::size_t>(i)];
      near.record(i).w = static_cast<T>(v.x());
      velocity.push_back({static_cast<T>(v.x()), static_cast<T>(v.y()), static_cast<T>(v.z()), T{0}});
    }
  }

  void rebuild() { near.rebuild(particles, {std::vector<Real>(static_cast<std::size_t>(grid.planes()), 1.0), 1}); }
  Pairs<T> pairs() const { return {near.records(), near.list(), near.order().low_ghosts()}; }
  Range all() const { return {0, near.order().owned()}; }

  Real edge;
  CellGrid grid;
  Particles particles;
  Neighbourhood<T> near;
  std::vector<Vec4<T>> velocity;
};

/// Keeps the last water asked for: consecutive benchmarks share it, and memory holds one at a time.
class Waters {
 public:
  template <class T>
  Water<T>& of(const Case& size) {
    auto& kept = std::get<std::unique_ptr<Water<T>>>(kept_);
    if (!kept || !(size_ == size)) {
      std::apply([](auto&... each) { (each.reset(), ...); }, kept_);
      kept = std::make_unique<Water<T>>(size);
      size_ = size;
    }
    return *kept;
  }

 private:
  Case size_;
  std::tuple<std::unique_ptr<Water<float>>, std::unique_ptr<Water<double>>> kept_;
};

}  // namespace trevi::bench
