// The contribution of a solid to the density of a particle near it: the distance of the plane that covers the same
// fraction of the ball of the density kernel (volume maps, Bender et al. 2019, by way of plane_volume.hpp). For a plane
// at any angle this is the distance itself; a wedge, a ball or a thin sheet covers less and is therefore a plane
// further away. The fraction is summed over cells of h/8, which are cut where the surface meets them, for the nodes of
// a grid of h/4. Between nodes a cubic without kinks (Catmull & Rom) is used with its exact derivative, so that the
// solid returns exactly the energy that it took.
//
// In two dimensions the ball is a disc, perpendicular to the coordinate along which the solid extends without end.
//
// In the frame of the solid, for any number of poses. Blocks of the grid are made when a particle first comes near,
// from the shape alone: the same bits on any number of ranks and threads. Not collective.
#pragma once

#include <cmath>
#include <optional>

#include "boundary/geometry/lazy_blocks.hpp"
#include "boundary/geometry/pose.hpp"
#include "boundary/geometry/shape.hpp"
#include "boundary/volume_map/plane_volume.hpp"

namespace trevi {

/// Distance of the plane that is equivalent to the solid, m, its gradient, and whether the surface may be within h.
struct EquivalentPlane {
  Real distance;
  Vec3 gradient;
  bool is_near = true;
};

/// A solid that does not move continues behind the walls of the box, as if they were not there: one that stands on the
/// floor or is cut by a wall then needs no special treatment.
struct Fixed {
  Pose pose;
  Box box;
};

class VolumeMap {
 public:
  VolumeMap(const Shape& shape, const Kernel& kernel, Real h, const std::optional<Fixed>& fixed);

  /// Whether the surface may be within h of p.
  bool is_near(const Vec3& p) const;
  /// At distances of at least `flat`, m, no gradient is computed.
  EquivalentPlane at(const Vec3& p, Real flat = INFINITY) const;
  /// Memory that the map of a shape takes before any particle has come near it.
  static Real min_bytes(const Box& bounds, Real h);
  std::size_t bytes() const { return cells_.bytes() + nodes_.bytes(); }

 private:
  static constexpr int block = 8;                                // intervals between nodes in each direction of a block
  static constexpr int fine = 2;                                 // cells between two nodes
  static constexpr int reach = 4 * fine;                         // of the kernel, in cells
  static constexpr int edge = block * fine;                      // cells of a block in each direction
  static constexpr int nodes = block + 3;                        // with one before and two after
  static constexpr int window = (nodes - 1) * fine + 2 * reach;  // cells that the nodes of a block see
  enum class Kind { empty, full, cut };
  // Fractions of the cells of a block that are solid.
  struct Cells {
    Kind kind = Kind::empty;
    std::vector<float> fraction;
  };
  // Plane distances at the nodes of a block, m; empty if all have the largest possible distance.
  struct Nodes {
    Kind kind = Kind::empty;
    std::vector<Real> distance;
  };
  // The cells of a window, with those at even and at odd places along x stored separately, so that those of adjacent
  // nodes are adjacent.
  using Window = std::array<std::vector<Real>, 2>;
  struct Weight {
    std::size_t odd;
    std::ptrdiff_t offset;  // from the first cell that a node sees
    Real weight;
  };
  void weigh_cells(const Kernel& kernel);
  Real solid_distance(const Vec3& p) const;
  Real cut_fraction(const Vec3& middle, Real size) const;
  void fill_cells(const Vec3& corner, Cells& cells) const;
  std::unique_ptr<Cells> make_cells(const BlockPlace& place) const;
  std::unique_ptr<Nodes> make_nodes(const BlockPlace& place) const;
  const Cells& cells_at(const BlockPlace& place) const;
  const Nodes& nodes_at(const BlockPlace& place) const;
  bool gather(const BlockPlace& place, Window& cells, Kind& kind) const;
  Real plane_distance(Real fraction, const Vec3& node) const;
  BlockPlace block_of(const Vec3& p) const;
  bool covers(const BlockPlace& place) const;
  EquivalentPlane interpolated(const Nodes& here, const Vec3& in_nodes, Real flat) const;

  const Shape& shape_;
  std::optional<Fixed> fixed_;
  Real h_, node_;  // m
  bool vessel_;
  PlaneVolume plane_;
  BlockPlace low_, high_;
  std::vector<Weight> weights_;
  LazyBlocks<Cells> cells_;
  LazyBlocks<Nodes> nodes_;
};

}  // namespace trevi
