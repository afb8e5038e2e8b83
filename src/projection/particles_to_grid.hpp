// First stage of the projection: transfer from the particles to the grid. For each cell it finds the volume of water in
// it and the affine fit of its motion (affine.hpp), for each face the displacement that the prediction gives to the
// water there.
//
// The volume of a cell is that of the particles in and around it, each with a density that falls linearly to zero, a
// cell away along x and y and one spacing along z: a count of particles would not show a surface that tilts by less
// than a layer. Such a volume changes by the flow through the faces of a column, with the weights below, and so do
// levels. With other weights, water that moves as a whole pulls itself along the cells (the self-force of
// particle-in-cell methods, Birdsall & Langdon 1985, ch. 8). Under gravity particles are placed in the middle of their
// paths, less what gravity adds to these. Volumes and motion are thus known at the same time, and waves live in water
// that moves as a whole, by up to two thirds of a cell a step. The surface is lowered from there to where the paths
// begin (free_surface.hpp), so that waves keep their amplitude: with the predicted positions they would lose the
// fraction pi omega dt/2 of it in half a period. Without gravity particles are placed where their paths begin, at most
// max_path back.
//
// The displacement of a face is the mean over the particles of the two cells beside it, with weights that fall linearly
// with the distance from the face, each extrapolated to the centroid of the open part of the face,
//   u_f = Σ w_i (u_i + B (x_f − y_i)) / Σ w_i,
// with the slope B of the fit of its cell. It is exact for any affine motion, however the particles lie. Particles are
// evaluated at the midpoints of their paths, which gives the displacement at the middle of the step: second order in
// time. Between two cells without particles, one of which is wet, it is the mean of the surrounding fits, weighted by
// their particles.
//
// Sums are formed by the owner of a plane in the order of the particles: the same bits on any rank count. Collective:
// gather().
#pragma once

#include <cmath>
#include <vector>

#include "domain/halo.hpp"
#include "projection/cut_cells.hpp"
#include "projection/row_fits.hpp"

namespace trevi {

class ParticlesToGrid {
 public:
  /// `spacing` of the initial lattice, m.
  ParticlesToGrid(const ProjectionGrid& grid, Real spacing);

  /// Borrows memory for the present grid; gather() gives back the part that is needed only until its end.
  void borrow();
  /// To be called in this order: when only means() of the moments are still needed; when only fits are; when no fit is.
  void keep_means();
  void keep_fits();
  void give_back() { fit_.give_back(); }
  /// Computes all of this from the owned particles of `order`. `g_dt2`: the displacement by gravity, m, or 0. `cuts`
  /// may be null.
  void gather(const CellOrder& order, Halo& halo, const Motion& motion, Real g_dt2, const CutCells* cuts);
  /// After gather(), when cells have been classified: finds the displacements of faces without particles on either side
  /// that are beside a wet cell. Others are not used.
  template <class IsWet>
  void find_empty_faces(const CutCells* cuts, const IsWet& is_wet);

  /// The particles that were in a cell when `order` was made, in the order of storage.
  CellParticles particles_of(const CellOrder& order, LocalId k, LocalId r, LocalId c) const;
  /// Calls use(c, particles) for the cells of a row that hold any, in their order.
  template <class Use>
  void for_each_cell(const CellOrder& order, LocalId k, LocalId r, const Use& use) const {
    constexpr LocalId four = FourCells::count;
    const LocalId columns = grid_.columns(k, r), row = r * order.grid().columns(), ghosts = order.low_ghosts();
    CellParticles cell{0, 0, grid_.place_of(k, r, 0)};
    for (LocalId first = 0; first < columns; first += four) {
      if (!grid_.storage().has(k, r, static_cast<std::size_t>(first / four))) continue;
      LocalId begin = order.start(k, row + first);
      for (LocalId c = first; c < std::min(first + four, columns); ++c) {
        const LocalId end = order.start(k, row + c + 1);
        if (begin < end) {
          cell.begin = static_cast<std::size_t>(begin - ghosts);
          cell.end = static_cast<std::size_t>(end - ghosts);
          grid_.set_column(cell.place, c);
          use(c, static_cast<const CellParticles&>(cell));
        }
        begin = end;
      }
    }
  }

  const CellFrame& frame() const { return frame_; }
  /// Height of still water above a level, in cells, if its particles have `volume` above this level. Because particles
  /// extend beyond the water, there is some volume even if the water ends below the level.
  Real height_of(Real volume) const {
    const Real edge = frame_.reach[grid_.axis(2)];
    return volume < edge / 2 ? std::sqrt(2 * edge * volume) - edge / 2 : volume;
  }
  /// The largest fill of a cell by particles on one side of it only, in cells; up to this, a cell without particles is
  /// air.
  Real told_from_one_side() const { return told_from_one_side_; }
  /// Whether the cell, in an owned plane or row or in one beside it, holds particles.
  bool holds_any(LocalId k, LocalId r, LocalId c) const {
    const Range cells = filled(k, r);
    return c >= cells.begin && c < cells.end && sums_.number(0, k, r, c) > 0;
  }
  /// Volumes of the water in the cells of an owned row, in cells.
  void find_volumes(LocalId k, LocalId r, std::span<Real> volumes) const;
  /// For owned cells and ghost planes: the moments of the particles of a cell, with `more` = Σ |u|², m², and the fits
  /// of the surrounding motion, whose weight is 0 in a cell without particles.
  const CellFields& all_moments() const { return sums_; }
  const CellFields& fits() const { return fit_; }
  /// The spreads of the fits of owned cells with particles: the first numbers::spread values of those that a map has.
  const CellFields& spreads() const { return spread_; }
  /// The memory of the spreads, which is overwritten when noise is fitted.
  CellFields& free_spreads() { return spread_; }
  /// The moments of one cell.
  Moments moments(std::size_t at) const { return cell_at<Moments>(sums_, at); }
  /// The number of particles of a cell, and their Σ y and Σ u, m.
  struct Means {
    Real n = 0;
    ByAxis y{}, u{};
  };
  const CellFields& all_means() const { return means_; }
  Means means(std::size_t at) const { return cell_at<Means>(means_, at); }
  AffineMap fit(std::size_t at) const { return cell_at<AffineMap>(fit_, at); }
  /// The columns of a row from the lowest to the highest cell that holds particles.
  Range filled(LocalId k, LocalId r) const { return filled_[row_index(k, r)]; }
  /// Displacement of the water at face (a, at), m.
  Real displacement(std::size_t a, std::size_t at) const { return displacement_[a][at]; }

  /// To be called when volumes, or displacements, are no longer needed.
  void give_back_volumes() { volumes_.give_back(); }
  void give_back_displacements() {
    for (Borrowed<Real>& u : displacement_) u.give_back();
  }

  std::size_t bytes() const;

 private:
  // The volumes that the particles of the plane add below a cell, to the cell itself and above it. In whole rows they
  // follow the moments of the cell's particles.
  RowToWrite volumes_of(LocalId k, LocalId r) {
    return grid_.storage().is_exchanged(k, r) ? sums_.row(k, r).from_number(numbers::moments) : volumes_.row(k, r);
  }
  RowToRead volumes_of(LocalId k, LocalId r) const { return const_cast<ParticlesToGrid*>(this)->volumes_of(k, r); }
  void sum_planes(const CellOrder& order, Range planes, const Motion& motion, const CutCells* cuts);
  void sum_rows(const CellOrder& order, LocalId k, Range rows, const Motion& motion, const CutCells* cuts);
  // The rows of a plane to which the cells of row r add volume: those in [rows), counted from the row before r.
  struct RowsToAdd {
    std::array<RowToWrite, 3> volumes;
    std::array<LocalId, 3> columns;
    Range rows;
  };
  RowsToAdd rows_to_add(LocalId k, LocalId r, Range own);
  void add_volume(const RowsToAdd& to, LocalId c, const CellSums& sums) const;
  // The volumes that a cell of a row adds to the cells of the adjacent row: by plane, then along the row.
  using VolumesBeside = std::array<Real, 9>;
  void exchange_volumes(const CellOrder& order, Halo& halo, const Motion& motion, const CutCells* cuts);
  void find_volumes_beside(const CellOrder& order, const Motion& motion, const CutCells* cuts, LocalId k,
                           std::size_t side);
  void add_ghost_row(LocalId k, std::size_t side);
  // The sums of the cells of a row that were found for the neighbouring ranks; null for other rows.
  const CellSums* known_sums(LocalId k, LocalId r) const {
    if (!grid_.rows_are_cut() || (r > 0 && r + 1 < grid_.rows())) return nullptr;
    return &ends_[r == 0 ? 0 : 1][beside_index(k, 0)];
  }
  std::size_t beside_index(LocalId k, LocalId c) const {
    return static_cast<std::size_t>(k) * static_cast<std::size_t>(grid_.columns()) + static_cast<std::size_t>(c);
  }
  std::size_t row_index(LocalId k, LocalId r) const {
    return static_cast<std::size_t>(k) * (static_cast<std::size_t>(grid_.rows()) + 2) + static_cast<std::size_t>(r + 1);
  }
  template <class T>
  T cell_at(const CellFields& field, std::size_t at) const {
    const std::size_t row = at / grid_.step(1), rows = grid_.step(0) / grid_.step(1);
    const auto k = static_cast<LocalId>(row / rows), r = static_cast<LocalId>(row % rows) - 1;
    return field.cell<T>(k, grid_.row_beside(r), static_cast<LocalId>(at % grid_.step(1)) - 1);
  }
  void find_filled(LocalId k, LocalId r);
  const Real* cells_at_solids(const CutCells& cuts, LocalId k, LocalId r) const;
  void fit_row(TentMemory& memory, const CutCells* cuts, LocalId k, LocalId r);
  void find_faces(std::size_t a, LocalId k, LocalId r, const CutCells* cuts);
  // For cells beside obstacles, and for faces without particles on either side; see particles_to_grid_cut.cpp.
  using CellNumbers = std::array<LocalId, 3>;  // of plane, row and column
  struct FittedMean {
    Real sum = 0, weight = 0;
  };
  CellSums sums_of(const CellNumbers& at, const CellParticles& cell, const Motion& motion, const CutCells* near) const;
  struct EmptyFace {
    std::size_t a, at;
    CellNumbers above, below;
  };
  template <class IsWet>
  void find_empty_faces(std::size_t a, LocalId k, LocalId r, const CutCells* cuts, const IsWet& is_wet);
  void displace_empty_face(const EmptyFace& face, const CutCells* cuts);
  Range cells_without(std::size_t a, LocalId k, LocalId r) const;
  bool exists(CellNumbers& cell) const;
  bool holds_any(const CellNumbers& cell) const { return holds_any(cell[0], cell[1], cell[2]); }
  void add_fits_around(std::size_t a, const CellNumbers& cell, const ByAxis& place, FittedMean& mean) const;

  const ProjectionGrid& grid_;
  CellFrame frame_;
  Real told_from_one_side_;
  CellFields sums_{numbers::moments, numbers::volumes}, volumes_{numbers::volumes}, spread_{numbers::map},
      fit_{numbers::map}, means_{sizeof(Means) / sizeof(Real)};
  std::vector<Range> filled_;         // filled(k, r)
  std::vector<LocalId> first_empty_;  // of the cells of a row, as above
  std::array<Borrowed<Real>, 3> displacement_;
  // Where rows are cut: given by the first and the last owned row, and received from the rows before and after these.
  std::array<std::vector<VolumesBeside>, 2> given_, received_;
  std::array<std::vector<CellSums>, 2> ends_;  // of the first and the last owned row
};

template <class IsWet>
void ParticlesToGrid::find_empty_faces(const CutCells* cuts, const IsWet& is_wet) {
  const LocalId planes = grid_.planes();
  for_each_row(grid_.rows_of({1, planes + 2}), [&](LocalId k, LocalId r) {
    find_empty_faces(0, k, r, cuts, is_wet);
    if (k > planes) return;
    if (!grid_.is_layer()) find_empty_faces(1, k, r, cuts, is_wet);
    find_empty_faces(2, k, r, cuts, is_wet);
    if (grid_.rows_are_cut() && r + 1 == grid_.rows()) find_empty_faces(1, k, r + 1, cuts, is_wet);
  });
  grid_.repeat(displacement_[1]);
  if (grid_.repeats()[2]) grid_.repeat(displacement_[2]);
}

template <class IsWet>
void ParticlesToGrid::find_empty_faces(std::size_t a, LocalId k, LocalId r, const CutCells* cuts, const IsWet& is_wet) {
  const Range cells = cells_without(a, k, r);
  for (LocalId c = cells.begin; c < cells.end; ++c) {
    const std::size_t at = grid_.index(k, r, c);
    if (!is_wet(at) && !is_wet(at - grid_.step(a))) continue;
    if (holds_any(k, r, c) || grid_.is_wall(a, k, r, c) || (cuts != nullptr && cuts->face(a, at) == 0)) continue;
    CellNumbers above{k, r, c}, below = above;
    --below[a];
    if (exists(below) && !holds_any(below)) displace_empty_face({a, at, above, below}, cuts);
  }
}

}  // namespace trevi
