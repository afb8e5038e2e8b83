// Means of the water over the cells of the coarse grid, which are those of the projection: boxes about one kernel
// radius wide that fill the domain evenly. Sums are integers, of velocities in units of 2^-30 m/s and densities in
// units of 2^-20 kg/m³, so no bit depends on the ranks or on the order of the particles; velocities count up to 10^5
// m/s. Each rank sums its own particles by cells and sends the sums to the rank responsible for the cell, in one
// all-to-all exchange: no rank holds more than its share of the grid. Collective: cell_means().
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <vector>

#include "io/hdf5/hdf5_rows.hpp"
#include "particles/cell_grid.hpp"
#include "trevi/box.hpp"
#include "trevi/observer.hpp"
#include "trevi/session.hpp"

namespace trevi {

/// The cells that meet a box, or all cells of the domain, each a point of a regular grid, numbered with x fastest. The
/// point is the centre of its cell. Along a direction with a single cell it has two points, the centres of its faces,
/// because the reader of VTK 9.1 cannot read flat images.
class CoarseCells {
 public:
  /// `grid`: planes along x, of the domain that begins at `domain.min`.
  CoarseCells(const Box& domain, const CellGrid& grid, const std::optional<Box>& box);

  const std::array<std::int64_t, 3>& count() const { return count_; }  ///< of points along x, y, z
  std::int64_t total() const { return count_[0] * count_[1] * count_[2]; }
  const Vec3& origin() const { return origin_; }  ///< the first point, m
  const Vec3& size() const { return size_; }      ///< of a cell, and from point to point, m
  /// The first point of its cell; -1 outside of the box.
  std::int64_t point_of(const Vec3& p) const;
  /// From a point to the second one of its cell, along directions with a single cell.
  std::vector<std::int64_t> steps_to_second() const;

 private:
  CellGrid grid_;
  std::array<std::int64_t, 3> first_{}, cells_{}, count_{};
  Vec3 origin_, size_;
};

/// One row for each point that this rank is responsible for; 0 where there is no water.
struct CellMeans {
  RowSlice slice;
  std::vector<float> fraction;                 ///< of the cell that is water: particles · s³ over its volume
  std::vector<std::array<float, 3>> velocity;  ///< m/s
  std::vector<float> density;                  ///< kg/m³, of the kernel sums; 0 where the frame has none
};

/// `particle_volume`: s³.
CellMeans cell_means(MPI_Comm comm, const CoarseCells& cells, Real particle_volume, const Frame& frame);

}  // namespace trevi
