// Where water leaves and enters, as the projection sees it. The cells of a drain are open: whatever is in them is dry,
// at the pressure of the air, so that the water around them is pushed towards them. One that lies on one wall of the
// box, not thicker than a cell or two, is a hole in that wall: water above it enters from above. An opening in a wall
// of the box is a part of that wall through which water goes with a given displacement; it is no surface. Not
// collective.
#pragma once

#include <cmath>
#include <cstdint>
#include <functional>
#include <utility>
#include <vector>

#include "projection/grid.hpp"

namespace trevi {

/// A rectangle in an upright wall of the box that water goes through.
struct WallOpening {
  int axis = 0;                      ///< coordinate across the wall
  bool at_max = false;               ///< the wall at the upper end of that axis
  std::array<Real, 2> across{};      ///< from and to along the other level axis, m
  Real bottom = 0, row_height = 0;   ///< of its rows, m
  std::vector<Real> displacement{};  ///< of the water in each row along +axis in the substep, m
  bool takes_all = false;            ///< it reaches as high as the water does
};

class Openings {
 public:
  struct Drain {
    std::function<bool(const Vec3&)> takes;  ///< what is at a place
    Box bounds;                              ///< of all that it takes
  };
  explicit Openings(std::vector<Drain> drains) : drains_(std::move(drains)) {}

  /// Those of the substep that comes.
  void set_walls(std::vector<WallOpening> walls) { walls_ = std::move(walls); }
  /// Water that inlets bring in the substep that comes, around places of their openings.
  struct Source {
    Vec3 place, direction;
    Real volume;  ///< m³
  };
  /// Each fills cubes of edge `spacing`.
  void set_sources(std::vector<Source> sources, Real spacing) {
    sources_ = std::move(sources);
    spacing_ = spacing;
  }

  /// For the planes and columns that `grid` has now.
  void measure(const ProjectionGrid& grid);

  bool is_drained(std::size_t at) const { return drained_[at] == open_to_air; }
  /// The same, or a cell that keeps itself empty as a drain takes all of it, at the edge of what it takes.
  bool is_emptied(std::size_t at) const { return drained_[at] != 0; }
  /// Holes under water take nothing through their sides. `wet` of all cells.
  void close_sides(const ProjectionGrid& grid, const Borrowed<char>& wet);
  /// Whether face (a, at) is the side of a hole under water.
  bool closes(std::size_t a, std::size_t at) const { return (closed_[at] & (1U << a)) != 0; }
  /// Displacement of what goes through face (a, at) of a wall, m.
  Real displacement(std::size_t a, std::size_t at) const { return through_[a][at]; }

  /// A face of a wall and the cell before it.
  struct Face {
    std::size_t cell, a, at;
    bool at_max;
    Real covered;  ///< share of the face
    bool takes_all;
  };
  const std::vector<Face>& faces() const { return faces_; }

  /// What sources bring to an own cell, as a share of the cell, and what is behind the opening: a cell or a wall.
  struct Gain {
    LocalId k, r, c;
    std::size_t cell, behind;
    bool wall_behind;
    Real share;
    std::size_t a, face;  ///< between the two
    Real path;            ///< of the water in the substep along +a, in cells
  };
  /// On all ranks alike.
  bool has_sources() const { return !sources_.empty(); }
  const std::vector<Gain>& gains() const { return gains_; }
  /// From here on in this substep that water comes as if through the face behind it.
  void come_through(const ProjectionGrid& grid, const Gain& gain) {
    through_[gain.a][gain.face] = gain.path * grid.size()[static_cast<Eigen::Index>(gain.a)];
  }

  /// Adds what pressed water takes to make room, m² of phi times the volume of a particle: of the own cells.
  void add_work(Real work, Real dt) {
    constexpr Real highest = 1e12;  // of what no run survives
    const Real units = work / (dt * dt * work_unit);
    if (std::abs(units) < highest) work_ += std::llround(units);
  }
  /// The same since it was last taken, in work_unit of a particle: whole numbers, so that no order is seen in it.
  std::int64_t take_work() { return std::exchange(work_, 0); }
  static constexpr Real work_unit = 1.0 / (1 << 20);  ///< m²/s²

  std::size_t bytes() const;

 private:
  using Cell = std::array<LocalId, 3>;  // of the box
  // Of a hole: the direction out of its wall, and whether that is upwards along it.
  struct Drained {
    Cell cell;
    int out = -1;
    bool up = false;
    bool empty = false;  // taken whole, and no hole
  };
  static constexpr char open_to_air = 1, emptied = 2;  // of drained_
  void find_drained(const ProjectionGrid& grid);
  void find_wall(const ProjectionGrid& grid, std::size_t first);
  void close(std::size_t a, std::size_t at);
  void measure_wall(const ProjectionGrid& grid, const WallOpening& wall);
  void measure_face(const ProjectionGrid& grid, const WallOpening& wall, const Cell& cell);
  void measure_source(const ProjectionGrid& grid, const Source& source);
  void add_gain(const ProjectionGrid& grid, const Source& source, const Cell& cell,
                const std::pair<Real, Real>& share_ahead);

  std::vector<Drain> drains_;
  std::vector<WallOpening> walls_;
  bool found_ = false;
  std::vector<Drained> drained_cells_;
  std::vector<std::size_t> marked_, closed_at_;  // of drained_ and closed_
  std::vector<char> drained_;
  std::vector<unsigned char> closed_;  // a bit for each direction
  std::array<std::vector<Real>, 3> through_;
  std::vector<Face> faces_;
  std::vector<Source> sources_;
  Real spacing_ = 0;
  std::vector<Gain> gains_;
  std::int64_t work_ = 0;
};

}  // namespace trevi
