// The open parts of the cells and faces of the grid beside obstacles: the fractions of volume and of area that are open
// to water, from samples of the signed distance a quarter of a cell apart, linear about each (Batty et al. 2007), and
// the displacement of a moving solid through the rest of a face. A thin sheet between the centres of two cells closes
// the face between them, wherever it lies, because pressure must not pass it. All this is computed once for obstacles
// at rest. For cells near moving obstacles, now or in the previous substep, it is computed in each substep. Arrays are
// those of ProjectionGrid. Collective: measure().
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
#include "projection/solid_parts.hpp"

namespace trevi {

class CutCells {
 public:
  explicit CutCells(const Obstacles& obstacles);

  /// Measures the cells in the present window and columns of `grid`; `frame` defines how particles fill them.
  void measure(MPI_Comm comm, const ProjectionGrid& grid, const Box& box, const CellFrame& frame);

  /// Fraction of a cell's volume that is open. It is 0 where hardly any is, and then all of its faces are closed.
  Real open(std::size_t at) const { return cells_[at].open; }
  /// The volume of a cell that uniform water fills, in cells, as particles are spread. It may be more or less than the
  /// open volume, because particles extend into solids and out of neighbouring cells.
  Real capacity(std::size_t at) const { return cells_[at].capacity; }
  /// The distance of the centre of a cell from the mean position of the water that fills it, along a horizontal
  /// direction, in cells: out of the water at walls that cut it.
  Real aside(std::size_t a, std::size_t at) const { return cells_[at].aside[a]; }
  /// Whether a solid changes the volume of a cell that uniform water fills.
  bool is_near(std::size_t at) const { return cells_[at].open < 1 || cells_[at].capacity != 1; }
  /// The frame for particles of cell (k, r, c), which stay on their own side of a sheet.
  CellFrame beside_solids(const CellFrame& frame, const ProjectionGrid& grid, const std::array<LocalId, 3>& cell) const;
  /// Whether a solid closes a part of the cell but not all of it.
  bool is_cut(std::size_t at) const { return open(at) > 0 && open(at) < 1; }
  /// Whether a solid closes a part of the cell or of one of its faces.
  bool closes_any(const ProjectionGrid& grid, std::size_t at) const {
    const auto closes = [&](std::size_t a) { return face(a, at) < 1 || face(a, at + grid.step(a)) < 1; };
    return open(at) < 1 || closes(0) || closes(1) || closes(2);
  }
  /// Fraction of the area of face (a, at) that is open.
  Real face(std::size_t a, std::size_t at) const {
    assert(at < cells_.size());  // nothing is known beyond the ghost cells
    return cells_[at].face[a];
  }
  /// The centroid of the open part of face (a, at), in cells from the corner of the cell, by coordinate.
  ByAxis middle_of_face(std::size_t a, std::size_t at) const {
    ByAxis middle{0.5, 0.5, 0.5};
    for (std::size_t i = 0; i < 2; ++i)
      middle[static_cast<std::size_t>(axis_[(a + 1 + i) % 3])] = cells_[at].middle[a][i];
    return middle;
  }
  /// The centroid of the closed part of face (a, at) of cell (k, r, c), m.
  Vec3 middle_of_closed(std::size_t a, const std::array<LocalId, 3>& cell, std::size_t at) const {
    return middle_of_closed(a, cell, cells_[at]);
  }
  bool moves() const { return !moved_.empty(); }
  /// Displacement of the solid through the closed part of face (a, at) in the substep, m.
  Real moved(std::size_t a, std::size_t at) const { return moved_.empty() ? 0 : moved_[at][a]; }
  /// To be called when the twists of bodies have changed since the cells were measured: calls visit(a, at, change of
  /// the displacement of the solid) for all faces that a body closes in part, in the order of cells.
  template <class Visit>
  void move_faces(const Visit& visit);
  /// Whether a solid closes any part of the cells of a row or of their faces.
  bool cuts_row(LocalId k, LocalId r) const { return cut_columns(k, r).size() != 0; }
  /// Columns that contain all cells of the row for which this holds.
  Range cut_columns(LocalId k, LocalId r) const { return cut_columns_[row_index(k, r)]; }
  /// Whether a solid cuts a cell of the row or of one of the rows around it.
  bool is_near_cut(LocalId k, LocalId r) const { return columns_near_cut(k, r).size() != 0; }
  /// Columns that contain all cells of the row that are cut or beside a cut cell.
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
  /// The obstacle nearest to a cell. Those that move count in the cells that are measured in each substep.
  std::size_t nearest(std::size_t at) const { return cells_[at].nearest; }
  /// Whether the nearest obstacle is a freely moving body, no further than `beside_body` away.
  bool floats(std::size_t at) const {
    return any_floats() && cells_[at].is_beside && obstacles_.floating()->holds(nearest(at));
  }
  bool any_floats() const { return obstacles_.floating() != nullptr; }
  /// Whether it has a prescribed motion.
  bool is_driven(std::size_t at) const {
    const auto floats = [&] { return any_floats() && obstacles_.floating()->holds(nearest(at)); };
    return moves() && cells_[at].has_nearest && obstacles_.body(nearest(at)).moves() && !floats();
  }
  /// Whether an obstacle that does not move fills the cell.
  bool is_filled_at_rest(std::size_t at) const { return open(at) == 0 && !floats(at) && !is_driven(at); }
  /// Whether it moves in the water, freely or as prescribed, and is not a vessel that holds the water.
  bool moves_in_water(std::size_t at) const {
    return floats(at) || (is_driven(at) && !obstacles_.body(nearest(at)).is_vessel());
  }
  /// The centroid of what is not open of a cell, m; corrected as for for_each_solid().
  Vec3 middle_of_solid(const std::array<LocalId, 3>& cell, std::size_t at) const {
    return middle_in(cell, cells_[at].solid_middle) - excess_[cells_[at].nearest].middle;
  }
  /// Calls use(solid, volume, centroid, m) for the solids in a cell. The volume of a floating body, in cells, is what
  /// is not open, less a share of its surface: samples are flat and overestimate round shapes, so where the cells cover
  /// all of such a body, its total volume and centroid are made exact.
  template <class Use>
  void for_each_solid(const std::array<LocalId, 3>& cell, std::size_t at, const Use& use) const;
  /// The parts of the solids in a cell that is near a freely moving body and near another solid.
  std::span<const PartOfCell> parts_of_cell(std::size_t at) const { return parts_.of_cell(at); }
  /// The parts of the solids that close a face near a freely moving body.
  std::span<const PartOfFace> parts_of_face(std::size_t a, std::size_t at) const {
    const std::size_t first = cells_[at].parts;
    return first == 0 ? std::span<const PartOfFace>() : parts_.of_face(a, at, first - 1);
  }
  /// Pressure in a cell: its value at the centre, m², and its growth downwards, m.
  struct CellPressure {
    Real phi, fall;
  };
  /// Calls use(solid, direction, whether it is the upper face, area of the part that this solid closes, centroid of
  /// that, m) for the faces of a cell. What is closed of the lower and the upper face of a gap alike is left out.
  template <class Use>
  void for_each_closed(const std::array<LocalId, 3>& cell, std::size_t at, const Use& use) const;
  /// Whether a cell is a thin gap below or above a freely moving body: part of its contact (ContactFilms).
  bool is_gap(std::size_t at) const { return gap_at(at) != nullptr; }
  /// The part of its lower or upper face that bounds the gap.
  Real in_gap(std::size_t at, bool upper) const {
    const Gap* const gap = gap_at(at);
    return gap != nullptr && gap->ends[upper ? 1 : 0] ? gap->between : 0;
  }
  /// The closed part of the lower or upper face of a cell along direction a, less the part that bounds a gap. The
  /// pressure of the cell acts on it, and its motion changes the room for the water of the cell.
  Real closed(std::size_t a, std::size_t at, bool upper) const {
    const Real all = 1 - face(a, upper ? at + step_[a] : at);
    return a == 2 ? std::max(all - in_gap(at, upper), 0.0) : all;  // a wall may bound a gap
  }
  /// Whether the pressure of a cell pushes a freely moving body.
  bool is_pushed(std::size_t at) const;
  /// The impulses that the pressure of a cell gives to its water at each of its faces that a solid closes, m. Their
  /// points of application are the centroids of the closed parts, so that the work on any motion of a body equals the
  /// work on the flux of the cell. By Gauss's theorem on the part of each solid in the cell this is exact for water at
  /// rest, whatever the position of the solids.
  Pushes pushes(const std::array<LocalId, 3>& cell, std::size_t at, const CellPressure& pressure) const;
  /// The same for water that reaches up to `height` in the cell, in cells, from 0 to 1. `phi` is the pressure in excess
  /// of that of water at rest. It acts on side faces up to that height, like the flux.
  Pushes pushes_below(const std::array<LocalId, 3>& cell, std::size_t at, Real height,
                      const CellPressure& pressure) const;
  /// The centre of a cell, m.
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
    std::uint32_t parts = 0;  // number of the first part of its lower faces in `parts_`, from 1; 0: none
    static constexpr std::uint32_t max_nearest = 0xfffffffU;
    std::uint32_t nearest : 28 = 0;
    bool is_beside : 1 = false;    // whether that is no further than `beside_body` away
    bool has_nearest : 1 = false;  // whether any solid counts for it
    bool has_shares : 1 = false;   // whether it has its own shares in `shares_`, because a solid is near
    bool cut : 1 = false;          // whether a part of it or of its lower faces is closed
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
  // The shares that the open part of a cell has in the cell itself, (1, 1, 1), and in the 26 around it, in cells.
  using Shares = std::array<float, 27>;
  // Along one direction: the shares of a point of a cell in the cell below, the cell itself, and the cell above.
  using SharesAlong = std::array<Real, 3>;
  // Samples in each direction of a cell.
  static constexpr int samples = 4;
  using SharesOfSamples = std::array<SharesAlong, samples>;
  // Obstacles that matter to a row of cells and to one of its cells.
  struct Candidates {
    Bodies of_row, of_cell;
    bool clear = false;  // as for the range
    bool near = false;   // whether any of them is near the cell
    bool thick = false;  // whether those of the cell are thick
    Shares shares{};     // of the cell
    std::vector<Real> distance;
    std::array<SharesOfSamples, 3> of_samples{};  // by direction, where they differ from those of whole cells
    std::vector<unsigned char> is_cut;            // whether any of the cells of a column and of those around it is cut
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
  // The position along direction a.
  Real place(std::size_t a, Real in_cells) const;
  Vec3 place(const Vec3& in_cells) const;
  Vec3 middle_in(const std::array<LocalId, 3>& cell, const InCell& in_cell) const;
  // At the walls a solid continues as it is slightly inside them, so that a solid on the floor closes its face there.
  Real in_box(Eigen::Index axis, Real place) const {
    return std::min(std::max(place, inner_.min[axis]), inner_.max[axis]);
  }
  Vec3 in_box(const Vec3& p) const { return {in_box(0, p.x()), in_box(1, p.y()), in_box(2, p.z())}; }
  Real distance_to(const Body& body, const Vec3& p) const { return body.rough_distance(body.midway().into_body(p)); }
  Nearest nearest_at(const Vec3& p, const Bodies& bodies) const;
  void find_nearest(const Vec3& corner, const Nearest& far, const Bodies& bodies, Cell& cell) const;
  void keep_near(const Vec3& p, Real reach, const Bodies& all, Bodies& kept, std::vector<Real>& distance) const;
  // Distance from the centre of a cell within which solids are searched, in cells: a cell beyond one of its
  // faces, 1.66.
  static constexpr Real looked_at = 1.7;
  // Distance from a floating body, in cells, up to which water is beside it. Further away, where water one cell deep
  // would have counted as deep among solids, rafts of nine floats turned by up to 9 rad/s.
  static constexpr Real beside_body = 1.25;
  static constexpr std::array<Real, samples> sample_at{0.125, 0.375, 0.625, 0.875};  // in cells
  // Signed distances at the samples of a square and of a cube, in samples.
  using SquareOfDistances = std::array<Real, samples * samples>;
  using CubeOfDistances = std::array<Real, samples * samples * samples>;
  // The values at the samples of a cell: planes of samples across direction 2, then samples along 0 and 1.
  struct Samples {
    CubeOfDistances distance, open;
    std::array<CubeOfDistances, 3> slope;
  };
  void measure_solid(const Vec3& corner, const Samples& at, const Bodies& bodies, Cell& cell) const;
  void find_shares(const Vec3& corner, const Samples& at, Candidates& candidates) const;
  void find_distances(const Vec3& corner, std::size_t a, std::span<const Real> along, const Bodies& bodies,
                      std::span<Real> distance) const;
  Real depth_below(const Vec3& p, const Nearest& nearest, Real width, const Bodies& bodies, int surfaces) const;
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
  // Calls visit(a, index beyond) for the upper faces of a cell that lie in walls of the box, across rows and columns.
  // The ring holds them as lower faces of the cells beyond, whose other values are not used; for planes, ghost planes
  // do.
  template <class Visit>
  static void for_each_upper_wall(const ProjectionGrid& grid, LocalId k, LocalId r, LocalId c, const Visit& visit) {
    const std::size_t at = grid.index(k, r, c);
    if (r < grid.rows() && grid.is_wall(1, k, r + 1, c)) visit(std::size_t{1}, at + grid.step(1));
    if (grid.is_wall(2, k, r, c + 1)) visit(std::size_t{2}, at + grid.step(2));
  }
  // Whether none of the solids within the search distance of a cell is a sheet or extends to a wall.
  bool are_thick(const Vec3& middle, const Bodies& bodies) const;
  bool are_clear(const Bodies& bodies) const;
  Real solid_part(const Vec3& corner, const Bodies& bodies) const;
  Real open_at(const Vec3& corner, const Bodies& bodies, Samples& at, Cell& cell) const;
  bool is_at_wall(const Vec3& p) const;
  bool is_hair_beside_body(const Vec3& middle, const Bodies& bodies) const;
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
  // For the first cell of a row, for the others, and for the last.
  const Shares* whole_shares(const ProjectionGrid& grid, LocalId k, LocalId r) const;
  static std::size_t which_of(Real place, LocalId count) { return place == 0 ? 0 : place == count - 1 ? 2 : 1; }
  // Position of a corner, given relative to that of the first owned cell, in cells from the corner of the box.
  std::array<Real, 3> from_box(const Vec3& corner) const {
    return {corner[0] + (first_ - 1), corner[1] + first_row_, corner[2]};
  }
  bool is_passage(std::size_t a, const Vec3& on_face, const Bodies& bodies) const;
  // The corner of cell (k, r, c), relative to that of the first owned cell.
  Vec3 corner_of(const ProjectionGrid& grid, LocalId k, LocalId r, Real c) const;
  void measure_motion(const ProjectionGrid& grid);
  void measure_excess(MPI_Comm comm, const ProjectionGrid& grid);
  void find_gaps(const ProjectionGrid& grid);
  std::vector<GlobalId> sums_of_bodies(MPI_Comm comm, const ProjectionGrid& grid) const;
  // Area of the solid surface in a cell, in faces.
  Real area(std::size_t at) const;
  void find_columns(const ProjectionGrid& grid);
  void find_cut_rows(const ProjectionGrid& grid);
  std::size_t row_index(LocalId k, LocalId r) const {
    return static_cast<std::size_t>(k) * (static_cast<std::size_t>(rows_) + 2) + static_cast<std::size_t>(r + 1);
  }

  const Obstacles& obstacles_;
  Bodies all_bodies_;
  PerThread<Candidates> candidates_;
  Box box_, inner_;  // inner_: slightly smaller
  std::array<int, 3> axis_{};
  Vec3 origin_ = Vec3::Zero(), size_ = origin_;  // by direction
  LocalId first_ = -1, planes_ = -1, first_row_ = -1, rows_ = 0, columns_ = 0;
  CellFrame frame_{};
  std::array<Real, 2> less_in_layers_{};   // reduction of a share in a cell beside, along each horizontal direction
  std::array<Shares, 27> whole_shares_{};  // of cells without solids: the first, the others and the last by direction
  std::array<std::array<SharesOfSamples, 3>, 3> sample_shares_{};  // the same of samples along each direction
  std::array<LocalId, 3> count_{};                                 // of cells of the box
  std::vector<Cell> all_;                                          // of all columns of the box
  std::unique_ptr<Shares[]> shares_;  // of cells near solids, by index; not written for others
  std::size_t shares_size_ = 0;
  std::vector<Cell> cells_;
  std::vector<std::array<float, 3>> moved_;
  std::vector<Zone> zones_;  // of moving solids, as last measured
  struct RangeNear {
    LocalId k, r;
    Range columns;
    Bodies bodies;  // solids that matter to it
    bool clear;     // whether these are thick and extend to no wall
  };
  std::vector<RangeNear> near_;  // the ranges in the zones that are being measured, ghost rows included
  // See cut_cell_parts.cpp.
  struct AtFace {
    std::size_t a, at;
    std::array<LocalId, 3> cell;  // of which it is the lower face
    Vec3 corner;                  // of this
    std::size_t stride;
  };
  struct SolidsNear {
    Bodies bodies, others;  // floating or not
  };
  SolidsNear solids_near(const Vec3& p, Real reach, const Bodies& near) const;
  void find_parts_of_face(const AtFace& face, const Bodies& near, std::vector<PartOfFace>& parts) const;
  void find_parts_of_cell(const Vec3& corner, std::size_t at, const Bodies& near, std::vector<PartOfCell>& parts) const;
  Real displacement(const PartOfFace& part) const;  // times its share
  Real area_of(std::size_t solid, std::size_t at) const;
  // Of a cell that is a gap, or a half of one: the part of its lower and upper face that this is between, and whether
  // these are its ends.
  struct Gap {
    std::size_t at;
    Real between;
    std::array<bool, 2> ends;
    bool operator<(const Gap& other) const { return at < other.at; }
  };
  const Gap* gap_at(std::size_t at) const {
    const auto gap = std::lower_bound(gaps_.begin(), gaps_.end(), Gap{at, 0, {}});
    return gap != gaps_.end() && gap->at == at ? &*gap : nullptr;
  }
  Real between(std::size_t at) const {
    const Gap* const gap = gap_at(at);
    return gap != nullptr ? gap->between : 0;
  }
  Gap find_gap(const ProjectionGrid& grid, LocalId k, LocalId r, Range cells) const;
  Vec3 off_other_end(const std::array<LocalId, 3>& cell, std::size_t at, bool upper) const;
  Cell filled_by(const Bodies& solids, const Vec3& corner) const;
  Real side_of_solid(const AtFace& face) const;
  Cell closed_by(const Bodies& solids, std::size_t a, const Vec3& corner, Real side) const;
  Real displacement_of_closed(const AtFace& face, const Bodies& near) const;
  std::array<std::size_t, 3> step_{};
  // For each solid: excess volume in cells per face of its surface, and the offset of the centroid of its part in a cut
  // cell, m.
  struct Excess {
    Real volume = 0;
    Vec3 middle = Vec3::Zero();
  };
  std::vector<Excess> excess_;
  SolidParts parts_;
  std::vector<Gap> gaps_;           // cells for which is_gap() holds, in ascending order
  std::vector<Range> cut_columns_;  // of all planes and rows, including those beside them
};

}  // namespace trevi

#include "projection/cut_cells-inl.hpp"
