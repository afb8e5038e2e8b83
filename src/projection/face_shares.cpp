#include "projection/face_shares.hpp"

#include <algorithm>
#include <span>

#include "projection/parameters.hpp"

namespace trevi {

using namespace projection;

FaceShares::FaceShares(const FreeSurface& surface, Real spacing)
    : surface_(surface), full_particles_(surface.grid().size().prod() / (spacing * spacing * spacing)) {}

void FaceShares::give_back() {
  for (Borrowed<Real>& of : share_) of.give_back();
}

void FaceShares::find(const Pressure& pressure) {
  const ProjectionGrid& grid = surface_.grid();
  for (Borrowed<Real>* of : {&full_, &share_[0], &share_[1], &share_[2]}) {
    *of = grid.scratch().borrow_briefly<Real>(grid.cells());
    of->fill(0);
  }
  find_full();
  const LocalId planes = grid.planes(), rows = grid.rows();
  const std::array<Around, 3> around{around_face(0), around_face(1), around_face(2)};
  const Real* const phi = pressure.all_phi();
  for_each_row(grid.rows_of({1, planes + 2}), [&](LocalId k, LocalId r) {
    find_row(phi, around[0], {0, k, r});
    if (k > planes) return;
    find_row(phi, around[2], {2, k, r});
    if (grid.is_layer()) return;  // nothing moves across a layer
    find_row(phi, around[1], {1, k, r});
    if (grid.rows_are_cut() && r + 1 == rows && grid.has_row(rows)) find_row(phi, around[1], {1, k, rows});
  });
  full_.give_back();
  grid.repeat(share_[1]);
  if (grid.repeats()[2]) grid.repeat(share_[2]);
}

void FaceShares::add_to(CellDisplacement& by, std::size_t at) const {
  const ProjectionGrid& grid = surface_.grid();
  for (std::size_t a = 0; a < 3; ++a) {
    const std::size_t b = grid.axis(a);
    const Real low = share_[a][at], high = share_[a][at + grid.step(a)];
    by.offset[b] += low;
    by.slope[b][b] += high - low;
  }
}

bool FaceShares::is_full(std::size_t at) const {
  return surface_.is_wet(at) && !surface_.is_top(at) && surface_.open(at) == 1 && surface_.mass(at) == 1;
}

// Ghost cells included.
void FaceShares::find_full() {
  const ProjectionGrid& grid = surface_.grid();
  for_each_row(grid.rows_and_ghosts_of({0, grid.planes() + 2}), [&](LocalId k, LocalId r) {
    if (!grid.has_row(r)) return;
    for (LocalId c = 0; c < grid.columns(k, r); ++c) {
      const std::size_t at = grid.index(k, r, c);
      full_[at] = is_full(at) ? 1 : 0;
    }
  });
  grid.repeat(full_);
}

// Weights 1, 2, 1 along both axes of the plane of the face, or in a layer along its single axis.
FaceShares::Around FaceShares::around_face(std::size_t a) const {
  const ProjectionGrid& grid = surface_.grid();
  const auto plane = static_cast<std::ptrdiff_t>(grid.step(0)), row = static_cast<std::ptrdiff_t>(grid.step(1));
  const std::ptrdiff_t planes = a != 0 ? 1 : 0, rows = a != 1 && !grid.is_layer() ? 1 : 0;
  const auto weight = [](std::ptrdiff_t off, std::ptrdiff_t most) { return off == 0 && most > 0 ? 2.0 : 1.0; };
  Around around{{}, 0, a != 2};
  for (std::ptrdiff_t i = -planes; i <= planes; ++i) {
    for (std::ptrdiff_t j = -rows; j <= rows; ++j)
      around.rows[around.count++] = {i * plane + j * row, weight(i, planes) * weight(j, rows)};
  }
  return around;
}

// If the plane of the faces does not contain the direction of the row, the ring cell at either end is left out.
void FaceShares::sum_rows(const Real* phi, const Around& around, std::size_t a, std::size_t floor, Sums& sums) const {
  const std::size_t below = surface_.grid().step(a), left_out = around.has_columns ? 0 : 1;
  const Real* const full = full_.data();
  std::fill(sums.faces.begin(), sums.faces.end(), 0.0);
  std::fill(sums.rise.begin(), sums.rise.end(), 0.0);
  for (const RowAround& row : std::span(around.rows).first(around.count)) {
    const std::size_t first = static_cast<std::size_t>(static_cast<std::ptrdiff_t>(floor) + row.offset) - 1;
    for (std::size_t c = left_out; c < sums.faces.size() - left_out; ++c) {
      const std::size_t at = first + c;
      const Real weight = row.weight * full[at] * full[at - below];
      sums.faces[c] += weight;
      sums.rise[c] += weight * (phi[at] - phi[at - below]);
    }
  }
}

void FaceShares::find_row(const Real* phi, const Around& around, const Row& row) {
  const ProjectionGrid& grid = surface_.grid();
  const auto [a, k, r] = row;
  const LocalId columns = grid.columns(k, r);
  const std::size_t floor = grid.index(k, r, 0), below = grid.step(a);
  const Real* const full = &full_[floor];
  if (std::find(full, full + columns, 1.0) == full + columns) return;
  static thread_local Sums sums;
  sums.resize(static_cast<std::size_t>(columns) + 2);
  sum_rows(phi, around, a, floor, sums);
  const CellFields& means = surface_.water().all_means();
  const RowToRead cells = means.row(k, r),
                  cells_below = means.row(a == 0 ? k - 1 : k, a == 1 ? grid.row_beside(r - 1) : r);
  const std::size_t y = 1 + grid.axis(a);  // the index of the component of Σ y across the face
  const Real per_length = 1 / grid.size()[static_cast<Eigen::Index>(a)];
  const Real others = grid.is_layer() ? 2 : 12;  // weight of the surrounding faces
  for (LocalId c = 0; c < columns; ++c) {
    const auto i = static_cast<std::size_t>(c);
    const std::size_t at = floor + i;
    if (full_[at] == 0 || full_[at - below] == 0 || surface_.face(a, at) != 1) continue;
    const auto total = [&](const std::vector<Real>& of) {
      return around.has_columns ? of[i] + 2 * of[i + 1] + of[i + 2] : of[i + 1];
    };
    const Real rise = phi[at] - phi[at - below];
    const Real rough = (rise * total(sums.faces) - total(sums.rise)) / others * per_length;
    // W: a particle counts 1 in the plane of the face and 0 a cell away.
    const LocalId c_below = a == 2 ? (c + columns - 1) % columns : c;
    const Real particles = *number_of(cells, c) - *number_of(cells, c, y) + *number_of(cells_below, c_below, y);
    const Real share = particles * max_portion > full_particles_ ? full_particles_ / particles : max_portion;
    share_[a][at] = (std::max(share, min_portion) - 1) * rough;
  }
}

}  // namespace trevi
