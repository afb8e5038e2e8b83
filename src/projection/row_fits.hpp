// The vectorised loops over the cells of a row of the projection's grid: affine fits, the filter of noise, and what a
// fit says at faces. Their input are tents, sums over a cell and the 26 around it with the weights 1 and
// projection::tent along each axis: first across the planes, then across the rows of the plane, then along the row.
// Each cell is worked on by itself, in the same operations on every processor: the same bits on any ranks and threads.
// Of cells beyond a wall there is nothing; where the box repeats they are those at its other end, and ghost planes must
// have come. Of fours of cells for which the row has no memory, as they hold no particles, nothing is found. Not
// collective, on this thread.
#pragma once

#include "projection/cell_fields.hpp"

namespace trevi {

/// What tents keep from row to row, as the rows of a plane come in their order: the sums across the planes of the rows
/// around, as far as they have been asked for. One for each field, and for each part of a loop of threads.
class TentMemory {
 public:
  /// Of row r of plane k, of the fours that are known.
  struct Row {
    LocalId k = -1, r = -1;
    std::vector<char> is_known;
    std::vector<FourCells> values;
  };
  /// Four cells of a row, with those before and after them.
  struct alignas(64) SixCells {
    Real of[2 * FourCells::count];
  };
  /// Memory for that row, or what it holds already, with as many `numbers` of each cell.
  Row& row(LocalId k, LocalId r, std::size_t numbers, std::size_t columns) {
    Row& row = rows_[static_cast<std::size_t>((r + 3) % 3)];
    if (row.k != k || row.r != r) {
      row.k = k;
      row.r = r;
      row.is_known.assign(fours(columns), 0);
    }
    row.values.resize(fours(columns) * numbers);
    return row;
  }
  /// Of the row that is worked on.
  std::vector<SixCells>& sums(std::size_t numbers, std::size_t columns) {
    sums_.resize(fours(columns) * numbers);
    return sums_;
  }

 private:
  static std::size_t fours(std::size_t columns) { return (columns + FourCells::count - 1) / FourCells::count; }
  std::array<Row, 3> rows_;
  std::vector<SixCells> sums_;
};

/// The cells [begin, end) of row (k, r), and the rows around it.
struct RowsAround {
  std::array<std::array<RowToRead, 3>, 3> rows;  // r − 1 to r + 1, of planes k − 1 to k + 1 each
  LocalId k, r;
  std::array<std::size_t, 2> axis;  // the coordinate across planes, and across rows
  std::size_t begin, end, columns;  // of `columns` there is memory
  bool repeats;                     // along the row
  TentMemory& memory;
  Real per_tent;  // 1 over the weight of a whole tent
  bool is_layer;  // beside this row there are no others
};
/// Cells of a row; none others of it hold anything.
struct RowPlace {
  LocalId k, r;
  Range cells;
};
RowsAround rows_around(const ProjectionGrid& grid, const CellFields& field, RowPlace row, TentMemory& memory);

/// Fits of the moments around cells, and their spread, where `more` is Σ |u|². A cell without particles has neither.
/// Of the numbers::map that a cell has room for a spread takes the first. Of the frame the size of cells is used, and
/// what a full cell holds. `at_solid`: 1 for each cell that is cut, or stands on one that is, else 0; null where none
/// is.
struct MotionFits {
  RowToWrite fit, spread;
  const CellFrame& frame;
  const Real* at_solid;
};
void fit_motion(const RowsAround& moments, const MotionFits& out);

/// Fits of the moments around cells, times `factor`, and the mean of `more`.
struct ShiftFits {
  RowToWrite fit;
  const Real* factor;
  Real* mean;
};
void fit_shifts(const RowsAround& moments, const ShiftFits& out);

/// The flow that the filter F leaves of the particles of a cell: Σ of w_c (fit_c u − u) over the cells around, per
/// weight of a whole tent.
void filter_motion(const RowsAround& maps, const RowToRead& moments, const RowToWrite& flow);

/// Fits of a flow at places that are known, times `factor`; `fit` may be in the place of `spread`.
struct FlowFits {
  RowToRead spread;
  const Real* factor;
  RowToWrite fit;
};
void fit_flow(const RowsAround& flow, const FlowFits& out);

/// −F F u of particles: −(a2 + B2 y − weight2 F u), where `noise` has the fits of F u and `maps` those of u; as a map,
/// of which the weight is what a particle loses of its own motion.
void damp_noise(const RowsAround& noise, const RowsAround& maps, FourCells* damping);
/// Adds the sum of maps around to a map, per weight of a whole tent.
void add_maps(const RowsAround& maps, FourCells* sum);
/// The mean of the maps around, times `factor`.
void average_maps(const RowsAround& maps, const Real* factor, FourCells* mean);

/// A row of cells at one side of faces across the coordinate `axis`.
struct RowBeside {
  RowToRead moments, fit;
};
/// Two rows with faces between them, and the middles of the faces' open parts, in cells from the corner of the cell
/// above, by coordinate. Along a row, where both are the same one, the face below a cell has its number; the whole row
/// may repeat.
struct FaceRow {
  RowBeside below, above;
  std::size_t axis;
  std::array<const Real*, 3> middle;
  bool along, repeats;
};
/// Displacements of the water at `count` faces, m (particles_to_grid.hpp); of faces without particles around nothing is
/// written.
void displace_faces(const FaceRow& faces, std::size_t count, Real* out);

}  // namespace trevi
