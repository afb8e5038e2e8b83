// A cloud spread over the ranks with its neighbourhood rebuilt, and the ids of ghosts, for the tests below the solver.
// Positions, kernels and lists can then be compared with brute force over the whole cloud, which every rank knows.
// Collective.
#pragma once

#include <cmath>

#include "domain/migrate.hpp"
#include "domain/neighbourhood.hpp"
#include "support/cloud.hpp"

namespace trevi::test {

inline constexpr Real radius = 0.2;
inline const Box cloud_box{Vec3(-0.3, 0.2, 0.1), Vec3(1.2, 1.25, 1.0)};

inline CellGrid cloud_grid(int slab_axis = 0) { return {cloud_box.min, cloud_box.max, radius, slab_axis}; }

/// Numbers of ranks that may share a slab, with at least a row of `grid` each.
inline std::vector<int> parts_of_slabs(const CellGrid& grid) {
  std::vector<int> parts;
  for (int k = 1; k <= std::min<int>(size_of(world), grid.rows()); ++k)
    if (size_of(world) % k == 0 && size_of(world) / k <= grid.planes()) parts.push_back(k);
  return parts;
}

/// Cuts the slabs inside by the weights of their rows, slab by slab, which all ranks know.
inline void cut_rows_alone(Slabs& slabs, std::span<const Real> weights, int parts) {
  const std::size_t rows = weights.size() / static_cast<std::size_t>(slabs.slabs());
  std::vector<LocalId> cuts;
  for (std::size_t k = 0; k < weights.size(); k += rows) {
    const std::vector<LocalId> of_slab = even_cuts(weights.subspan(k, rows), parts);
    cuts.insert(cuts.end(), of_slab.begin(), of_slab.end());
  }
  slabs.set_rows(std::move(cuts), parts);
}

/// The same number of planes for each slab, however the particles are spread; each cut into parts elsewhere.
inline Slabs even_slabs(const CellGrid& grid, int parts = 1) {
  Slabs slabs(std::vector<Real>(static_cast<std::size_t>(grid.planes()), 1.0), size_of(world) / parts);
  if (parts == 1) return slabs;
  std::vector<Real> weights;
  for (int slab = 0; slab < slabs.slabs(); ++slab)
    for (LocalId row = 0; row < grid.rows(); ++row) weights.push_back((slab + row) % 3 + 1);
  cut_rows_alone(slabs, weights, parts);
  return slabs;
}

/// This rank's slice, not yet where it belongs; predicted = position.
inline Particles particles_of(const Cloud& all) {
  const Cloud mine = slice_of(all, rank_of(world), size_of(world));
  Particles particles;
  particles.id = mine.id;
  particles.position = particles.predicted = mine.position;
  particles.velocity = mine.velocity;
  return particles;
}

template <class T>
struct Distributed {
  explicit Distributed(const Cloud& all, int slab_axis = 0, int parts = 1)
      : grid(cloud_grid(slab_axis)), slabs(even_slabs(grid, parts)), near(world, grid, cloud_box.min, radius) {
    rebuild(all);
  }

  void rebuild(const Cloud& all) {
    particles = particles_of(all);
    migrate(world, particles, &Particles::predicted, grid, slabs);
    near.rebuild(particles, slabs);
    id = with_ghosts(particles.id);
  }

  /// A field of the owned particles, extended by the ghosts'.
  template <class Value>
  std::vector<Value> with_ghosts(const std::vector<Value>& owned) {
    std::vector<Value> field(static_cast<std::size_t>(near.order().size()));
    std::copy(owned.begin(), owned.end(), field.begin() + near.order().low_ghosts());
    near.halo().exchange(field);
    return field;
  }

  CellGrid grid;
  Slabs slabs;
  Particles particles;
  Neighbourhood<T> near;
  std::vector<GlobalId> id;  ///< of all particles, ghosts included
};

/// Clouds that are as unlike as those of a run: spread out, all in one corner, none, and one alone.
inline std::vector<std::pair<std::string, Cloud>> clouds() {
  const Box corner{cloud_box.max - Vec3(0.15, 0.3, 0.3), cloud_box.max};
  return {{"spread", random_cloud(800, cloud_box, 1)},
          {"corner", random_cloud(300, corner, 1)},
          {"empty", Cloud{}},
          {"alone", random_cloud(1, cloud_box, 1)}};
}

}  // namespace trevi::test
