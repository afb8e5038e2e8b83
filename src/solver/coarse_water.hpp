// What the coarse grid knows of the water: which cells hold it, where its surface stands, and how far the particles of
// each face mean to go in this step.
//
// The fill of a cell is the volume in it, each particle a cube of one spacing: counts would not notice a surface that
// tilts by less than a layer. The cubes lie where the step began. Pressure then works on the surface before the motion
// that it causes, as in leapfrog, and a wave keeps its amplitude; with the surface after the prediction it would lose
// pi omega dt/2 of it in half a period. A column that stands on the floor has its surface where its whole volume
// reaches: noise in the fill of the cells below would otherwise take weight from it, and waves would be 2 % slow.
//
// The displacement of a face is the mean over the particles of the two cells beside it, weighted linearly in the
// distance and, as particles may lie on one side only, moved to the face along their own regression line.
// Sums are formed by the owner of a plane in the order of the particles: the same bits on any rank count. Collective.
#pragma once

#include <span>
#include <vector>

#include "domain/halo.hpp"
#include "solver/coarse_grid.hpp"

namespace trevi {

class CoarseWater {
 public:
  /// `spacing` of the start lattice, m: the edge of a particle's cube.
  CoarseWater(MPI_Comm comm, const CellGrid& grid, const Box& box, Real spacing);

  /// Looks at the owned particles of `order`, which go from x to p.
  void measure(const CellOrder& order, Halo& halo, std::span<const Vec3> x, std::span<const Vec3> p);

  const CoarseGrid& grid() const { return grid_; }
  /// The most wet cells above one another, over all ranks.
  int depth() const { return depth_; }
  Real fill(std::size_t at) const { return fill_[at]; }
  bool is_wet(std::size_t at) const { return wet_[at] != 0; }
  /// A wet cell below a dry one. What little is in the dry one follows the wet one.
  bool is_top(std::size_t at) const { return is_wet(at) && !is_wet(at + 1); }
  /// Height of the water above the lower face of a top cell, in cells, at least to `least_height` above its middle.
  Real height(std::size_t at) const { return is_top(at) ? height_[at] : 1; }
  /// Height of the surface above the middle of a top cell, in cells.
  Real above_middle(std::size_t at) const { return std::max(height_[at] - 0.5, least_height); }
  /// Mean displacement through face (a, at), m.
  Real displacement(std::size_t a, std::size_t at) const { return displacement_[a][at]; }

  /// Where the particle is as far as the surface is concerned: where the step began, or a quarter of a cell from p
  /// where it came further. In units of cells.
  Vec3 surface_position(const Vec3& x, const Vec3& p) const;

  std::size_t bytes() const;

 private:
  static constexpr Real least_height = 0.05;
  // Weighted sums over the particles beside a face.
  struct Moments {
    Real weight = 0, offset = 0, offset2 = 0, value = 0, offset_value = 0;
    void add(Real w, Real distance, Real u);
    Moments operator+(const Moments& other) const;
    Real at_face() const;
  };
  // What the particles of a plane add to cells of the plane below, of their own and above; to the faces on either side.
  struct PlaneSums {
    std::array<Real, 3> volume{};
    Moments low, high;
  };
  // The particles [begin, end) of cell (k, r, c).
  struct CellParticles {
    LocalId k, r, c;
    std::size_t begin, end;
  };
  void look_for_water(const CellOrder& order);
  void sum_plane(const CellOrder& order, LocalId k, std::span<const Vec3> x, std::span<const Vec3> p);
  void sum_cell(const CellParticles& cell, std::span<const Vec3> x, std::span<const Vec3> p);
  void add_volume(LocalId k, const Vec3& mid, const Vec3& own);
  void finish_faces(LocalId k);
  void find_surface();
  void find_tops(LocalId k, LocalId r);

  MPI_Comm comm_;
  CoarseGrid grid_;
  Vec3 half_, per_cube_;     // half a spacing in units of cells; cubes in a cell's length
  Real per_full_;            // of a particle's volume, in a cell's
  LocalId least_particles_;  // of a cell that may hold water
  int depth_ = 0;
  std::vector<PlaneSums> sums_;
  std::vector<Moments> row_faces_, column_faces_;  // of the plane at work
  std::vector<Real> fill_, height_;
  std::vector<char> wet_;
  std::array<std::vector<Real>, 3> displacement_;
};

}  // namespace trevi
