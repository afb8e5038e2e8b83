// Many solids among the cells of the projection, some cut by walls, and what is open by brute sampling.
#pragma once

#include <algorithm>
#include <cmath>
#include <random>

#include "boundary/obstacles/obstacles.hpp"
#include "particles/cell_grid.hpp"
#include "projection/cut_cells.hpp"
#include "projection/particles_to_grid.hpp"
#include "support/cloud.hpp"

namespace trevi::test {

constexpr Real h = 0.2;
constexpr LocalId planes_a_rank = 6;

/// Of this rank, where each has as many planes.
inline CellWindow window_of(const ProjectionGrid& grid, LocalId planes) {
  const LocalId first = rank_of(world) * planes;
  return {{first, first + planes}, {0, grid.count(1)}};
}

/// For particles of half a cell.
inline CellFrame frame_of(const ProjectionGrid& grid) { return ParticlesToGrid(grid, h / 2).frame(); }

// Balls and turned boxes at the places of a loose lattice, none in another, some cut by walls.
inline Settings many_solids(MPI_Comm comm) {
  Settings settings;
  settings.domain = {Vec3::Zero(), Vec3(size_of(comm) * planes_a_rank * h, 2.4, 2)};
  settings.fluid.spacing = h / 2;
  std::mt19937 generator(3);
  std::uniform_real_distribution<Real> shift(-0.1, 0.1), size(0.15, 0.25), turn(0, 90);
  for (Real x = 0.3; x < settings.domain.max.x(); x += 0.9) {
    for (const Vec3& place : {Vec3(0, 0.1, 0.5), Vec3(0, 1.2, 0.2), Vec3(0, 2.1, 1.1), Vec3(0, 0.6, 1.6)}) {
      ObstacleSettings solid;
      // One after the other: compilers differ in the order of arguments.
      solid.center.z() = place.z() + shift(generator);
      solid.center.y() = place.y() + shift(generator);
      solid.center.x() = x + shift(generator);
      solid.shape = settings.obstacles.size() % 2 == 0 ? ShapeKind::sphere : ShapeKind::box;
      solid.radius = size(generator);
      solid.size = {size(generator) * 2, size(generator) * 2, size(generator) * 2};
      if (solid.shape == ShapeKind::box) solid.rotate = {turn(generator), turn(generator), turn(generator)};
      settings.obstacles.push_back(solid);
    }
  }
  return resolved(settings);
}

struct Measured {
  Settings settings = many_solids(world);
  AnalyticWallDensity law{settings.domain, kernels_of(settings.fluid).density, h / 2, h, WallSlope::of_positions};
  Obstacles obstacles{settings, Walls(settings.domain, settings.walls, 1e-6 * h), law};
  CutCells solids{obstacles};
  ProjectionGrid grid{CellGrid(settings.domain.min, settings.domain.max, h, 0), settings.domain};

  Measured() {
    grid.resize(window_of(grid, planes_a_rank), 10);
    solids.measure(world, grid, settings.domain, frame_of(grid));
  }
  std::pair<Real, std::size_t> nearest(const Vec3& p) const {
    std::pair<Real, std::size_t> least{INFINITY, 0};
    for (std::size_t k = 0; k < obstacles.count(); ++k) {
      const Body& body = obstacles.body(k);
      least = std::min(least, {body.shape().distance(body.now().into_body(p)), k});
    }
    return least;
  }
  // Of a cuboid around a middle, or of a rectangle where a half length is 0.
  Real open_fraction(const Vec3& middle, const Vec3& half) const {
    constexpr int n = 12;
    int open = 0;
    for (int i = 0; i < n * n * n; ++i) {
      const Vec3 in_cell(i % n, i / n % n, i / n / n);
      open += nearest(middle + half.cwiseProduct((2 * in_cell.array() + 1 - n).matrix() / n)).first > 0;
    }
    return static_cast<Real>(open) / (n * n * n);
  }
};

}  // namespace trevi::test
