#include "boundary/geometry/mesh_shape.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <numeric>

namespace trevi {

namespace {

constexpr std::int32_t leaf_triangles = 4;

Real distance2_to(const Box& box, const Vec3& p) {
  return (box.min - p).cwiseMax(p - box.max).cwiseMax(0.0).squaredNorm();
}

// The point of triangle abc nearest to p (Ericson, Real-Time Collision Detection, 5.1.5), and the feature it lies on.
struct Closest {
  Vec3 point;
  int feature;
};

Closest closest_on(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& p) {
  const Vec3 ab = b - a, ac = c - a, ap = p - a;
  const Real d1 = ab.dot(ap), d2 = ac.dot(ap);
  if (d1 <= 0 && d2 <= 0) return {a, 0};
  const Vec3 bp = p - b;
  const Real d3 = ab.dot(bp), d4 = ac.dot(bp);
  if (d3 >= 0 && d4 <= d3) return {b, 1};
  const Real vc = d1 * d4 - d3 * d2;
  if (vc <= 0 && d1 >= 0 && d3 <= 0) return {a + d1 / (d1 - d3) * ab, 3};
  const Vec3 cp = p - c;
  const Real d5 = ab.dot(cp), d6 = ac.dot(cp);
  if (d6 >= 0 && d5 <= d6) return {c, 2};
  const Real vb = d5 * d2 - d1 * d6;
  if (vb <= 0 && d2 >= 0 && d6 <= 0) return {a + d2 / (d2 - d6) * ac, 5};
  const Real va = d3 * d6 - d5 * d4;
  if (va <= 0 && d4 - d3 >= 0 && d5 - d6 >= 0) return {b + (d4 - d3) / ((d4 - d3) + (d5 - d6)) * (c - b), 4};
  const Real per = 1 / (va + vb + vc);
  return {a + ab * (vb * per) + ac * (vc * per), 6};
}

// Approximates the angle between two unit vectors, from 0 to pi, to 1e-3, without the arc cosine of the C library.
// Weights for the normal of a corner need not be more exact.
Real about_angle(const Vec3& a, const Vec3& b) {
  const Real c = std::clamp(a.dot(b), -1.0, 1.0), x = std::abs(c);
  const Real acute = std::sqrt(1 - x) * (1.5707288 + x * (-0.2121144 + x * (0.0742610 - x * 0.0187293)));
  return c < 0 ? 3.14159265358979 - acute : acute;
}

}  // namespace

MeshShape::MeshShape(std::shared_ptr<const TriangleMesh> mesh, bool inside) : mesh_(std::move(mesh)), inside_(inside) {
  order_.resize(mesh_->triangles.size());
  std::iota(order_.begin(), order_.end(), 0);
  nodes_.resize(1);
  build(0, 0, static_cast<std::int32_t>(order_.size()));
  find_normals();
}

void MeshShape::find_normals() {
  const std::size_t count = mesh_->triangles.size();
  normals_.resize(count);
  std::vector<Vec3> of_corner(mesh_->points.size(), Vec3::Zero());
  std::map<std::pair<std::int32_t, std::int32_t>, Vec3> of_edge;
  const auto edge = [&](std::size_t t, std::size_t k) {
    const auto& corners = mesh_->triangles[t];
    return std::minmax(corners[k], corners[(k + 1) % 3]);
  };
  for (std::size_t t = 0; t < count; ++t) {
    std::array<Vec3, 3> along_edge;
    for (std::size_t k = 0; k < 3; ++k) {
      const auto i = static_cast<std::int32_t>(t);
      along_edge[k] = (corner(i, (k + 1) % 3) - corner(i, k)).normalized();
    }
    const Vec3 face = along_edge[0].cross(along_edge[1]).normalized();
    normals_[t][6] = face;
    for (std::size_t k = 0; k < 3; ++k) {
      of_corner[static_cast<std::size_t>(mesh_->triangles[t][k])] +=
          about_angle(along_edge[k], -along_edge[(k + 2) % 3]) * face;
      of_edge.try_emplace(edge(t, k), Vec3::Zero()).first->second += face;
    }
  }
  for (std::size_t t = 0; t < count; ++t) {
    for (std::size_t k = 0; k < 3; ++k) {
      normals_[t][k] = of_corner[static_cast<std::size_t>(mesh_->triangles[t][k])];
      normals_[t][k + 3] = of_edge.at(edge(t, k));
    }
  }
}

Box MeshShape::box_of(std::int32_t triangle) const {
  const Vec3 &a = corner(triangle, 0), &b = corner(triangle, 1), &c = corner(triangle, 2);
  return {a.cwiseMin(b).cwiseMin(c), a.cwiseMax(b).cwiseMax(c)};
}

// Halves the triangles along the longest axis of their box, by the centres of their own boxes.
void MeshShape::build(std::size_t node, std::int32_t begin, std::int32_t end) {
  Box all = box_of(order_[static_cast<std::size_t>(begin)]);
  for (std::int32_t k = begin; k < end; ++k) {
    const Box one = box_of(order_[static_cast<std::size_t>(k)]);
    all = {all.min.cwiseMin(one.min), all.max.cwiseMax(one.max)};
  }
  nodes_[node].box = all;
  if (end - begin <= leaf_triangles) {
    nodes_[node].first = begin;
    nodes_[node].count = end - begin;
    return;
  }
  int axis = 0;
  (all.max - all.min).maxCoeff(&axis);
  const std::int32_t middle = begin + (end - begin) / 2;
  const auto place = [&](std::int32_t t) {
    const Box box = box_of(t);
    return std::pair(box.min[axis] + box.max[axis], t);
  };
  std::nth_element(order_.begin() + begin, order_.begin() + middle, order_.begin() + end,
                   [&](std::int32_t a, std::int32_t b) { return place(a) < place(b); });
  const std::size_t children = nodes_.size();
  nodes_.resize(children + 2);
  nodes_[node].first = static_cast<std::int32_t>(children);
  build(children, begin, middle);
  build(children + 1, middle, end);
}

// Of triangles at the same distance, the one with the lowest number counts, in whatever order they are visited.
void MeshShape::try_triangle(std::int32_t triangle, const Vec3& p, Nearest& nearest) const {
  const Closest closest = closest_on(corner(triangle, 0), corner(triangle, 1), corner(triangle, 2), p);
  const Real d2 = (p - closest.point).squaredNorm();
  if (d2 > nearest.distance2 || (d2 == nearest.distance2 && nearest.triangle >= 0 && triangle > nearest.triangle))
    return;
  nearest = {d2, triangle, closest.point, closest.feature};
}

MeshShape::Nearest MeshShape::nearest_to(const Vec3& p, Real reach) const {
  struct Waiting {
    Real distance2;
    std::int32_t node;
  };
  std::array<Waiting, 128> stack;  // twice the depth of a tree of 2^31 triangles that are halved
  std::size_t size = 0;
  Nearest nearest{reach * reach};
  stack[size++] = {distance2_to(nodes_[0].box, p), 0};
  while (size > 0) {
    const Waiting top = stack[--size];
    if (top.distance2 > nearest.distance2) continue;
    const Node& node = nodes_[static_cast<std::size_t>(top.node)];
    for (std::int32_t k = node.first; k < node.first + node.count; ++k)
      try_triangle(order_[static_cast<std::size_t>(k)], p, nearest);
    if (node.count > 0) continue;
    Waiting near{distance2_to(nodes_[static_cast<std::size_t>(node.first)].box, p), node.first};
    Waiting far{distance2_to(nodes_[static_cast<std::size_t>(node.first) + 1].box, p), node.first + 1};
    if (far.distance2 < near.distance2) std::swap(near, far);
    stack[size++] = far;
    stack[size++] = near;
  }
  return nearest;
}

Real MeshShape::signed_distance(const Vec3& p, Real reach) const {
  const Nearest nearest = nearest_to(p, reach);
  if (nearest.triangle < 0) return reach;  // treated as outside of the solid, where particles are
  const Vec3& normal = normals_[static_cast<std::size_t>(nearest.triangle)][static_cast<std::size_t>(nearest.feature)];
  const Real distance = std::sqrt(nearest.distance2);
  return ((p - nearest.point).dot(normal) < 0) == inside_ ? distance : -distance;
}

Real MeshShape::distance(const Vec3& p) const { return signed_distance(p, std::numeric_limits<Real>::max()); }

Real MeshShape::distance_within(const Vec3& p, Real reach) const { return signed_distance(p, reach); }

}  // namespace trevi
