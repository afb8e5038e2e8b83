// Meshes as obstacles: their distance against that of the shapes they are of, what is refused as not closed, and a jug
// that keeps its water.
#include <cmath>
#include <random>

#include "boundary/geometry/closed_mesh.hpp"
#include "boundary/geometry/distance_grid.hpp"
#include "boundary/geometry/mesh_shape.hpp"
#include "boundary/geometry/pose.hpp"
#include "boundary/geometry/solid_test.hpp"
#include "boundary/geometry/surface_points.hpp"
#include "boundary/geometry/tessellation.hpp"
#include "parallel/reductions.hpp"
#include "support/cloud.hpp"
#include "support/joined_mesh.hpp"
#include "support/output_fixture.hpp"
#include "support/tank.hpp"
#include "trevi/scene.hpp"
#include "trevi/solver.hpp"

namespace trevi::test {
namespace {

ObstacleSettings mesh_of(TriangleMesh mesh) {
  ObstacleSettings settings;
  settings.shape = ShapeKind::mesh;
  settings.mesh = std::make_shared<const TriangleMesh>(std::move(mesh));
  return settings;
}

// A jug of revolution: outside, over the rim, and down inside; walls one spacing thick.
TriangleMesh jug(Real wall) {
  return joined(turned({{0, -0.6},
                        {0.5, -0.6},
                        {0.7, -0.1},
                        {0.5, 0.3},
                        {0.5, 0.6},
                        {0.5 - wall, 0.6},
                        {0.5 - wall, 0.3},
                        {0.7 - wall, -0.1},
                        {0.5 - wall, -0.6 + wall},
                        {0, -0.6 + wall}},
                       0.002));
}

// A grid of distances is wrong by no more than it says, a sixth of h near the surface, and never doubts where inside is
// when it is far.
TEST(DistanceGrid, IsAsExactAsItSays) {
  constexpr Real h = 0.1;
  std::mt19937 generator(8);
  std::uniform_real_distribution<Real> number(-1.6, 1.6);
  for (const bool inside : {false, true}) {
    const MeshShape shape(std::make_shared<TriangleMesh>(jug(0.1)), inside);
    const DistanceGrid grid(shape, h);
    for (int k = 0; k < 3000; ++k) {
      const Real x = number(generator), y = number(generator);
      const Vec3 p(x, y, number(generator));
      const auto [rough, error] = grid.at(p);
      const Real exact = shape.distance(p);
      EXPECT_EQ(error == 0 && std::signbit(rough) != std::signbit(exact), false);
      if (error == 0) {
        EXPECT_LE(std::abs(rough), std::abs(exact) + 1e-12);
      } else {
        EXPECT_LE(std::abs(rough - exact), std::abs(exact) < h / 4 ? h / 6 : error);
      }
    }
  }
}

// Blocks from a tenth of the walls' thickness to half of the jug, gaps on both sides of the surface.
TEST(SolidTest, SaysWhatTheDistanceSays) {
  std::mt19937 generator(9);
  std::uniform_real_distribution<Real> number(-1.2, 1.2);
  for (const bool inside : {false, true}) {
    const auto mesh = std::make_shared<TriangleMesh>(jug(0.1));
    const MeshShape shape(mesh, inside);
    for (const Real edge : {0.01, 0.1, 0.7}) {
      const SolidTest test(std::make_unique<MeshShape>(mesh, inside), edge);
      for (int k = 0; k < 1000; ++k) {
        const Real x = number(generator), y = number(generator);
        const Vec3 p(x, y, number(generator));
        for (const Real gap : {-0.3, -0.04, 0.0, 0.03, 0.5}) EXPECT_EQ(test.is_nearer(p, gap), shape.distance(p) < gap);
      }
    }
  }
}

// Along a wall of 0.2 spacings and 100 long as along a short one, and nothing on what is round or turns inwards.
TEST(Edges, AreFoundAStepApart) {
  constexpr Real step = 0.1, around = 0.01;
  ObstacleSettings solid;
  solid.shape = ShapeKind::box;
  solid.size = {0.02, 10, 0.6};
  const auto found = [&](const ObstacleSettings& of) {
    const auto shape = make_shape(of);
    return edges_of(*shape, shape->surface(around / 10), around, step);
  };
  const std::vector<Vec3> edges = found(solid);
  for (const Real y : {-5.0, -3.33, 0.07, 4.99}) {
    const Vec3 on_top(0.01, y, 0.3);
    EXPECT_TRUE(
        std::any_of(edges.begin(), edges.end(), [&](const Vec3& p) { return (p - on_top).norm() <= step / 2; }));
  }
  for (const Vec3& p : edges) {
    const Vec3 off = (2 * p.cwiseAbs() - solid.size).cwiseAbs();
    EXPECT_GE((off.array() < 1e-9).count(), 2) << p;  // on two faces at least
  }
  EXPECT_LT(edges.size(), 500U);
  solid.inside = true;
  EXPECT_TRUE(found(solid).empty());
  solid.inside = false;
  solid.radius = 0.3;
  solid.height = 1;
  for (const ShapeKind kind : {ShapeKind::sphere, ShapeKind::capsule}) {
    solid.shape = kind;
    EXPECT_TRUE(found(solid).empty());
  }
  solid.shape = ShapeKind::cylinder;
  for (const Vec3& p : found(solid)) EXPECT_NEAR(std::abs(p.z()), 0.5, 1e-9);
  EXPECT_GT(found(solid).size(), 36U);
}

// A solid that goes on without end does so beyond what pictures show of it.
TEST(SolidTest, SeesWhatGoesOnWithoutEnd) {
  ObstacleSettings pipe;
  pipe.shape = ShapeKind::cylinder;
  pipe.radius = 0.4;
  pipe.height = 1;
  pipe.extruded = true;
  for (const bool inside : {false, true}) {
    pipe.inside = inside;
    const auto shape = make_shape(pipe);
    const SolidTest test(make_shape(pipe), 0.1);
    for (const Real along : {0.0, 0.4, 0.7, 3.0}) {
      for (const Real across : {0.1, 0.35, 0.45, 0.9}) {
        const Vec3 p(across, 0, along);
        for (const Real gap : {-0.1, 0.0, 0.2}) EXPECT_EQ(test.is_nearer(p, gap), shape->distance(p) < gap) << p;
      }
    }
  }
}

TEST(Mesh, OfABoxHasTheDistanceOfTheBox) {
  ObstacleSettings settings;
  settings.shape = ShapeKind::box;
  settings.size = {0.7, 0.4, 0.9};
  const auto box = make_shape(settings), mesh = make_shape(mesh_of(box->surface(0.01)));
  std::mt19937 generator(1);
  std::uniform_real_distribution<Real> number(-1, 1);
  for (int k = 0; k < 5000; ++k) {
    const Real x = number(generator), y = number(generator);
    const Vec3 p(x, y, number(generator));
    EXPECT_NEAR(mesh->distance(p), box->distance(p), 1e-12);
    const Real within = mesh->distance_within(p, 0.2);
    EXPECT_EQ(within, std::abs(box->distance(p)) < 0.2 ? mesh->distance(p) : 0.2);
  }
}

TEST(Mesh, OfATorusHasItsDistanceToTheChords) {
  ObstacleSettings settings;
  settings.shape = ShapeKind::torus;
  settings.radius = 0.5;
  settings.tube = 0.2;
  const auto torus = make_shape(settings);
  const TriangleMesh surface = joined(torus->surface(1e-4));
  EXPECT_EQ(why_not_closed(surface), "");
  for (const bool inside : {false, true}) {
    ObstacleSettings of = mesh_of(surface);
    of.inside = inside;
    const auto mesh = make_shape(of);
    std::mt19937 generator(2);
    std::uniform_real_distribution<Real> number(-1, 1);
    for (int k = 0; k < 2000; ++k) {
      const Real x = number(generator), y = number(generator);
      const Vec3 p(x, y, number(generator) / 2);
      EXPECT_NEAR(mesh->distance(p), (inside ? -1 : 1) * torus->distance(p), 5e-4);
    }
  }
}

TEST(Mesh, IsRefusedWithItsOpenEdges) {
  TriangleMesh mesh = jug(0.1);
  EXPECT_EQ(why_not_closed(mesh), "");
  TriangleMesh open = mesh;
  open.triangles.pop_back();
  EXPECT_TRUE(why_not_closed(open).starts_with("3 open edges, 0 of more than two triangles, 0 between"))
      << why_not_closed(open);
  TriangleMesh turned_one = mesh;
  std::swap(turned_one.triangles[5][0], turned_one.triangles[5][1]);
  EXPECT_TRUE(why_not_closed(turned_one).starts_with("0 open edges, 0 of more than two triangles, 3 between"))
      << why_not_closed(turned_one);
  TriangleMesh inside_out = mesh;
  for (auto& t : inside_out.triangles) std::swap(t[0], t[1]);
  face_outwards(inside_out);
  EXPECT_EQ(why_not_closed(inside_out), "");
  EXPECT_GT(make_shape(mesh_of(inside_out))->distance({0, 0, 0}), 0) << "the inside of the jug is no solid";
  EXPECT_LT(make_shape(mesh_of(inside_out))->distance({0, 0, -0.55}), 0) << "its floor is";
}

// A third of a second at 1 to 3 g sideways there and back: what has not gone over the rim is inside, and nobody in the
// wall.
TEST(Mesh, JugKeepsItsWater) {
  Scene scene = parse_scene(
      "test.toml",
      tank_with_gravity({.min = "-1, -1, -0.8", .max = "1, 1, 1.2", .water = {{"-0.5, -0.5, -0.5", "0.5, 0.5, 0.2"}}}) +
          R"([[obstacle]]
type = "sphere"
center = [0, 0, 0]
radius = 1
)",
      {});
  scene.obstacles = {mesh_of(jug(0.1))};
  scene.obstacles[0].knots = {{0, {0, 0, 0}}, {0.25, {0.1, 0, 0}}, {0.5, {-0.1, 0, 0}}, {0.75, {0, 0, 0}}};
  Particles particles = initial_particles(world, scene);
  const auto shape = make_shape(scene.obstacles[0]);
  const auto in_jug = [](const Vec3& p) { return p.head<2>().norm() < 0.7 && p.z() > -0.55 && p.z() < 0.6; };
  Particles inside;  // only what is in the jug
  for (std::size_t i = 0; i < particles.id.size(); ++i) {
    const Vec3& p = particles.position[i];
    const Real widest = p.z() < -0.1 ? 0.4 + 0.2 * (p.z() + 0.6) / 0.5 : 0.6 - 0.2 * (p.z() + 0.1) / 0.4;
    if (!in_jug(p) || p.head<2>().norm() > widest) continue;
    inside.id.push_back(particles.id[i]);
    inside.position.push_back(p);
    inside.velocity.push_back(Vec3::Zero());
  }
  ASSERT_GT(sum_over_ranks(world, static_cast<std::int64_t>(inside.id.size())), 300) << "the jug holds water";
  const std::unique_ptr<Solver> solver = make_solver(world, scene, std::move(inside));
  solver->start();
  for (int k = 0; k < 20; ++k) {
    solver->step();
    const Pose pose = BodyMotion(scene.obstacles[0]).at(solver->clock().time());
    for (const Vec3& world_p : solver->particles().position) {
      const Vec3 p = pose.into_body(world_p);
      ASSERT_GT(shape->distance(p), -1e-9);
      ASSERT_TRUE(p.z() > 0.5 || p.head<2>().norm() < 0.6) << "through the wall, at " << p.transpose();
    }
  }
}

TriangleMesh box_mesh(const Vec3& low, Real edge, bool inwards = false) {
  TriangleMesh mesh;
  for (int k = 0; k < 8; ++k) mesh.points.push_back(low + edge * Vec3(k & 1, (k >> 1) & 1, (k >> 2) & 1));
  mesh.triangles = {{0, 2, 1}, {1, 2, 3}, {4, 5, 6}, {5, 7, 6}, {0, 1, 4}, {1, 5, 4},
                    {2, 6, 3}, {3, 6, 7}, {0, 4, 2}, {2, 4, 6}, {1, 3, 5}, {3, 7, 5}};
  if (inwards)
    for (auto& t : mesh.triangles) std::swap(t[1], t[2]);
  return mesh;
}

TriangleMesh joined(TriangleMesh a, const TriangleMesh& b) {
  const auto count = static_cast<std::int32_t>(a.points.size());
  a.points.insert(a.points.end(), b.points.begin(), b.points.end());
  for (auto t : b.triangles) a.triangles.push_back({t[0] + count, t[1] + count, t[2] + count});
  return a;
}

TEST(Meshes, ShellsThatOverlapAreFound) {
  const TriangleMesh box = box_mesh({0, 0, 0}, 1);
  EXPECT_EQ(why_not_closed(box), "");
  EXPECT_EQ(where_shells_overlap(box), "");
  EXPECT_EQ(where_shells_overlap(joined(box, box_mesh({2, 0, 0}, 1))), "") << "beside each other";
  EXPECT_EQ(where_shells_overlap(joined(box, box_mesh({0.25, 0.25, 0.25}, 0.5, true))), "") << "a hollow";
  EXPECT_NE(where_shells_overlap(joined(box, box_mesh({0.25, 0.25, 0.25}, 0.5))), "") << "a solid in a solid";
  EXPECT_NE(where_shells_overlap(joined(box, box_mesh({0.5, 0.5, 0.5}, 1))), "") << "corners in each other";
  const auto bar = [](const Vec3& low, const Vec3& size) {
    TriangleMesh mesh = box_mesh({0, 0, 0}, 1);
    for (Vec3& p : mesh.points) p = low + p.cwiseProduct(size);
    return mesh;
  };
  const TriangleMesh along = bar({-2, -0.5, 0}, {4, 1, 1});
  EXPECT_NE(where_shells_overlap(joined(along, bar({-0.5, -2, 0}, {1, 4, 1}))), "") << "a cross of one height";
  EXPECT_NE(where_shells_overlap(joined(along, bar({-0.5, -2, 0.2}, {1, 4, 0.5}))), "") << "one through the other";
  EXPECT_NE(where_shells_overlap(joined(along, along)), "") << "the same again";
  EXPECT_EQ(where_shells_overlap(joined(along, bar({-0.5, -2, 1}, {1, 4, 1}))), "") << "one lies on the other";
  EXPECT_EQ(where_shells_overlap(joined(along, bar({2, -0.5, 0}, {4, 1, 1}))), "") << "end to end";
  EXPECT_NE(where_shells_overlap(joined(along, bar({-0.5, -2, 0.2}, {1, 4, -0.5}))), "") << "a hollow that leaves it";
}

TEST(Meshes, SheetsHaveNoVolume) {
  TriangleMesh sheet;
  sheet.points = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
  sheet.triangles = {{0, 1, 2}, {0, 2, 1}};
  EXPECT_EQ(why_not_closed(sheet), "");
  EXPECT_TRUE(is_flat(sheet));
  EXPECT_FALSE(is_flat(box_mesh({1e3, 0, 0}, 1e-3)));
}

}  // namespace
}  // namespace trevi::test
