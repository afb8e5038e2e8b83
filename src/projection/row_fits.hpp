// Vectorised loops over the cells of a row of the projection's grid: affine fits, the filter of noise, and the values
// of fits at faces. Their inputs are tents: sums over a cell and the 26 around it with the weights 1 and
// projection::tent along each axis, first across the planes, then across the rows of the plane, then along the row.
// Each cell is processed independently, by the same operations on every processor: the same bits on any ranks and
// threads. Cells beyond a wall contribute nothing. Where the box is periodic they are those at its other end, and ghost
// planes must have been received. Nothing is computed for groups of four cells for which the row has no memory because
// they hold no particles. Not collective, on this thread.
#pragma once

#include "projection/cell_fields.hpp"

namespace trevi {

/// Memory that tents keep from row to row while the rows of a plane come in their order: the sums across planes of the
/// surrounding rows, as far as they have been computed. There is one for each field, and for each part of a loop that
/// threads share.
class TentMemory {
 public:
  /// The sums of row r of plane k, for the groups of four cells for which they are known.
  struct Row {
    LocalId k = -1, r = -1;
    std::vector<char> is_known;
    std::vector<FourCells> values;
  };
  /// Four cells of a row, with the cells before and after them.
  struct alignas(64) SixCells {
    Real of[2 * FourCells::count];
  };
  /// Memory for this row with `numbers` for each cell; it keeps its content if it belongs to this row already.
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
  /// The sums of the row that is being processed.
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
  std::array<std::array<RowToRead, 3>, 3> rows;  // rows r − 1 to r + 1, each of planes k − 1 to k + 1
  LocalId k, r;
  std::array<std::size_t, 2> axis;  // the coordinate across planes, and across rows
  std::size_t begin, end, columns;  // `columns`: number of cells with memory
  bool repeats;                     // whether the box is periodic along the row
  TentMemory& memory;
  Real per_tent;  // 1 over the weight of a whole tent
  bool is_layer;  // whether there are no rows beside this one
};
/// A row and those of its cells that may hold something.
struct RowPlace {
  LocalId k, r;
  Range cells;
};
RowsAround rows_around(const ProjectionGrid& grid, const CellFields& field, RowPlace row, TentMemory& memory);

/// Fits of the moments around cells, and their spreads, where `more` is Σ |u|². A cell without particles has neither. A
/// spread occupies the first of the numbers::map values for which a cell has room. Of the frame only the size of cells
/// and the content of a full cell are used. `at_solid`: 1 for each cell that is cut or above a cut cell, otherwise 0;
/// null if there is none.
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

/// The result of the filter F for the particles of a cell, as a flow: Σ of w_c (fit_c u − u) over the surrounding
/// cells, over the weight of a whole tent.
void filter_motion(const RowsAround& maps, const RowToRead& moments, const RowToWrite& flow);

/// Fits of a flow with known spreads, times `factor`; `fit` may overwrite `spread`.
struct FlowFits {
  RowToRead spread;
  const Real* factor;
  RowToWrite fit;
};
void fit_flow(const RowsAround& flow, const FlowFits& out);

/// −F F u of particles: −(a2 + B2 y − weight2 F u), where `noise` has the fits of F u and `maps` those of u. The result
/// is a map whose weight is the share that a particle loses of its own motion.
void damp_noise(const RowsAround& noise, const RowsAround& maps, FourCells* damping);
/// Adds the sum of the surrounding maps to a map, over the weight of a whole tent.
void add_maps(const RowsAround& maps, FourCells* sum);
/// The mean of the surrounding maps, times `factor`.
void average_maps(const RowsAround& maps, const Real* factor, FourCells* mean);

/// A row of cells on one side of faces across the coordinate `axis`.
struct RowBeside {
  RowToRead moments, fit;
};
/// Two rows with faces between them, and the centroids of the open parts of the faces, in cells from the corner of the
/// cell above, by coordinate. For faces along a row both rows are the same, the face below a cell has the number of the
/// cell, and the row may be periodic.
struct FaceRow {
  RowBeside below, above;
  std::size_t axis;
  std::array<const Real*, 3> middle;
  bool along, repeats;
};
/// Displacements of the water at `count` faces, m (particles_to_grid.hpp). Nothing is written for faces without
/// particles around them.
void displace_faces(const FaceRow& faces, std::size_t count, Real* out);

}  // namespace trevi
