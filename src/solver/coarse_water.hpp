// What the coarse grid knows of the water: which cells hold it, where its surface is, and the mean displacement that
// the prediction gives to the particles at each cell face.
//
// The fill of a cell is the volume in it, where each particle is a cube with an edge of one spacing: a count of
// particles would not show a surface that tilts by less than a layer. The cubes are placed at the positions at the
// start of the step. Pressure then acts on the surface as it was before the motion that it causes, as in leapfrog, and
// a wave keeps its amplitude; with the predicted positions it would lose a share pi omega dt/2 of it in half a period.
// The surface of a column that stands on the floor lies where the volume of the whole column reaches: noise in the fill
// of lower cells would otherwise count as missing weight, and waves would be 2 % slow.
//
// The displacement of a face is the mean over the particles of the two cells beside it, with weights that fall linearly
// with the distance from the face. As the particles may lie on one side only, it is extrapolated to the face by linear
// regression. Sums are formed by the owner of a plane in the order of the particles: the same bits on any rank count.
// Collective.
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "domain/halo.hpp"
#include "solver/coarse_grid.hpp"
#include "solver/coarse_particles.hpp"
#include "solver/coarse_solids.hpp"
#include "solver/water_reach.hpp"

namespace trevi {

class CoarseWater {
 public:
  /// `spacing` of the start lattice, m: the edge of a particle's cube. `obstacles` may be null.
  CoarseWater(MPI_Comm comm, const CellGrid& grid, const Box& box, Real spacing, const Obstacles* obstacles = nullptr);

  /// Computes all of this from the owned particles of `order`, which the prediction moves so.
  void measure(const CellOrder& order, Halo& halo, const Motion& motion);

  const CoarseGrid& grid() const { return grid_; }
  const Box& box() const { return box_; }
  /// Null where there are no obstacles.
  const CoarseSolids* solids() const { return solids_ ? &*solids_ : nullptr; }
  /// Share of face (a, at) that no solid closes.
  Real face(std::size_t a, std::size_t at) const { return solids_ ? solids_->face(a, at) : 1; }
  /// Whether the cell is solid; it is wet where the water below it has no surface under it.
  bool is_solid(std::size_t at) const { return solids_ && solids_->open(at) == 0; }
  /// Whether a solid closes a part of the cell.
  bool is_cut(std::size_t at) const { return solids_ && solids_->open(at) > 0 && solids_->open(at) < 1; }
  /// Share of the cell that is not solid; its fill is a share of that.
  Real open(std::size_t at) const { return solids_ ? solids_->open(at) : 1; }
  /// The largest number of cells directly above one another that may hold water, over all ranks.
  int depth() const { return reach_.depth(); }
  Real fill(std::size_t at) const { return fill_[at]; }
  bool is_wet(std::size_t at) const { return wet_[at] != 0; }
  /// A wet cell with a dry one above it. The few particles in that dry cell follow the wet one.
  bool is_top(std::size_t at) const { return is_wet(at) && !is_wet(at + 1) && !is_solid(at); }
  /// Height of the water above the lower face of a wet cell, in cells; 1 in all but top cells.
  Real height(std::size_t at) const { return is_top(at) ? height_[at] : 1; }
  /// Height of the surface above the middle of a top cell, in cells, at least `least_height`.
  Real above_middle(std::size_t at) const { return std::max(height_[at] - 0.5, least_height); }
  /// Mean displacement through face (a, at), m.
  Real displacement(std::size_t a, std::size_t at) const { return displacement_[a][at]; }

  /// For the loops over particles. A particle is placed relative to the surface by its position at the start of the
  /// step, but in each direction at most a quarter of a cell from p, where it is predicted.
  const CellFrame& frame() const { return frame_; }

  std::size_t bytes() const;

 private:
  static constexpr Real least_height = 0.05;
  // Weighted sums over the particles beside a face.
  struct Moments {
    Real weight = 0, offset = 0, offset2 = 0, value = 0, offset_value = 0;
    Moments operator+(const Moments& other) const;
    void operator+=(const Moments& other) { *this = *this + other; }
    Real at_face() const;
  };
  // What the particles of a plane add: their volume to the plane below, to their own and to the plane above, and their
  // displacements to the faces on either side of the plane.
  struct PlaneSums {
    std::array<Real, 3> volume{};
    Moments low, high;
  };
  void resize(LocalId planes);
  void clear_row(LocalId k, LocalId r);
  // Of one plane, for the faces between its rows and between its columns.
  struct FaceSums {
    std::vector<Moments> row, column;
  };
  // The particles of a cell as seen from its lower face, and from its upper one, in direction a.
  Moments low(const CellSums& sums, Real count, std::size_t a) const;
  Moments high(const CellSums& sums, std::size_t a) const;
  void sum_plane(const CellOrder& order, LocalId k, const Motion& motion, FaceSums& faces);
  // Cell (r, c) of plane k; r may be one before the first or beyond the last row.
  struct Place {
    LocalId k, r, c;
  };
  void sum_row(const CellOrder& order, const Place& row, const Motion& motion, FaceSums& faces);
  void add_cell(const Place& place, Real count, const CellSums& sums, FaceSums& faces);
  void add_volume(const Place& place, const CellSums& sums);
  void finish_faces(LocalId k, LocalId r);
  void find_surface(Halo& halo);
  void find_tops(LocalId k, LocalId r);
  void close_ceiling(LocalId k, LocalId r);
  bool is_full_enough(std::size_t at, LocalId c, bool on_floor) const;
  // Among obstacles; see coarse_water_solids.cpp.
  void find_surface_among_solids(Halo& halo);
  void fill_open_parts();
  void level_small_cells(Halo& halo);
  bool is_small(std::size_t at) const;
  template <class Visit>
  void for_widest(const Place& place, const Visit& visit) const;

  MPI_Comm comm_;
  Box box_;
  CoarseGrid grid_;
  WaterReach reach_;
  std::optional<CoarseSolids> solids_;
  CellFrame frame_;
  std::vector<PlaneSums> sums_;
  std::vector<Real> fill_, height_;
  std::vector<char> wet_;
  std::vector<Real> level_;   // of small cells that follow others: the next height_
  std::vector<char> joined_;  // the next wet_
  std::array<std::vector<Real>, 3> displacement_;
};

}  // namespace trevi
