// What obstacles leave of the projection's cells and faces, against brute sampling of all of them everywhere.
#include <Eigen/Geometry>
#include <cmath>
#include <random>

#include "boundary/obstacles/obstacles.hpp"
#include "boundary/rigid_bodies/rigid_bodies.hpp"
#include "particles/cell_grid.hpp"
#include "projection/cut_cells.hpp"
#include "solids.hpp"
#include "stages.hpp"

namespace trevi::test {
namespace {

TEST(CutCells, FractionsAreThoseOfAllObstacles) {
  const Measured m;
  const Vec3 half = m.grid.size() / 2;
  Real wrong_cell = 0, wrong_faces = 0;
  int cut = 0, cut_faces = 0;
  for (LocalId k = 1; k <= m.grid.planes(); ++k) {
    for (LocalId r = 0; r < m.grid.rows(); ++r) {
      for (LocalId c = 0; c < m.grid.columns(); ++c) {
        const std::size_t at = m.grid.index(k, r, c);
        const Vec3 middle = m.solids.middle(k, r, c);
        const auto [distance, body] = m.nearest(middle);
        if (std::abs(distance) < h / 2) {
          EXPECT_EQ(m.solids.nearest(at), body);
        }
        const Real open = m.open_fraction(middle, half);
        cut += open > 0 && open < 1;
        wrong_cell = std::max(wrong_cell, std::abs(m.solids.open(at) - open));
        for (std::size_t a = 0; a < 3; ++a) {
          if (m.solids.open(at) == 0 || m.grid.is_wall(a, k, r, c) || m.solids.open(at - m.grid.step(a)) == 0) continue;
          Vec3 place = middle, flat = half;
          place[m.grid.axis(a)] -= half[static_cast<Eigen::Index>(a)];
          flat[m.grid.axis(a)] = 0;
          const Real area = m.open_fraction(place, flat);
          cut_faces += area > 0 && area < 1;
          wrong_faces += std::abs(m.solids.face(a, at) - area);
        }
      }
    }
  }
  std::printf("%d cells cut; fractions of volume within %.3f, of area %.4f in the mean of faces cut\n", cut, wrong_cell,
              wrong_faces / cut_faces);
  EXPECT_GT(cut, 50);
  EXPECT_LT(wrong_cell, 0.05);
  EXPECT_LT(wrong_faces, 0.05 * cut_faces);  // in edges of boxes faces are taken to be closed by a sheet
}

// Cells that are cut anew from step to step, only those near solids that move, are those of all cells cut at once.
TEST(CutCells, OfSolidsThatMoveAreThoseCutAtOnce) {
  Settings settings = many_solids(world);
  for (std::size_t k = 0; k < settings.obstacles.size(); k += 3) {
    settings.obstacles[k].velocity = {0.5, -0.3, 0.4};
    settings.obstacles[k].angular_velocity = {0.1, 2, 0.5};
  }
  settings = resolved(settings);
  const AnalyticWallDensity law{settings.domain, kernels_of(settings.fluid).density, h / 2, h, WallSlope::of_positions};
  Obstacles obstacles{settings, Walls(settings.domain, settings.walls, 1e-6 * h), law};
  ProjectionGrid grid{CellGrid(settings.domain.min, settings.domain.max, h, 0), settings.domain};
  grid.resize(window_of(grid, planes_a_rank), 10);
  CutCells step_by_step(obstacles);
  for (int k = 0; k <= 20; ++k) {
    obstacles.move(0.02 * k, 0.02 * (k + 1));
    step_by_step.measure(world, grid, settings.domain, frame_of(grid));
  }
  CutCells at_once(obstacles);
  at_once.measure(world, grid, settings.domain, frame_of(grid));
  int cut = 0;
  for (std::size_t at = 0; at < grid.cells(); ++at) {
    ASSERT_EQ(step_by_step.open(at), at_once.open(at)) << at;
    ASSERT_EQ(step_by_step.capacity(at), at_once.capacity(at)) << at;
    cut += at_once.open(at) > 0 && at_once.open(at) < 1;
    if (at_once.open(at) < 1) {
      ASSERT_EQ(step_by_step.nearest(at), at_once.nearest(at)) << at;
    }
    for (std::size_t a = 0; a < 3; ++a) {
      ASSERT_EQ(step_by_step.face(a, at), at_once.face(a, at)) << at;
      ASSERT_EQ(step_by_step.moved(a, at), at_once.moved(a, at)) << at;
      ASSERT_EQ(step_by_step.middle_of_face(a, at), at_once.middle_of_face(a, at)) << at;
    }
  }
  EXPECT_GT(cut, 50);
}

// Where it is at the end of the substep it would be half a path ahead of the water, whose motion is seen midway.
TEST(CutCells, ASolidThatMovesIsSeenMidwayAndGoesAllOfItsWay) {
  Settings settings;
  settings.domain = {Vec3::Zero(), Vec3(12 * h, 2.4, 2.4)};
  settings.fluid.spacing = h / 2;
  ObstacleSettings ball;
  ball.shape = ShapeKind::sphere;
  ball.radius = 0.5;
  ball.center = {1.1, 1.2, 1.25};
  ball.velocity = {0.9, -0.7, 0.8};
  settings.obstacles.push_back(ball);
  settings = resolved(settings);
  const AnalyticWallDensity law{settings.domain, kernels_of(settings.fluid).density, h / 2, h, WallSlope::of_positions};
  Obstacles obstacles{settings, Walls(settings.domain, settings.walls, 1e-6 * h), law};
  ProjectionGrid grid{CellGrid(settings.domain.min, settings.domain.max, h, 0), settings.domain};
  grid.resize(window_of(grid, 12 / size_of(world)), 12);
  constexpr Real dt = 0.1;
  obstacles.move(0, dt);
  CutCells cuts(obstacles);
  cuts.measure(world, grid, settings.domain, frame_of(grid));
  std::array<Real, 4> own{}, all{};
  for (LocalId k = 1; k <= grid.planes(); ++k) {
    for (LocalId r = 0; r < grid.rows(); ++r) {
      for (LocalId c = 0; c < grid.columns(); ++c) {
        const std::size_t at = grid.index(k, r, c);
        const Real solid = 1 - cuts.open(at);
        const Vec3 moment = solid * cuts.middle(k, r, c);
        for (std::size_t a = 0; a < 3; ++a) {
          own[a] += moment[static_cast<Eigen::Index>(a)];
          if (cuts.open(at) < 1 && cuts.face(a, at) < 1) {
            ASSERT_NEAR(cuts.moved(a, at), dt * ball.velocity[grid.axis(a)], 1e-6);
          }
        }
        own[3] += solid;
      }
    }
  }
  MPI_Allreduce(own.data(), all.data(), 4, MPI_DOUBLE, MPI_SUM, world);
  const Vec3 midway = ball.center + dt / 2 * ball.velocity;
  for (Eigen::Index a = 0; a < 3; ++a) EXPECT_NEAR(all[static_cast<std::size_t>(a)] / all[3], midway[a], 0.005);
}

// A vessel in which water turns as a rigid body, about the upright axis through its centre.
struct Vessel {
  static constexpr LocalId planes = 12;
  Settings settings;
  AnalyticWallDensity law{settings.domain, kernels_of(settings.fluid).density, h / 2, h, WallSlope::of_positions};
  Obstacles obstacles{settings, Walls(settings.domain, settings.walls, 1e-6 * h), law};
  CutCells cuts{obstacles};
  ProjectionGrid grid{CellGrid(settings.domain.min, settings.domain.max, h, 0), settings.domain};

  Vessel(ShapeKind shape, Real radius, const Vec3& centre) : settings(settings_of(shape, radius, centre)) {
    grid.resize(window_of(grid, planes / size_of(world)), 10);
    cuts.measure(world, grid, settings.domain, frame_of(grid));
  }
  static Settings settings_of(ShapeKind shape, Real radius, const Vec3& centre) {
    Settings settings;
    settings.domain = {Vec3::Zero(), Vec3(planes * h, 2.4, 2)};
    settings.fluid.spacing = h / 2;
    ObstacleSettings vessel;
    vessel.shape = shape;
    vessel.inside = true;
    vessel.center = centre;
    vessel.radius = radius;
    vessel.height = 4;
    settings.obstacles.push_back(vessel);
    return resolved(settings);
  }
  // Through a face, of its middle at `in_cell`, in the units of a whole face that moves by one cell.
  Real flux(std::size_t a, std::size_t face, const Vec3& corner, const ByAxis& in_cell) const {
    const Vec3 from_centre = corner + Vec3(in_cell[0], in_cell[1], in_cell[2]).cwiseProduct(Vec3::Constant(h)) -
                             settings.obstacles[0].center;
    return cuts.face(a, face) * Vec3(-from_centre.y(), from_centre.x(), 0)[static_cast<Eigen::Index>(grid.axis(a))] / h;
  }
  Real divergence(LocalId k, LocalId r, LocalId c) const {
    const std::size_t at = grid.index(k, r, c);
    const Vec3 corner = cuts.middle(k, r, c) - grid.size() / 2;
    Real sum = 0;
    for (std::size_t a = 0; a < 3; ++a) {
      const std::size_t above = at + grid.step(a);
      ByAxis low = cuts.middle_of_face(a, at), high = cuts.middle_of_face(a, above);
      low[grid.axis(a)] = 0;
      high[grid.axis(a)] = 1;
      sum += flux(a, above, corner, high) - flux(a, at, corner, low);
    }
    return sum;
  }
};

// Nothing of it passes the wall, so what enters a cell leaves it: else every cell at the wall would brake the water.
// That holds beside cells, too, of which the vessel leaves only a sliver.
TEST(CutCells, ARigidRotationHasNoDivergenceInAVessel) {
  for (const ShapeKind shape : {ShapeKind::cylinder, ShapeKind::sphere}) {
    for (const Real radius : {0.53, 0.8, 0.97}) {
      const Vessel vessel(shape, radius, Vec3(1.19, 1.21, 1.03));
      Real worst = 0;
      int cut = 0;
      for (LocalId k = 1; k <= vessel.grid.planes(); ++k) {
        for (LocalId r = 0; r < vessel.grid.rows(); ++r) {
          for (LocalId c = 0; c < vessel.grid.columns(); ++c) {
            const Real open = vessel.cuts.open(vessel.grid.index(k, r, c));
            cut += open > 0 && open < 1;
            if (open > 0) worst = std::max(worst, std::abs(vessel.divergence(k, r, c)));
          }
        }
      }
      std::printf("radius %.2f: %d cells cut, divergence %.1e of the speed at the wall\n", radius, cut,
                  worst * h / radius);
      EXPECT_LT(worst, 3e-3 * radius / h);
    }
  }
}

// A lattice leaves out what is within half a spacing of the wall, so that cells there are water without a particle. Its
// motion passes their faces nevertheless, and a rotation makes no pressure but that of its weight.
TEST(CutCells, CellsWithoutParticlesMoveWithTheWaterBeside) {
  const Vec3 axis(1.2, 1.2, 1);
  const auto turned = [&](const Vec3& p) { return Vec3(0.05 * Vec3(axis.y() - p.y(), p.x() - axis.x(), 0.3)); };
  for (const Real radius : {0.53, 0.8, 0.97}) {
    Vessel vessel(ShapeKind::cylinder, radius, axis);
    const auto within = [&](const Vec3& p) { return (p - axis).head<2>().norm() < radius - h / 4; };
    Water water(turned, {.top = 1.2, .box = vessel.settings.domain, .holds = within});
    Stages at(water, h / 2, &vessel.obstacles);
    at.classify();
    Real wrong = 0;
    std::int64_t empty = 0;
    at.for_each_cell([&](LocalId k, LocalId r, LocalId c) {
      for (const int a : {0, 1, 2}) {
        const auto i = static_cast<std::size_t>(a);
        const std::size_t cell = at.grid.index(k, r, c), below = cell - at.grid.step(i);
        if (!at.surface->is_wet(cell) || !at.surface->is_wet(below) || at.cuts->face(i, cell) == 0) continue;
        ByAxis middle = at.cuts->middle_of_face(i, cell);
        middle[static_cast<std::size_t>(a)] = 0;
        const Vec3 face = at.middle(k, r, c) + h * Vec3(middle[0] - 0.5, middle[1] - 0.5, middle[2] - 0.5);
        wrong = std::max(wrong, std::abs(at.transfer.displacement(i, cell) - turned(face)[a]));
        empty += at.transfer.moments(cell).at.n == 0 && at.transfer.moments(below).at.n == 0;
      }
    });
    EXPECT_LT(max_over_ranks(world, wrong), 1e-8) << "of 0.05 m, radius " << radius;
    EXPECT_GT(sum_over_ranks(world, empty), 0) << "radius " << radius;
  }
}

// A body in a pool at rest, part of it above the water: force and moment about its centre of what the pressure does to
// it, in units of the weight of the water that the body would displace, by lengths of a cell.
struct Afloat {
  Vec3 force = Vec3::Zero(), moment = Vec3::Zero(), lift = Vec3::Zero(), lift_moment = Vec3::Zero();

  Afloat(const BodySettings& body, Real level) {
    Settings settings;
    settings.domain = {Vec3::Zero(), Vec3(12 * h, 2.4, 2)};
    settings.fluid.spacing = h / 2;
    settings.gravity = Vec3(0, 0, -1);
    settings.bodies.push_back(body);
    settings = resolved(settings);
    const AnalyticWallDensity law{settings.domain, kernels_of(settings.fluid).density, h / 2, h,
                                  WallSlope::of_positions};
    Obstacles obstacles{settings, Walls(settings.domain, settings.walls, 1e-6 * h), law};
    obstacles.move(0, 0.001);
    CutCells cuts{obstacles};
    ProjectionGrid grid{CellGrid(settings.domain.min, settings.domain.max, h, 0), settings.domain};
    grid.resize(window_of(grid, 12 / size_of(world)), 10);
    cuts.measure(world, grid, settings.domain, frame_of(grid));
    const Vec3 center = obstacles.floating()->body(0).end_position();
    const Real all = obstacles.floating()->body(0).volume() / (h * h * h);
    for (LocalId k = 1; k <= grid.planes(); ++k) {
      for (LocalId r = 0; r < grid.rows(); ++r) {
        for (LocalId c = 0; c < grid.columns(); ++c) {
          const std::size_t at = grid.index(k, r, c);
          const Vec3 middle = cuts.middle(k, r, c);
          const Real height = (level - middle.z()) / h + 0.5;
          if (height <= 0 || cuts.open(at) == 0 || cuts.open(at) == 1) continue;
          const Pushes pushes = height >= 1 ? cuts.pushes({k, r, c}, at, {middle.z() - level, 1})
                                            : cuts.pushes_below({k, r, c}, at, height, {0, 1});
          for (std::size_t n = 0; n < pushes.count; ++n) {
            const Vec3 push = -pushes.all[n].shift / all;
            force += push;
            moment += (pushes.all[n].arm - center).cross(push) / h;
          }
        }
      }
    }
    archimedes(obstacles.body(0), center, level);
  }
  // By the midpoints of a lattice.
  void archimedes(const Body& body, const Vec3& center, Real level) {
    constexpr int across = 200;
    const Box box = body.surface_box();
    const Vec3 size = (box.max - box.min) / across;
    int inside = 0;
    Vec3 sum = Vec3::Zero();
    Real wet = 0;
    for (int k = 0; k < across * across * across; ++k) {
      const Vec3 p =
          box.min + size.cwiseProduct(Vec3(k % across + 0.5, k / across % across + 0.5, k / across / across + 0.5));
      if (body.shape().distance(body.now().into_body(p)) > 0) continue;
      ++inside;
      if (p.z() > level) continue;
      ++wet;
      sum += p - center;
    }
    lift = Vec3::UnitZ() * wet / inside;
    lift_moment = sum.cross(Vec3::UnitZ()) / inside / h;
  }
};

BodySettings floater(ShapeKind shape, const Vec3& center) {
  BodySettings body;
  body.shape = shape;
  body.center = center;
  body.radius = 0.3;
  body.tube = 0.12;
  body.height = 0.5;
  body.size = {0.5, 0.6, 0.4};
  body.rotate = {20, 10, 30};
  body.density = 500;
  return body;
}

// The pressure of water at rest pushes nothing aside, turns nothing about the vertical axis, and turns no ball at all.
// With the middle of the solid in a cell by the closed parts of its faces the moment on a ball was 2e-3, which turns it
// by 0.5 rad/s in 30 s. With the pressure of a top cell on all that is in it, and none in
// the cell above, lift and heel were off by 0.04 and 0.15 where the level lies within cells.
TEST(CutCells, WaterAtRestHasTheForceOfArchimedes) {
  Real aside = 0, about = 0, ball = 0, off = 0, heel = 0, lift = 0, within = 0;
  for (const ShapeKind shape : {ShapeKind::sphere, ShapeKind::cylinder, ShapeKind::box, ShapeKind::torus}) {
    for (const Vec3& center : {Vec3(1.19, 1.21, 1.0), Vec3(1.24, 1.16, 0.97), Vec3(1.13, 1.27, 1.05)}) {
      for (const Real level : {0.95, 0.999, 1.09, 2.0}) {
        const Afloat found(floater(shape, center), level);
        aside = std::max(aside, found.force.head<2>().norm());
        about = std::max(about, std::abs(found.moment.z()));
        if (shape == ShapeKind::sphere) ball = std::max(ball, found.moment.norm());
        lift = std::max(lift, std::abs((found.force - found.lift).z()));
        if (level == 2.0) off = std::max(off, (found.force - found.lift).norm());
        if (level == 0.95 || level == 1.09)
          within = std::max(within, (found.moment - found.lift_moment).head<2>().norm());
        if (level == 0.999) heel = std::max(heel, (found.moment - found.lift_moment).head<2>().norm());
      }
    }
  }
  std::printf(
      "of the weight and a cell: aside %.0e, about z %.0e, on a ball %.0e, under water %.0e, heel %.0e and %.0e, lift "
      "%.0e\n",
      aside, about, ball, off, heel, within, lift);
  EXPECT_LT(aside, 4e-4);
  EXPECT_LT(about, 4e-4);
  EXPECT_LT(ball, 3e-4);
  EXPECT_LT(off, 4e-4);
  EXPECT_LT(heel, 5e-3);
  EXPECT_LT(within, 3e-2);
  EXPECT_LT(lift, 1.5e-2);
}

}  // namespace
}  // namespace trevi::test
