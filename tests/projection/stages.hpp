// The stages of the projection, each to be called alone, for a lattice of particles whose motion is a function of
// place.
#pragma once

#include <functional>
#include <optional>
#include <random>

#include "domain/migrate.hpp"
#include "domain/neighbourhood.hpp"
#include "parallel/reductions.hpp"
#include "projection/grid_to_particles.hpp"
#include "projection/projection.hpp"
#include "support/cloud.hpp"

namespace trevi::test {

using Field = std::function<Vec3(const Vec3&)>;

/// Where there are particles: a lattice of `spacing` up to `top`, each coordinate off by up to `jitter` spacings, in
/// cells of two spacings or a little more; where they are after the fraction `at` of their paths.
struct Lattice {
  Real top = 1.5, jitter = 0;
  Vec3 offset = Vec3::Zero();
  Real at = 0.5;
  Box box{Vec3(-0.2, 0.1, 0.3), Vec3(2.2, 1.3, 2.3)};
  Real spacing = 0.1;
  std::function<bool(const Vec3&)> holds = [](const Vec3&) { return true; };
};

struct Water {
  Water(const Field& motion, const Lattice& lattice)
      : box(lattice.box),
        grid(box.min, box.max, 2 * lattice.spacing, 0),
        slabs(std::vector<Real>(static_cast<std::size_t>(grid.planes()), 1.0), size_of(world)),
        near(world, grid, box.min, 2 * lattice.spacing) {
    fill(motion, lattice);
    migrate(world, particles, &Particles::predicted, grid, slabs);
    sort();
  }
  void sort() { near.rebuild(particles, slabs); }
  Motion motion() const { return {particles.position, particles.predicted}; }

  Box box;
  CellGrid grid;
  Slabs slabs;
  Particles particles;
  Neighbourhood<double> near;

 private:
  void fill(const Field& motion, const Lattice& lattice) {
    const Real s = lattice.spacing;
    std::mt19937_64 random(7);
    std::uniform_real_distribution<Real> off(-lattice.jitter * s, lattice.jitter * s);
    const Vec3 first = box.min + Vec3::Constant(s / 2) + lattice.offset;
    GlobalId id = 0;
    for (Real x = first.x(); x < box.max.x() - 0.3 * s; x += s) {
      for (Real y = first.y(); y < box.max.y() - 0.3 * s; y += s) {
        for (Real z = first.z(); z < lattice.top - 0.3 * s; z += s) {
          const Vec3 middle = Vec3(x + off(random), y + off(random), z + off(random));
          if (!lattice.holds(middle) || id++ % size_of(world) != rank_of(world)) continue;
          const Vec3 u = motion(middle);
          particles.id.push_back(id);
          particles.position.push_back(middle - lattice.at * u);
          particles.predicted.push_back(middle + (1 - lattice.at) * u);
          particles.velocity.push_back(u);
        }
      }
    }
  }
};

/// What Projection has, up to the pressure, without obstacles or among them.
struct Stages {
  Stages(Water& of, Real spacing, Obstacles* obstacles = nullptr)
      : water(of), grid(water.grid, water.box), transfer(grid, spacing) {
    if (obstacles != nullptr) cuts.emplace(*obstacles);
    surface.emplace(FreeSurface::Sources{grid, rows, transfer, cuts ? &*cuts : nullptr, true});
    back.emplace(*surface, transfer.free_spreads(), spacing, 2 * spacing);
    rows.measure(water.near.order(), water.near.halo());
    grid.resize(water.near.order().window(), water.grid.columns());
    if (cuts) cuts->measure(world, grid, water.box, transfer.frame());
    grid.store_rows(water.near.order());
    transfer.borrow();
    surface->borrow();
  }
  /// g_dt2: the part of gravity in the paths, m.
  void gather(Real g_dt2 = 0) {
    transfer.gather(water.near.order(), water.near.halo(), water.motion(), g_dt2, cuts ? &*cuts : nullptr);
  }
  void classify(Real g_dt2 = 0) {
    gather(g_dt2);
    surface->classify(water.near.halo());
    transfer.find_empty_faces(cuts ? &*cuts : nullptr, [&](std::size_t at) { return surface->is_wet(at); });
  }
  void solve(Real g_dt2) {
    transfer.keep_means();
    pressure.assemble(*surface, water.near.halo(), {g_dt2, 0, rows.depth()});
    pressure.begin(water.near.halo());
    pressure.finish(*surface, water.near.halo());
  }

  template <class Visit>
  void for_each_cell(const Visit& visit) const {
    for (LocalId k = 1; k <= grid.planes(); ++k)
      for (LocalId r = 0; r < grid.rows(); ++r)
        for (LocalId c = 0; c < grid.columns(); ++c) visit(k, r, c);
  }
  /// The middle of a cell, and with `face` that of its lower face in this direction; slabs are cut along x.
  Vec3 middle(LocalId k, LocalId r, LocalId c, int face = -1) const {
    Vec3 cells(water.slabs.first_plane(rank_of(world)) + k - 1 + 0.5, r + 0.5, c + 0.5);
    if (face >= 0) cells[face] -= 0.5;
    return water.box.min + cells.cwiseProduct(grid.size());
  }

  Water& water;
  ProjectionGrid grid;
  ActiveRows rows{world, {2, 3}};
  std::optional<CutCells> cuts;
  ParticlesToGrid transfer;
  std::optional<FreeSurface> surface;
  std::optional<GridToParticles> back;
  Pressure pressure{world, {}};
};

/// What the projection does to the particles in a step of 1/60 s.
inline std::vector<Vec4<double>> displacements(Water& water, Real spacing, Real gravity) {
  Projection projection(world, water.grid, water.box, {spacing, 2 * spacing, gravity});
  std::vector<Vec4<double>> out(static_cast<std::size_t>(water.particles.size()));
  projection.find(water.near.order(), water.near.halo(), 1.0 / 60, water.motion());
  projection.displacements<double>(water.near.order(), 1.0 / 60, water.motion(), out);
  return out;
}

inline Real largest(Real value) { return max_over_ranks(world, value); }

}  // namespace trevi::test
