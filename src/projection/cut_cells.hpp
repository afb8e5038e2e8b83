// What obstacles leave of the cells and the faces of the grid: fractions of volume and of area that are open to
// water, from samples of the signed distance a quarter of a cell apart, linear about each (Batty et al. 2007), and how
// far a moving solid goes through the rest of a face. A thin sheet between the middles of two cells closes the face
// between them wherever it stands, as pressure must not pass it. Worked out once for obstacles that stand; in each
// substep for cells near which others are, or were in the last one. Arrays are those of ProjectionGrid. Collective:
// measure().
#pragma once

#include <array>
#include <cassert>
#include <memory>
#include <span>
#include <vector>

#include "base/threads.hpp"
#include "boundary/obstacles/obstacles.hpp"
#include "projection/clipped_cell.hpp"
#include "projection/grid.hpp"

namespace trevi {

class CutCells {
 public:
  explicit CutCells(const Obstacles& obstacles);

  /// For the window and columns that `grid` has now; `frame` says how particles fill them.
  void measure(MPI_Comm comm, const ProjectionGrid& grid, const Box& box, const CellFrame& frame);

  /// Fraction of a cell's volume that is open; 0 where hardly any is, and all of its faces are closed then.
  Real open(std::size_t at) const { return cells_[at].open; }
  /// What uniform water fills of a cell, in cells, as particles are spread; more or less than what is open, as they
  /// reach into solids and out of neighbours.
  Real capacity(std::size_t at) const { return cells_[at].capacity; }
  /// How far the middle of a cell lies from the mean place of the water that fills it, along a horizontal direction, in
  /// cells: out of the water at walls that cut it.
  Real aside(std::size_t a, std::size_t at) const { return cells_[at].aside[a]; }
  /// Whether a solid changes what uniform water fills of a cell.
  bool is_near(std::size_t at) const { return cells_[at].open < 1 || cells_[at].capacity != 1; }
  /// That frame for particles of cell (k, r, c): they stay on their own side of a sheet.
  CellFrame beside_solids(const CellFrame& frame, const ProjectionGrid& grid, const std::array<LocalId, 3>& cell) const;
  /// Whether a solid closes a part of the cell, but not all of it.
  bool is_cut(std::size_t at) const { return open(at) > 0 && open(at) < 1; }
  /// Whether a solid closes a part of the cell or of one of its faces.
  bool closes_any(const ProjectionGrid& grid, std::size_t at) const {
    const auto closes = [&](std::size_t a) { return face(a, at) < 1 || face(a, at + grid.step(a)) < 1; };
    return open(at) < 1 || closes(0) || closes(1) || closes(2);
  }
  /// Fraction of the area of face (a, at) that is open.
  Real face(std::size_t a, std::size_t at) const {
    assert(at < cells_.size());  // what is beyond the ghost cells nobody knows
    return cells_[at].face[a];
  }
  /// The middle of the open part of face (a, at), in cells from the cell's corner, by coordinate.
  ByAxis middle_of_face(std::size_t a, std::size_t at) const {
    ByAxis middle{0.5, 0.5, 0.5};
    for (std::size_t i = 0; i < 2; ++i)
      middle[static_cast<std::size_t>(axis_[(a + 1 + i) % 3])] = cells_[at].middle[a][i];
    return middle;
  }
  /// The middle of the closed part of face (a, at) of cell (k, r, c), m.
  Vec3 middle_of_closed(std::size_t a, const std::array<LocalId, 3>& cell, std::size_t at) const {
    return middle_of_closed(a, cell, cells_[at]);
  }
  bool moves() const { return !moved_.empty(); }
  /// Displacement of the solid through the closed part of face (a, at) in the substep, m.
  Real moved(std::size_t a, std::size_t at) const { return moved_.empty() ? 0 : moved_[at][a]; }
  /// Bodies have other twists than when the cells were measured: visit(a, at, change of the displacement of the solid
  /// times the closed part) for all faces that one of them closes in part, in the order of their cells.
  template <class Visit>
  void move_faces(const Visit& visit) {
    for (const BodyFace& face : body_faces_) {
      const Body& body = obstacles_.body(face.body);
      const Vec3 path = body.displacement_at(face.p);
      float& moved = moved_[face.at][face.a];
      const auto now = static_cast<float>(face.share * path[axis_[face.a]] + face.others);
      const Real change = static_cast<Real>(now) - static_cast<Real>(moved);
      moved = now;
      if (change != 0) visit(face.a, face.at, (1 - this->face(face.a, face.at)) * change);
    }
  }
  /// Whether a solid closes anything of a row's cells or of their faces.
  bool cuts_row(LocalId k, LocalId r) const { return cut_columns(k, r).size() != 0; }
  /// All cells of a row of which that holds are among these columns.
  Range cut_columns(LocalId k, LocalId r) const { return cut_columns_[row_index(k, r)]; }
  /// Whether a solid cuts a cell of the row, or of one of those around it.
  bool is_near_cut(LocalId k, LocalId r) const { return columns_near_cut(k, r).size() != 0; }
  /// All cells of a row that are cut, or beside ones that are, are among these columns.
  Range columns_near_cut(LocalId k, LocalId r) const {
    Range near{columns_, 0};
    for (LocalId i = k - 1; i <= k + 1; ++i) {
      for (LocalId j = r - 1; j <= r + 1; ++j) {
        const Range cut = cut_columns_[row_index(i, j)];
        if (cut.size() != 0) near = {std::min(near.begin, cut.begin - 1), std::max(near.end, cut.end + 1)};
      }
    }
    return near.end == 0 ? Range{0, 0} : near;
  }
  /// The obstacle nearest to a cell that is cut.
  std::size_t nearest(std::size_t at) const { return cells_[at].nearest; }
  /// Whether that is a body that moves freely.
  bool floats(std::size_t at) const { return any_floats() && obstacles_.floating()->holds(nearest(at)); }
  bool any_floats() const { return obstacles_.floating() != nullptr; }
  /// Whether that moves by itself, as the scene says.
  bool is_driven(std::size_t at) const { return moves() && obstacles_.body(nearest(at)).moves() && !floats(at); }
  /// Whether it moves about in the water, freely or as the scene says, and does not hold it as a vessel does.
  bool moves_in_water(std::size_t at) const {
    return floats(at) || (is_driven(at) && !obstacles_.body(nearest(at)).is_vessel());
  }
  /// Volume of the solid in a cell of which it is the nearest, in cells. Of a body that floats it is what is not open.
  /// Samples are flat, and make too much of what is round: where the cells see all of such a body, each takes so much
  /// off its surface that the sum is the body's own, and so is their centre of volume.
  Real solid(std::size_t at) const {
    if (!floats(at)) return cells_[at].solid;
    return 1 - open(at) - excess_[nearest(at)].volume * area(at);
  }
  /// The middle of that volume, m.
  Vec3 middle_of_solid(const std::array<LocalId, 3>& cell, std::size_t at) const;
  /// Pressure in a cell, at its middle and as it grows downwards: m² and m.
  struct CellPressure {
    Real phi, fall;
  };
  struct Pushes {
    std::array<Impulse, 13> all;
    std::size_t count = 0;
    void add(const Vec3& shift, const Vec3& place) { all[count++] = {shift, place}; }
  };
  /// What the pressure of a cell gives to its water at each of its faces that a solid closes, m, with places for arms:
  /// the middles of their closed parts, so that the work on any motion of a body is that on the flux of the cell. By
  /// Gauss's theorem on the solid part of the cell, exact for water at rest however the solid lies.
  Pushes pushes(const std::array<LocalId, 3>& cell, std::size_t at, const CellPressure& pressure) const;
  /// The same of water that stands up to `height` in the cell, in cells, from 0 to 1: `phi` is what its pressure has
  /// beyond that of water at rest. Side faces have it up to that height, as they have the flux.
  Pushes pushes_below(const std::array<LocalId, 3>& cell, std::size_t at, Real height,
                      const CellPressure& pressure) const;
  /// The middle of a cell, m.
  Vec3 middle(LocalId k, LocalId r, LocalId c) const;

  std::size_t bytes() const {
    return (cells_.capacity() + all_.capacity()) * sizeof(Cell) + moved_.capacity() * sizeof(moved_[0]) +
           cut_columns_.capacity() * sizeof(Range);
  }

 private:
  using InCell = std::array<float, 3>;  // by direction, in cells from a corner
  struct Cell {
    float open = 1;
    std::array<float, 3> face{1, 1, 1};
    std::array<std::array<float, 2>, 3> middle{
        {{0.5F, 0.5F}, {0.5F, 0.5F}, {0.5F, 0.5F}}};  // along (a + 1), (a + 2) % 3
    float solid = 0;
    InCell solid_middle{0.5F, 0.5F, 0.5F};
    float capacity = 1;
    std::array<float, 2> aside{};
    std::uint32_t body_faces = 0;  // the number of the first one of its lower faces in `body_faces_`, from 1; 0: none
    std::uint32_t nearest : 30 = 0;
    bool has_shares : 1 = false;  // of its own in `shares_`, as a solid is near
    bool cut : 1 = false;         // whether not all of it and of its lower faces is open
  };
  static void note_cut(Cell& cell) {
    cell.cut = cell.open < 1 || cell.face[0] < 1 || cell.face[1] < 1 || cell.face[2] < 1;
  }
  Vec3 middle_of_closed(std::size_t a, const std::array<LocalId, 3>& cell, const Cell& measured) const;
  struct Nearest {
    Real distance;
    std::size_t body;
  };
  using Bodies = std::vector<std::size_t>;  // numbers of obstacles, in their order
  // Shares of what is open of a cell in itself, (1, 1, 1), and in the 26 around it, in cells.
  using Shares = std::array<float, 27>;
  // Along a direction: those of a place in a cell in the cell below, itself, and the one above.
  using SharesAlong = std::array<Real, 3>;
  // In each direction of a cell.
  static constexpr int samples = 4;
  using SharesOfSamples = std::array<SharesAlong, samples>;
  // Those that matter to a row of cells and to a cell of it; ranges of its columns.
  struct Candidates {
    Bodies of_row, of_cell;
    bool clear = false;  // as of the range
    bool near = false;   // any of them to the cell
    bool thick = false;  // those of the cell
    Shares shares{};     // of the cell
    std::vector<Real> distance;
    std::array<SharesOfSamples, 3> of_samples{};  // by direction, where they are not those of whole cells
    std::vector<unsigned char> is_cut;            // any of the cells of a column and of those around it
  };
  // Cells from `low` to `high` by direction, planes counted from the start of the box.
  struct Zone {
    std::array<LocalId, 3> low, high;
    bool operator==(const Zone&) const = default;
  };
  static constexpr Zone everywhere{{-0x40000000, -0x40000000, -0x40000000}, {0x40000000, 0x40000000, 0x40000000}};
  struct Row {
    LocalId plane, row, columns;  // plane and row counted from the start of the box
  };
  Zone zone_of(const Body& body) const;
  void find_ranges(const Row& row, const std::vector<Zone>& zones, std::vector<Range>& ranges) const;
  void find_ranges_near(const ProjectionGrid& grid, const std::vector<Zone>& zones);
  static Real countable(Real in_cell);
  // Along direction a.
  Real place(std::size_t a, Real in_cells) const;
  Vec3 place(const Vec3& in_cells) const;
  // At the walls a solid goes on as it is a little inside of them: one that stands on the floor closes its face there.
  Real in_box(Eigen::Index axis, Real place) const {
    return std::min(std::max(place, inner_.min[axis]), inner_.max[axis]);
  }
  Vec3 in_box(const Vec3& p) const { return {in_box(0, p.x()), in_box(1, p.y()), in_box(2, p.z())}; }
  Real distance_to(const Body& body, const Vec3& p) const { return body.rough_distance(body.midway().into_body(p)); }
  Nearest nearest_at(const Vec3& p, const Bodies& bodies) const;
  void keep_near(const Vec3& p, Real reach, const Bodies& all, Bodies& kept, std::vector<Real>& distance) const;
  // How far from the middle of a cell one looks for solids, in cells: from a face of it a cell further, 1.66.
  static constexpr Real looked_at = 1.7;
  static constexpr std::array<Real, samples> sample_at{0.125, 0.375, 0.625, 0.875};  // in cells
  // Signed distances at the samples of a square and of a cube, in samples.
  using SquareOfDistances = std::array<Real, samples * samples>;
  using CubeOfDistances = std::array<Real, samples * samples * samples>;
  // What samples of a cell say: planes of them across direction 2, then samples along 0 and 1.
  struct Samples {
    CubeOfDistances distance, open;
    std::array<CubeOfDistances, 3> slope;
  };
  void measure_solid(const Vec3& corner, const Samples& at, const Bodies& bodies, Cell& cell) const;
  void find_shares(const Vec3& corner, const Samples& at, Candidates& candidates) const;
  void find_distances(const Vec3& corner, std::size_t a, std::span<const Real> along, const Bodies& bodies,
                      std::span<Real> distance) const;
  template <std::size_t stride>
  static void find_slopes(std::span<const Real> distance, std::span<Real> slope);
  template <class Visit>
  void for_each_range_near(const Visit& visit) const;
  template <class Visit>
  void for_each_row_near(const Visit& visit);
  bool meets_sheet(const Vec3& from, const Vec3& to, const Bodies& bodies) const;
  void measure_cells(const ProjectionGrid& grid, std::vector<Cell>& cells);
  Cell cell_at(const Vec3& corner, Candidates& candidates) const;
  void measure_face(std::size_t a, const Vec3& corner, const Candidates& near, Cell& cell) const;
  // visit(a, index beyond) for the upper faces of a cell that are in walls of the box, across rows and columns. The
  // ring holds them as lower faces of the cells beyond, of which nothing else counts; of planes ghosts do.
  template <class Visit>
  static void for_each_upper_wall(const ProjectionGrid& grid, LocalId k, LocalId r, LocalId c, const Visit& visit) {
    const std::size_t at = grid.index(k, r, c);
    if (r < grid.rows() && grid.is_wall(1, k, r + 1, c)) visit(std::size_t{1}, at + grid.step(1));
    if (grid.is_wall(2, k, r, c + 1)) visit(std::size_t{2}, at + grid.step(2));
  }
  // Whether none of the solids is a sheet, nor goes on to a wall, as far as one looks from a cell.
  bool are_thick(const Vec3& middle, const Bodies& bodies) const;
  bool are_clear(const Bodies& bodies) const;
  Real solid_part(const Vec3& corner, const Bodies& bodies) const;
  Real open_at(const Vec3& corner, Candidates& candidates, Cell& cell) const;
  bool reaches_open(const Vec3& corner, const Bodies& bodies) const;
  // See cut_cell_capacity.cpp.
  void store_shares(std::size_t cells);
  void measure_capacities(const ProjectionGrid& grid, std::vector<Cell>& cells);
  struct RowsAround;
  RowsAround rows_around(const ProjectionGrid& grid, LocalId k, LocalId r) const;
  void measure_capacity(const RowsAround& rows, LocalId c, std::vector<Cell>& cells) const;
  void confine_shares(const ProjectionGrid& grid, LocalId k, LocalId r, LocalId c, std::vector<Cell>& cells);
  Real rise(std::size_t at, bool hangs) const;
  SharesAlong shares_along(std::size_t a, Real place, Real corner) const;
  const SharesAlong* shares_of_samples(std::size_t a, Real corner, SharesOfSamples& own) const;
  Real off_solid(Real height, Real distance, Real slope) const;
  void use(const CellFrame& frame);
  void find_whole_shares(const ProjectionGrid& grid);
  // Of the first, of others and of the last cell of a row.
  const Shares* whole_shares(const ProjectionGrid& grid, LocalId k, LocalId r) const;
  static std::size_t which_of(Real place, LocalId count) { return place == 0 ? 0 : place == count - 1 ? 2 : 1; }
  // Of a corner counted from that of the first own cell, in cells from that of the box.
  std::array<Real, 3> from_box(const Vec3& corner) const {
    return {corner[0] + (first_ - 1), corner[1] + first_row_, corner[2]};
  }
  bool is_passage(std::size_t a, const Vec3& on_face, const Bodies& bodies) const;
  // The corner of cell (k, r, c), counted from that of the first own cell.
  Vec3 corner_of(const ProjectionGrid& grid, LocalId k, LocalId r, Real c) const;
  void measure_motion(const ProjectionGrid& grid);
  void measure_excess(MPI_Comm comm, const ProjectionGrid& grid);
  std::vector<GlobalId> sums_of_bodies(MPI_Comm comm, const ProjectionGrid& grid) const;
  // Of the surface in a cell, in faces.
  Real area(std::size_t at) const;
  template <class Use>
  void for_each_closed(const std::array<LocalId, 3>& cell, std::size_t at, const Use& use) const;
  void find_columns(const ProjectionGrid& grid);
  void find_cut_rows(const ProjectionGrid& grid);
  std::size_t row_index(LocalId k, LocalId r) const {
    return static_cast<std::size_t>(k) * (static_cast<std::size_t>(rows_) + 2) + static_cast<std::size_t>(r + 1);
  }

  const Obstacles& obstacles_;
  Bodies all_bodies_;
  PerThread<Candidates> candidates_;
  Box box_, inner_;  // inner_: a little inside
  std::array<int, 3> axis_{};
  Vec3 origin_ = Vec3::Zero(), size_ = origin_;  // by direction
  LocalId first_ = -1, planes_ = -1, first_row_ = -1, rows_ = 0, columns_ = 0;
  CellFrame frame_{};
  std::array<Real, 2> less_in_layers_{};   // of a share in a cell beside, along each horizontal direction
  std::array<Shares, 27> whole_shares_{};  // of cells without solids: the first, others and the last by direction
  std::array<std::array<SharesOfSamples, 3>, 3> sample_shares_{};  // the same of samples along each direction
  std::array<LocalId, 3> count_{};                                 // of cells of the box
  std::vector<Cell> all_;                                          // of all columns of the box
  std::unique_ptr<Shares[]> shares_;  // of cells near solids, by index; of others not written
  std::size_t shares_size_ = 0;
  std::vector<Cell> cells_;
  std::vector<std::array<float, 3>> moved_;
  std::vector<Zone> zones_;  // of what moves, as measured last
  struct RangeNear {
    LocalId k, r;
    Range columns;
    Bodies bodies;  // that matter to it
    bool clear;     // these are thick, and go on to no wall
  };
  std::vector<RangeNear> near_;  // the ranges in zones that are being measured, ghost rows included
  // Which part of what is closed of a face a body that floats closes, the middle of that, and the displacement of what
  // else does, times its own part, m.
  struct BodyFace {
    std::size_t at, a, body;
    Vec3 p;
    Real share = 1, others = 0;
  };
  const BodyFace* body_face(std::size_t a, std::size_t at) const;
  BodyFace body_face_beside(std::size_t a, const std::array<LocalId, 3>& cell, const Vec3& corner, std::size_t at,
                            const Bodies& near, std::size_t stride) const;
  std::array<std::size_t, 3> step_{};
  // Of each solid: cells for each face of its surface, and the way to the middle of its part in a cut cell, m.
  struct Excess {
    Real volume = 0;
    Vec3 middle = Vec3::Zero();
  };
  std::vector<Excess> excess_;
  std::vector<BodyFace> body_faces_;  // of bodies that move freely
  std::vector<Range> cut_columns_;    // of planes and rows with those beside them
};

// visit(k, r, columns) for the ranges that find_ranges_near() has found.
template <class Visit>
void CutCells::for_each_range_near(const Visit& visit) const {
  for_each_part(static_cast<LocalId>(near_.size()), [&](LocalId n) {
    const RangeNear& one = near_[static_cast<std::size_t>(n)];
    visit(one.k, one.r, one.columns);
  });
}

// The same with the solids that matter to a range: visit(k, r, candidates, columns).
template <class Visit>
void CutCells::for_each_row_near(const Visit& visit) {
  for_each_part(static_cast<LocalId>(near_.size()), [&](LocalId n) {
    const RangeNear& one = near_[static_cast<std::size_t>(n)];
    Candidates& own = candidates_.mine();
    own.of_row = one.bodies;
    own.clear = one.clear;
    visit(one.k, one.r, own, one.columns);
  });
}

}  // namespace trevi
