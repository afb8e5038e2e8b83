#include "projection/particles_to_grid.hpp"

#include <algorithm>

#include "projection/parameters.hpp"

namespace trevi {

namespace {

Moments moments_of(const CellParticles& cell, const MotionSums& sums) {
  return {{static_cast<Real>(cell.end - cell.begin), sums.y, sums.yy}, {sums.u, sums.uy}, sums.uu};
}

Range joined(Range a, Range b) {
  if (a.size() == 0) return b;
  return b.size() == 0 ? a : Range{std::min(a.begin, b.begin), std::max(a.end, b.end)};
}

bool is_in(LocalId c, Range range) { return c >= range.begin && c < range.end; }

// The number of rows of a plane that are summed at a time: all of them if there are enough planes for the threads,
// because the rows at the ends of a part are summed twice.
LocalId rows_of_sums(Range planes, LocalId rows) {
  constexpr LocalId parts_of_thread = 4, fewest = 8;
  const LocalId parts = (parts_of_thread * thread_count() + planes.size() - 1) / planes.size();
  return thread_count() == 1 ? rows : std::max((rows + parts - 1) / parts, fewest);
}

// Along x and y the density of a particle is the convolution of two boxes. The first is as wide as the largest whole
// number of spacings in a cell, and both together are two cells wide. For a lattice this is uniform. At h = 2 s it is a
// tent that ends a cell away, so that volumes change by the displacements that particles give to faces. Along z it is a
// tent that ends one spacing away.
CellFrame frame_of_particles(const ProjectionGrid& grid, Real spacing) {
  constexpr Real rounding = 1e-9;
  CellFrame frame{};
  frame.per_length = grid.per_length();
  frame.per_full = 1;
  for (std::size_t a = 0; a < 3; ++a) {
    const std::size_t b = grid.axis(a);
    const Real edge = spacing * frame.per_length[b];
    frame.flat[b] = a == 2 ? 0 : 1 - edge * std::floor(1 / edge + rounding);
    frame.reach[b] = a == 2 ? edge : 1;
    const bool open = grid.repeats()[a], moved_in = a == 2 && !open;
    frame.nearest[b] = moved_in ? edge / 2 : -INFINITY;
    frame.farthest[b] = moved_in ? grid.count(a) - edge / 2 : INFINITY;
    frame.floor[b] = open ? -INFINITY : 0;
    frame.ceiling[b] = open ? INFINITY : static_cast<Real>(grid.count(a));
    frame.per_full *= edge;
  }
  return frame;
}

// For layers of particles beyond one side of a cell, the first of them at its face.
Real largest_from_one_side(const ProjectionGrid& grid, const CellFrame& frame, Real spacing) {
  Real most = 0;
  for (std::size_t a = 0; a < 3; ++a) {
    if (a == 1 && grid.is_layer()) continue;
    const std::size_t b = grid.axis(a);
    const Real edge = spacing * frame.per_length[b], reach = frame.reach[b], flat = frame.flat[b];
    Real told = 0;
    for (Real way = 0; way < reach; way += edge) {
      const Real sloped = std::pow(reach - way, 2) - std::pow(std::max(flat - way, 0.0), 2);
      told += edge * sloped / (2 * (reach * reach - flat * flat));
    }
    most = std::max(most, told);
  }
  return most;
}

// The centroids of the open parts of a row of faces, in cells from the corner of the cell above, by coordinate.
class FaceMiddles {
 public:
  void find(std::size_t a, std::size_t first, std::size_t count, const CutCells* cuts) {
    for (auto& of_axis : middle_) of_axis.assign(count + 2 * FourCells::count, 0.5);
    if (cuts == nullptr) return;
    for (std::size_t c = 0; c < count; ++c) {
      const ByAxis middle = cuts->middle_of_face(a, first + c);
      for (std::size_t b = 0; b < 3; ++b) middle_[b][c] = middle[b];
    }
  }
  std::array<const Real*, 3> rows() const { return {middle_[0].data(), middle_[1].data(), middle_[2].data()}; }

 private:
  std::array<std::vector<Real>, 3> middle_;
};

}  // namespace

ParticlesToGrid::ParticlesToGrid(const ProjectionGrid& grid, Real spacing)
    : grid_(grid),
      frame_(frame_of_particles(grid, spacing)),
      told_from_one_side_(largest_from_one_side(grid, frame_, spacing)) {}

void ParticlesToGrid::borrow() {
  filled_.assign(row_index(grid_.planes() + 2, -1), {});
  first_empty_.assign(filled_.size(), 0);
  fit_.borrow(grid_.scratch(), grid_.storage());
  for (Borrowed<Real>& u : displacement_) {
    u = grid_.scratch().borrow_briefly<Real>(grid_.cells());
    u.fill(0);
  }
  spread_.borrow_briefly(grid_.scratch(), grid_.storage());
  sums_.borrow_briefly(grid_.scratch(), grid_.storage());
  volumes_.borrow_briefly(grid_.scratch(), grid_.storage_beside());
}

void ParticlesToGrid::keep_means() {
  constexpr std::size_t u = sizeof(Places) / sizeof(Real);  // of Moments
  means_.take(sums_, std::array<std::size_t, sizeof(Means) / sizeof(Real)>{0, 1, 2, 3, u, u + 1, u + 2});
}

void ParticlesToGrid::keep_fits() {
  for (CellFields* field : {&sums_, &means_, &spread_}) field->give_back();
}

void ParticlesToGrid::gather(const CellOrder& order, Halo& halo, const Motion& motion, Real g_dt2,
                             const CutCells* cuts) {
  frame_.by_gravity = g_dt2 / 2 * frame_.per_length[2];
  const LocalId planes = grid_.planes();
  if (grid_.rows_are_cut()) {
    exchange_volumes(order, halo, motion, cuts);
    sum_planes(order, {1, planes + 1}, motion, cuts);
    sums_.start(halo);
    halo.finish();
  } else if (halo.has_neighbours()) {
    sum_planes(order, {1, 2}, motion, cuts);  // they travel while the others are summed
    if (planes > 1) sum_planes(order, {planes, planes + 1}, motion, cuts);
    sums_.start(halo);
    if (planes > 2) sum_planes(order, {2, planes}, motion, cuts);
    halo.finish();
  } else {
    sum_planes(order, {1, planes + 1}, motion, cuts);
  }
  for_each_row(grid_.rows_and_ghosts_of({0, planes + 2}), [&](LocalId k, LocalId r) { find_filled(k, r); });
  for_each_row_and_send<TentMemory>(grid_, halo, fit_,
                                    [&](TentMemory& memory, LocalId k, LocalId r) { fit_row(memory, cuts, k, r); });
  for_each_row(grid_.rows_of({1, planes + 2}), [&](LocalId k, LocalId r) {
    find_faces(0, k, r, cuts);
    if (k > planes) return;
    if (!grid_.is_layer()) find_faces(1, k, r, cuts);  // nothing moves across a layer
    find_faces(2, k, r, cuts);
  });
}

void ParticlesToGrid::sum_planes(const CellOrder& order, Range planes, const Motion& motion, const CutCells* cuts) {
  const LocalId rows = rows_of_sums(planes, grid_.rows()), parts = (grid_.rows() + rows - 1) / rows;
  for_each_part(planes.size() * parts, [&](LocalId part) {
    const LocalId first = part % parts * rows;
    sum_rows(order, planes.begin + part / parts, {first, std::min(first + rows, grid_.rows())}, motion, cuts);
  });
}

CellParticles ParticlesToGrid::particles_of(const CellOrder& order, LocalId k, LocalId r, LocalId c) const {
  const LocalId cell = r * order.grid().columns() + c;
  const auto begin = static_cast<std::size_t>(order.start(k, cell) - order.low_ghosts());
  const auto end = static_cast<std::size_t>(order.start(k, cell + 1) - order.low_ghosts());
  return {begin, end, grid_.place_of(k, r, c)};
}

// The rows beside these contribute to them, too, and are summed again where they belong. Each row thus receives the
// contributions of the same rows in the same order, however the rows are divided into parts.
void ParticlesToGrid::sum_rows(const CellOrder& order, LocalId k, Range own, const Motion& motion,
                               const CutCells* cuts) {
  const LocalId rows = grid_.rows(), beyond = grid_.rows_wrap() ? 1 : 0;
  for (LocalId r = own.begin; r < own.end; ++r) {
    sums_.clear(k, r);
    volumes_.clear(k, r);
  }
  if (grid_.rows_are_cut() && own.begin == 0 && grid_.has_row(-1)) add_ghost_row(k, 0);
  // Where rows repeat, the last row also precedes the first one, and the first one follows the last.
  const LocalId end = std::min(own.end + 1, rows + beyond);
  for (LocalId row = std::max(own.begin - 1, -beyond); row < end; ++row) {
    const LocalId r = (row + rows) % rows;
    const Range near = cuts != nullptr ? cuts->columns_near_cut(k, r) : Range{0, 0};
    const CellSums* const known = known_sums(k, r);
    const RowsToAdd to = rows_to_add(k, row, own);
    for_each_cell(order, k, r, [&](LocalId c, const CellParticles& cell) {
      const CellSums sums =
          known != nullptr ? known[c] : sums_of({k, r, c}, cell, motion, is_in(c, near) ? cuts : nullptr);
      add_volume(to, c, sums);
      if (row >= own.begin && row < own.end) sums_.set(k, r, c, moments_of(cell, sums.motion));
    });
  }
  if (grid_.rows_are_cut() && own.end == rows && grid_.has_row(rows)) add_ghost_row(k, 1);
}

CellSums ParticlesToGrid::sums_of(const CellNumbers& at, const CellParticles& cell, const Motion& motion,
                                  const CutCells* near) const {
  return near == nullptr ? sum_cell(frame_, motion, cell)
                         : sum_cell(near->beside_solids(frame_, grid_, at), motion, cell);
}

// The contributions of the last row before a cut to the first row after it, and vice versa: the particles of ghost
// cells are not known.
void ParticlesToGrid::exchange_volumes(const CellOrder& order, Halo& halo, const Motion& motion, const CutCells* cuts) {
  const LocalId planes = grid_.planes();
  for (std::size_t side : {0U, 1U}) {
    given_[side].assign(beside_index(planes + 2, 0), {});
    received_[side].assign(beside_index(planes + 2, 0), {});
    ends_[side].resize(beside_index(planes + 2, 0));
  }
  for_each_part(2 * planes, [&](LocalId part) {
    find_volumes_beside(order, motion, cuts, part / 2 + 1, static_cast<std::size_t>(part % 2));
  });
  const std::size_t bytes = static_cast<std::size_t>(grid_.columns()) * sizeof(VolumesBeside);
  halo.start_rows({planes, bytes}, [&](LocalId k, LocalId r, int side) {
    const bool is_own = r >= 0 && r < grid_.rows(), before = side < 0;
    return &(is_own ? given_[before ? 1 : 0] : received_[before ? 0 : 1])[beside_index(k, 0)];
  });
  halo.finish();
}

void ParticlesToGrid::find_volumes_beside(const CellOrder& order, const Motion& motion, const CutCells* cuts, LocalId k,
                                          std::size_t side) {
  const bool along_x = grid_.axis(0) == 0;
  const LocalId r = side == 0 ? 0 : grid_.rows() - 1;
  const std::size_t i = side == 0 ? 0 : 2;
  const Range near = cuts != nullptr ? cuts->columns_near_cut(k, r) : Range{0, 0};
  for_each_cell(order, k, r, [&](LocalId c, const CellParticles& cell) {
    const CellSums& sums = ends_[side][beside_index(k, c)] =
        sums_of({k, r, c}, cell, motion, is_in(c, near) ? cuts : nullptr);
    VolumesBeside& beside = given_[side][beside_index(k, c)];
    for (std::size_t plane = 0; plane < 3; ++plane) {
      for (std::size_t j = 0; j < 3; ++j)
        beside[3 * plane + j] = along_x ? sums.volume[plane][i][j] : sums.volume[i][plane][j];
    }
  });
}

// Adds the contributions of the row before or after the owned ones to the adjacent owned row, in the order of its
// cells.
void ParticlesToGrid::add_ghost_row(LocalId k, std::size_t side) {
  const bool repeats = grid_.repeats()[2];
  const LocalId r = side == 0 ? 0 : grid_.rows() - 1, columns = grid_.columns(k, r);
  const RowToWrite volumes_of_row = volumes_of(k, r);
  for (LocalId c = 0; c < grid_.columns(); ++c) {
    const VolumesBeside& volumes_beside = received_[side][beside_index(k, c)];
    for (LocalId column = c - 1; column <= c + 1; ++column) {
      if (!repeats && (column < 0 || column >= columns)) continue;
      Real* const volume = number_of(volumes_of_row, repeats ? (column + columns) % columns : column);
      const auto j = static_cast<std::size_t>(column - c + 1);
      for (std::size_t plane = 0; plane < 3; ++plane) volume[plane * FourCells::count] += volumes_beside[3 * plane + j];
    }
  }
}

ParticlesToGrid::RowsToAdd ParticlesToGrid::rows_to_add(LocalId k, LocalId r, Range own) {
  RowsToAdd to{};
  to.rows = {std::max(own.begin - (r - 1), 0), std::min(own.end - (r - 1), 3)};
  for (LocalId i = to.rows.begin; i < to.rows.end; ++i) {
    to.volumes[static_cast<std::size_t>(i)] = volumes_of(k, r - 1 + i);
    to.columns[static_cast<std::size_t>(i)] = grid_.columns(k, r - 1 + i);
  }
  return to;
}

void ParticlesToGrid::add_volume(const RowsToAdd& to, LocalId c, const CellSums& sums) const {
  const bool along_x = grid_.axis(0) == 0, repeats = grid_.repeats()[2];
  for (auto i = static_cast<std::size_t>(to.rows.begin); i < static_cast<std::size_t>(to.rows.end); ++i) {
    const LocalId columns = to.columns[i];
    // Of the plane below, of the own plane and of the plane above, as they lie one after another in the sums.
    const Real* const of_row = reinterpret_cast<const Real*>(&sums.volume) + (along_x ? 3 : 9) * i;
    const std::size_t next_plane = along_x ? 9 : 3;
    const LocalId begin = repeats ? c - 1 : std::max(c - 1, 0), end = repeats ? c + 2 : std::min(c + 2, columns);
    for (LocalId column = begin; column < end; ++column) {
      Real* const volume = number_of(to.volumes[i], repeats ? (column + columns) % columns : column);
      const Real* const of_column = of_row + (column - (c - 1));
      for (std::size_t plane = 0; plane < 3; ++plane) volume[plane * FourCells::count] += of_column[plane * next_plane];
    }
  }
}

void ParticlesToGrid::find_volumes(LocalId k, LocalId r, std::span<Real> volumes_of_row) const {
  const RowToRead below = volumes_of(k - 1, r), own = volumes_of(k, r), above = volumes_of(k + 1, r);
  LocalId c = 0;
  for (Real& volume : volumes_of_row) {
    volume = *number_of(below, c, 2) + *number_of(own, c, 1) + *number_of(above, c, 0);
    ++c;
  }
}

// In ghost planes some rows are not known to hold nothing above their columns.
void ParticlesToGrid::find_filled(LocalId k, LocalId r) {
  const auto holds_any = [&](LocalId c) { return sums_.number(0, k, r, c) > 0; };
  Range& filled = filled_[row_index(k, r)] = {0, grid_.columns()};
  while (filled.end > 0 && !holds_any(filled.end - 1)) --filled.end;
  while (filled.begin < filled.end && !holds_any(filled.begin)) ++filled.begin;
  LocalId& first = first_empty_[row_index(k, r)] = 0;
  if (filled.begin == 0) {
    while (first < filled.end && holds_any(first)) ++first;
  }
}

// For MotionFits, valid until the next call. It never looks at the cell above, so the number of columns does not
// matter.
const Real* ParticlesToGrid::cells_at_solids(const CutCells& cuts, LocalId k, LocalId r) const {
  static thread_local std::vector<Real> at_solid;
  at_solid.assign(static_cast<std::size_t>(grid_.columns()) + FourCells::count, 0.0);
  const Range cells = filled(k, r);
  for (LocalId c = cells.begin; c < cells.end; ++c) {
    const std::size_t at = grid_.index(k, r, c);
    if (cuts.is_cut(at) || (c > 0 && cuts.is_cut(at - 1))) at_solid[static_cast<std::size_t>(c)] = 1;
  }
  return at_solid.data();
}

void ParticlesToGrid::fit_row(TentMemory& memory, const CutCells* cuts, LocalId k, LocalId r) {
  fit_.clear_around(k, r, filled(k, r));
  const Real* const at_solid = cuts != nullptr && cuts->cuts_row(k, r) ? cells_at_solids(*cuts, k, r) : nullptr;
  fit_motion(rows_around(grid_, sums_, {k, r, filled(k, r)}, memory),
             {fit_.row(k, r), spread_.row(k, r), frame_, at_solid});
}

// Displacements of the lower faces of the cells of a row in direction a, and of the upper face at the end of the last
// row or of a column, as far as there are particles beside them.
void ParticlesToGrid::find_faces(std::size_t a, LocalId k, LocalId r, const CutCells* cuts) {
  const LocalId last_row = a == 1 && r + 1 == grid_.rows() && !grid_.rows_wrap() ? r + 1 : r;
  static thread_local FaceMiddles middles;
  const bool cuts_faces = cuts != nullptr && cuts->cuts_row(k, r);  // of this row or of the row after it
  for (LocalId row = r; row <= last_row; ++row) {
    const LocalId plane_below = a == 0 ? k - 1 : k;
    const LocalId row_below = a != 1 ? row : grid_.row_beside(row - 1);
    const Range cells = joined(filled(k, row), filled(plane_below, row_below));
    if (cells.size() == 0) continue;
    constexpr LocalId four = FourCells::count;
    const bool whole = a == 2 && grid_.repeats()[2];
    const LocalId begin = whole ? 0 : cells.begin / four * four, end = whole ? grid_.columns() : cells.end;
    const auto count = static_cast<std::size_t>(end - begin + (a == 2 ? 1 : 0));
    const std::size_t first = grid_.index(k, row, begin);
    middles.find(a, first, count, cuts_faces ? cuts : nullptr);
    const auto beside = [&](LocalId plane, LocalId of) {
      const auto lowest = static_cast<std::size_t>(begin / four);
      return RowBeside{sums_.row(plane, of).from(lowest), fit_.row(plane, of).from(lowest)};
    };
    displace_faces({beside(plane_below, row_below), beside(k, row), grid_.axis(a), middles.rows(), a == 2, whole},
                   count, &displacement_[a][first]);
  }
}

std::size_t ParticlesToGrid::bytes() const {
  std::size_t values = 0;
  for (std::size_t side : {0U, 1U})
    values += (given_[side].capacity() + received_[side].capacity()) * sizeof(VolumesBeside) / sizeof(Real) +
              ends_[side].capacity() * sizeof(CellSums) / sizeof(Real);
  return filled_.capacity() * (sizeof(Range) + sizeof(LocalId)) + values * sizeof(Real);
}

}  // namespace trevi
