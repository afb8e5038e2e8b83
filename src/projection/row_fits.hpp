// The vectorised loops over the cells of a row of the projection's grid: affine fits, the filter of noise, and what a
// fit says at faces. Their input are tents, sums over a cell and the 26 around it with the weights 1 and
// projection::tent along each axis: first across the planes, then across the rows of the plane, then along the row.
// Each cell is worked on by itself, in the same operations on every processor: the same bits on any ranks and threads.
// Of cells beyond a wall there is nothing; where the box repeats they are those at its other end, and ghost planes must
// have come. Not collective, on this thread.
#pragma once

#include "projection/cell_fields.hpp"

namespace trevi {

/// A row of numbers of cells: number q of cell c is first[q * width + c].
struct CellRow {
  Real* first;
  std::size_t width;
};
struct ConstCellRow {
  const Real* first;
  std::size_t width;
};
inline CellRow row_of(CellFields& field, LocalId k, LocalId r) { return {field.row(k, r), field.width()}; }
inline ConstCellRow row_of(const CellFields& field, LocalId k, LocalId r) { return {field.row(k, r), field.width()}; }

/// The lowest `columns` cells of a row, and the rows around it.
struct RowsAround {
  std::array<std::array<const Real*, 3>, 3> first;  // of rows r − 1 to r + 1, of planes k − 1 to k + 1 each
  std::size_t width;
  std::array<std::size_t, 2> axis;  // the coordinate across planes, and across rows
  std::size_t columns, filled;      // in `filled` cells there may be something
  bool repeats;                     // along the row
};
RowsAround rows_around(const ProjectionGrid& grid, const CellFields& field, LocalId k, LocalId r, LocalId columns);

/// Fits of the moments around cells, and their spread; `rest2`: the variance of the motion less what the fits explain of
/// it, m², where `more` is Σ |u|². A cell without particles has neither.
struct MotionFits {
  CellRow fit, spread;
  Real* rest2;
};
void fit_motion(const RowsAround& moments, const MotionFits& out);

/// Fits of the moments around cells, times `factor`, and the mean of `more`.
struct ShiftFits {
  CellRow fit;
  const Real* factor;
  Real* mean;
};
void fit_shifts(const RowsAround& moments, const ShiftFits& out);

/// The flow that the filter F leaves of the particles of a cell: Σ of w_c (fit_c u − u) over the cells around, per
/// weight of a whole tent.
void filter_motion(const RowsAround& maps, const ConstCellRow& moments, const CellRow& flow);

/// Fits of a flow at places that are known, times `factor`.
struct FlowFits {
  ConstCellRow spread;
  const Real* factor;
  CellRow fit;
};
void fit_flow(const RowsAround& flow, const FlowFits& out);

/// −F F u of particles: −(a2 + B2 y − weight2 F u), where `noise` has the fits of F u and `maps` those of u; as a map,
/// of which the weight is what a particle loses of its own motion.
void damp_noise(const RowsAround& noise, const RowsAround& maps, const CellRow& damping);
/// Adds the sum of maps around to a map, per weight of a whole tent.
void add_maps(const RowsAround& maps, const CellRow& sum);
/// The mean of the maps around, times `factor`.
void average_maps(const RowsAround& maps, const Real* factor, const CellRow& mean);

/// Two rows of cells with faces between them across the coordinate `axis`, and the middles of the faces' open parts, in
/// cells from the corner of the cell above, by coordinate.
struct FaceRow {
  ConstCellRow moments_below, moments_above, fit_below, fit_above;
  std::size_t axis;
  std::array<const Real*, 3> middle;
};
/// Displacements of the water at `count` faces, m (particles_to_grid.hpp).
void displace_faces(const FaceRow& faces, std::size_t count, Real* out);

}  // namespace trevi
