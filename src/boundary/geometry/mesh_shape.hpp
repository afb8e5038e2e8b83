// The exact signed distance of a closed mesh: the nearest triangle is found with a tree of boxes, the sign by the
// angle-weighted normal of the nearest feature, which is a face, an edge or a corner (Bærentzen & Aanæs 2005). Thin
// sheets and sharp edges are as they are in the mesh; a grid of distances would round them. IEEE operations only; ties
// are decided by the number of the triangle. Not collective.
#pragma once

#include <array>
#include <memory>
#include <vector>

#include "boundary/geometry/shape.hpp"

namespace trevi {

class MeshShape : public Shape {
 public:
  /// `inside`: a vessel, whose solid is everything outside of the mesh.
  MeshShape(std::shared_ptr<const TriangleMesh> mesh, bool inside);
  Real distance(const Vec3& p) const override;
  Real distance_within(const Vec3& p, Real reach) const override;
  Box bounds() const override { return nodes_.front().box; }
  TriangleMesh surface(Real) const override { return *mesh_; }

 private:
  // A node of a tree in one array: a leaf has triangles [first, first + count) of order_, any other node has the
  // children `first` and first + 1.
  struct Node {
    Box box;
    std::int32_t first = 0, count = 0;
  };
  struct Nearest {
    Real distance2;
    std::int32_t triangle = -1;
    Vec3 point = Vec3::Zero();
    int feature = 0;  // 0 to 2 a corner, 3 to 5 the edge from corner feature − 3, 6 the face
  };
  void find_normals();
  void build(std::size_t node, std::int32_t begin, std::int32_t end);
  Box box_of(std::int32_t triangle) const;
  void try_triangle(std::int32_t triangle, const Vec3& p, Nearest& nearest) const;
  Nearest nearest_to(const Vec3& p, Real reach) const;
  Real signed_distance(const Vec3& p, Real reach) const;
  const Vec3& corner(std::int32_t triangle, std::size_t k) const {
    return mesh_->points[static_cast<std::size_t>(mesh_->triangles[static_cast<std::size_t>(triangle)][k])];
  }

  std::shared_ptr<const TriangleMesh> mesh_;
  bool inside_;
  std::vector<std::int32_t> order_;
  std::vector<Node> nodes_;
  std::vector<std::array<Vec3, 7>> normals_;  // of each triangle, by feature
};

}  // namespace trevi
