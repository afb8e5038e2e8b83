// Inflow and outflow as the projection sees them. The cells of a drain are open: they are dry and at air pressure,
// whatever they hold, so that the water around them is pushed towards them. A drain that lies on one wall of the box
// and is no thicker than a cell or two is a hole in that wall: water above it enters from above. So is a drain of a
// single layer of cells, at no wall, on the horizontal face of an obstacle at rest that fills the cells behind it. An
// opening in a wall of the box is a part of that wall through which water flows with a given displacement; it is not a
// free surface. Not collective.
#pragma once

#include <cmath>
#include <cstdint>
#include <functional>
#include <utility>
#include <vector>

#include "projection/cut_cells.hpp"

namespace trevi {

/// A rectangle in a vertical wall of the box through which water flows.
struct WallOpening {
  int axis = 0;                      ///< coordinate across the wall
  bool at_max = false;               ///< the wall at the upper end of that axis
  std::array<Real, 2> across{};      ///< its ends along the other horizontal axis, m
  Real bottom = 0, row_height = 0;   ///< of its rows, m
  std::vector<Real> displacement{};  ///< of the water in each row along +axis in the substep, m
  bool takes_all = false;            ///< whether it reaches as high as the water does
};

class Openings {
 public:
  struct Drain {
    std::function<bool(const Vec3&)> takes;  ///< whether it takes water at a position
    Box bounds;                              ///< of its region
  };
  explicit Openings(std::vector<Drain> drains) : drains_(std::move(drains)) {}

  /// Sets the openings of the next substep.
  void set_walls(std::vector<WallOpening> walls) { walls_ = std::move(walls); }
  /// Water that inlets bring in the next substep, around places of their openings.
  struct Source {
    Vec3 place, direction;
    Real volume;  ///< m³
  };
  /// Each source fills cubes of edge `spacing`.
  void set_sources(std::vector<Source> sources, Real spacing) {
    sources_ = std::move(sources);
    spacing_ = spacing;
  }

  /// Finds the cells and faces of the openings in the present planes and columns of `grid`. `cuts` may be null.
  void measure(const ProjectionGrid& grid, const CutCells* cuts);

  bool is_drained(std::size_t at) const { return drained_[at] == open_to_air; }
  /// Whether water enters a cell, or a ghost cell, from an inlet, or leaves it through a wall. It does so particle by
  /// particle or in layers, so that the cell may seem empty for a while.
  bool is_crossed(std::size_t at) const { return crossed_[at] != 0; }
  const std::vector<std::size_t>& crossed_cells() const { return crossed_cells_; }
  /// Whether the cell is drained, or stays empty because a drain takes all of it, at the edge of the drain's region.
  bool is_emptied(std::size_t at) const { return drained_[at] != 0; }
  /// Closes the sides of holes under water. `wet`: of all cells.
  void close_sides(const ProjectionGrid& grid, const Borrowed<char>& wet);
  /// Whether face (a, at) is the side of a hole under water.
  bool closes(std::size_t a, std::size_t at) const { return (closed_[at] & (1U << a)) != 0; }
  /// Displacement of the water that flows through face (a, at) of a wall, m.
  Real displacement(std::size_t a, std::size_t at) const { return through_[a][at]; }

  /// A face of a wall and the cell in front of it.
  struct Face {
    std::size_t cell, a, at;
    bool at_max;
    Real covered;  ///< share of the face
    bool takes_all;
  };
  const std::vector<Face>& faces() const { return faces_; }

  /// The volume that sources bring to an owned cell, as a share of the cell, and the cell or wall behind the opening.
  struct Gain {
    LocalId k, r, c;
    std::size_t cell, behind;
    bool wall_behind;
    Real share;
    std::size_t a, face;  ///< between the two
    Real path;            ///< of the water in the substep along +a, in cells
  };
  /// The same on all ranks.
  bool has_sources() const { return !sources_.empty(); }
  const std::vector<Gain>& gains() const { return gains_; }
  /// From now on in this substep this water enters as if through the face behind it, on a path in cells.
  void come_through(const ProjectionGrid& grid, const Gain& gain, Real path) {
    through_[gain.a][gain.face] = path * grid.size()[static_cast<Eigen::Index>(gain.a)];
  }

  /// Adds the work of making room in water under pressure, in m² of phi times the volume of a particle, for owned
  /// cells.
  void add_work(Real work, Real dt) {
    constexpr Real highest = 1e12;  // more than any run survives
    const Real units = work / (dt * dt * work_unit);
    if (std::abs(units) < highest) work_ += std::llround(units);
  }
  /// The work since the last call, in work_unit per particle: an integer, so that it does not depend on the order.
  std::int64_t take_work() { return std::exchange(work_, 0); }
  static constexpr Real work_unit = 1.0 / (1 << 20);  ///< m²/s²

  std::size_t bytes() const;

 private:
  using Cell = std::array<LocalId, 3>;  // of the box
  // A drained cell. For a hole: the direction out of its wall or obstacle, and whether that points upwards along this
  // direction.
  struct Drained {
    Cell cell;
    int out = -1;
    bool up = false;
    bool whole = false;  // whether a drain takes all of it
    bool layer = false;  // whether the drain is a single layer of cells at no wall, which is a hole in an obstacle
    bool is_empty() const { return whole && out < 0; }
  };
  static constexpr char open_to_air = 1, emptied = 2;  // of drained_
  void find_drained(const ProjectionGrid& grid);
  void find_wall(const ProjectionGrid& grid, std::size_t first);
  static void find_obstacle(const CutCells& cuts, std::size_t at, bool is_highest, Drained& drained);
  void close(std::size_t a, std::size_t at);
  void find_crossed(const ProjectionGrid& grid);
  void measure_wall(const ProjectionGrid& grid, const WallOpening& wall);
  void measure_face(const ProjectionGrid& grid, const WallOpening& wall, const Cell& cell);
  void measure_source(const ProjectionGrid& grid, const Source& source);
  void add_gain(const ProjectionGrid& grid, const Source& source, const Cell& cell,
                const std::pair<Real, Real>& share_ahead);

  std::vector<Drain> drains_;
  std::vector<WallOpening> walls_;
  bool found_ = false;
  std::vector<Drained> drained_cells_;
  std::vector<std::size_t> marked_, closed_at_, crossed_cells_;  // of drained_, closed_ and crossed_
  std::vector<char> drained_, crossed_;
  std::vector<unsigned char> closed_;  // a bit for each direction
  std::array<std::vector<Real>, 3> through_;
  std::vector<Face> faces_;
  std::vector<Source> sources_;
  Real spacing_ = 0;
  std::vector<Gain> gains_;
  std::int64_t work_ = 0;
};

}  // namespace trevi
