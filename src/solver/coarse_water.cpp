#include "solver/coarse_water.hpp"

#include "base/threads.hpp"

namespace trevi {

namespace {

// Share of its volume that a cell must hold to count as wet. At the surface 0.585: the water then stands at least a
// twelfth of a cell above the cell's middle, where phi is given. It is not 0.6, as this is what the top layer of a
// lattice fills at h = 2.5 spacings: rounding would make some of its cells wet and others dry, and a pool at rest would
// move at 0.1 m/s. Below the surface the share is lower, as cells of disordered water may hold only a third; on the
// floor lower still, so that a sheet of one layer is supported, too.
constexpr Real wet_fill = 0.585, submerged_fill = 0.3, floor_fill = 0.2;
// Largest volume, in cells, by which the fill of the cells below may raise or lower the surface in a top cell. The
// cells of torn water are far from full; without this limit its surface would lie below its top cell, and faces of
// negative area would make the sweeps diverge.
constexpr Real most_excess = 0.25;
// Added to the variance, in cells², so that the regression line of a face does not follow noise; particles on one side
// of a face alone have a variance of 0.05.
constexpr Real regression_damping = 0.1;
// Share of its volume in particles of which the middle is in it from which on a cell counts for the depth, and from
// which on it has a surface of water in or above it. A sheet on a solid may be as thin as one on the floor.
constexpr Real deep_fill = 0.2, surface_fill = 0.4;

WaterReach::Least least_particles(const CoarseGrid& grid, Real spacing, bool solids) {
  const Real particles = grid.size().prod() / (spacing * spacing * spacing);
  const auto number = [&](Real fill) { return static_cast<LocalId>(std::ceil(fill * particles)); };
  return {number(deep_fill), number(solids ? deep_fill : surface_fill)};
}

}  // namespace

CoarseWater::Moments CoarseWater::low(const CellSums& sums, Real count, std::size_t a) const {
  const std::size_t b = grid_.axis(a);
  return {count - sums.f[b], sums.f[b] - sums.f2[b], sums.f2[b] - sums.f3[b], sums.u[b] - sums.fu[b],
          sums.fu[b] - sums.f2u[b]};
}
CoarseWater::Moments CoarseWater::high(const CellSums& sums, std::size_t a) const {
  const std::size_t b = grid_.axis(a);
  return {sums.f[b], sums.f2[b] - sums.f[b], sums.f3[b] - 2 * sums.f2[b] + sums.f[b], sums.fu[b],
          sums.f2u[b] - sums.fu[b]};
}

CoarseWater::Moments CoarseWater::Moments::operator+(const Moments& other) const {
  return {weight + other.weight, offset + other.offset, offset2 + other.offset2, value + other.value,
          offset_value + other.offset_value};
}

Real CoarseWater::Moments::at_face() const {
  if (weight < 1e-9) return 0;
  // Covariance and damped variance, times the square of the weight.
  const Real covariance = offset_value * weight - offset * value;
  const Real variance = offset2 * weight - offset * offset + regression_damping * (weight * weight);
  return (value - offset * (covariance / variance)) / weight;
}

CoarseWater::CoarseWater(MPI_Comm comm, const CellGrid& grid, const Box& box, Real spacing, const Obstacles* obstacles)
    : comm_(comm),
      box_(box),
      grid_(comm, grid, box),
      reach_(comm, least_particles(grid_, spacing, obstacles != nullptr)) {
  if (obstacles != nullptr) solids_.emplace(*obstacles);
  frame_.per_length = grid_.per_length();
  frame_.per_full = 1;
  for (std::size_t a = 0; a < 3; ++a) {
    const std::size_t b = grid_.axis(a);
    frame_.half[b] = spacing / 2 * frame_.per_length[b];
    const bool endless = a < 2 && grid_.repeats()[a];
    frame_.nearest[b] = endless ? -INFINITY : frame_.half[b];
    frame_.farthest[b] = endless ? INFINITY : grid_.count(a) - frame_.half[b];
    frame_.per_full *= 2 * frame_.half[b];
  }
}

void CoarseWater::measure(const CellOrder& order, Halo& halo, const Motion& motion) {
  reach_.measure(order, halo);
  resize(order.planes());
  PerThread<FaceSums> faces;
  for_each_part({1, grid_.planes() + 1}, 1, [&](Range k) { sum_plane(order, k.begin, motion, faces.mine()); });
  grid_.repeat(displacement_[1]);
  halo.start_planes(sums_, grid_.step(0));
  halo.finish();
  for_each_row(grid_.rows_of({1, grid_.planes() + 1}), [&](LocalId k, LocalId r) {
    const std::size_t plane = grid_.step(0), floor = grid_.index(k, r, 0);
    for (std::size_t at = floor; at < floor + static_cast<std::size_t>(grid_.columns(k, r)); ++at)
      fill_[at] = sums_[at - plane].volume[2] + sums_[at].volume[1] + sums_[at + plane].volume[0];
  });
  halo.start_planes(fill_, grid_.step(0));
  for_each_row(grid_.rows_of({1, grid_.planes() + 2}), [&](LocalId k, LocalId r) { finish_faces(k, r); });
  halo.finish();
  find_surface(halo);
}

// Arrays keep their shape while the water grows and falls by a few columns.
void CoarseWater::resize(LocalId planes) {
  constexpr LocalId step = 4;
  if (grid_.resize(planes, (reach_.most_columns() + step - 1) / step * step)) {
    sums_.assign(grid_.cells(), {});
    for (auto& u : displacement_) u.assign(grid_.cells(), 0.0);
    fill_.assign(grid_.cells(), 0.0);
    height_.assign(grid_.cells(), 1.0);
    wet_.assign(grid_.cells(), 0);
  }
  // The ghost planes, too: where the box ends nothing is received.
  for_each_row(grid_.rows_of({0, planes + 2}), [&](LocalId k, LocalId r) {
    clear_row(k, r);
    grid_.set_columns(k, r, solids_ ? grid_.columns() : reach_.columns(k, r));
  });
}

// What the last step left there.
void CoarseWater::clear_row(LocalId k, LocalId r) {
  const auto begin = static_cast<std::ptrdiff_t>(grid_.index(k, r, 0)), count = std::ptrdiff_t{grid_.columns(k, r)} + 1;
  std::fill_n(sums_.begin() + begin, count, PlaneSums{});
  for (auto& u : displacement_) std::fill_n(u.begin() + begin, count, 0.0);
  std::fill_n(fill_.begin() + begin, count, 0.0);
  std::fill_n(wet_.begin() + begin, count, 0);
  if (r < grid_.rows() - 1) return;
  for (auto& u : displacement_) std::fill_n(u.begin() + begin + static_cast<std::ptrdiff_t>(grid_.step(1)), count, 0.0);
}

void CoarseWater::sum_plane(const CellOrder& order, LocalId k, const Motion& motion, FaceSums& faces) {
  faces.row.resize(grid_.step(0));
  faces.column.resize(grid_.step(0));
  const LocalId rows = grid_.rows();
  const auto columns_of = [&](LocalId r) { return static_cast<std::size_t>(grid_.columns(k, std::min(r, rows - 1))); };
  for (LocalId r = 0; r <= rows; ++r) {
    const auto begin = static_cast<std::ptrdiff_t>(grid_.index(0, r, 0));
    std::fill_n(faces.row.begin() + begin, columns_of(r) + 1, Moments{});
    std::fill_n(faces.column.begin() + begin, columns_of(r) + 1, Moments{});
  }
  // Where rows repeat, the last one is also before the first, and the first beyond the last: each row is then added to
  // in the same order.
  const LocalId beyond = grid_.repeats()[1] ? 1 : 0;
  for (LocalId r = -beyond; r < rows + beyond; ++r) sum_row(order, {k, r, 0}, motion, faces);
  for (LocalId r = 0; r <= rows; ++r) {
    const std::size_t in_plane = grid_.index(0, r, 0), at = grid_.index(k, r, 0);
    for (std::size_t c = 0; c <= columns_of(r); ++c) {
      displacement_[1][at + c] = faces.row[in_plane + c].at_face();
      displacement_[2][at + c] = faces.column[in_plane + c].at_face();
    }
  }
}

void CoarseWater::sum_row(const CellOrder& order, const Place& row, const Motion& motion, FaceSums& faces) {
  const LocalId k = row.k, rows = grid_.rows(), r = (row.r + rows) % rows, all_columns = order.grid().columns();
  for (LocalId c = 0; c < grid_.columns(k, r); ++c) {
    const LocalId cell = r * all_columns + c;
    const auto begin = static_cast<std::size_t>(order.start(k, cell) - order.low_ghosts());
    const auto end = static_cast<std::size_t>(order.start(k, cell + 1) - order.low_ghosts());
    if (begin == end) continue;
    const CellSums sums = sum_cell(frame_, motion, {begin, end, grid_.place_of(motion.p[begin])});
    add_cell({k, row.r, c}, static_cast<Real>(end - begin), sums, faces);
  }
}

void CoarseWater::add_cell(const Place& place, Real count, const CellSums& sums, FaceSums& faces) {
  const auto [k, r, c] = place;
  add_volume(place, sums);
  if (r < 0) faces.row[grid_.index(0, 0, c)] += high(sums, 1);
  if (r < 0 || r == grid_.rows()) return;
  const std::size_t in_plane = grid_.index(0, r, c), at = grid_.index(k, r, c);
  sums_[at].low += low(sums, count, 0);
  sums_[at].high += high(sums, 0);
  faces.row[in_plane] += low(sums, count, 1);
  faces.row[in_plane + grid_.step(1)] += high(sums, 1);
  faces.column[in_plane] += low(sums, count, 2);
  faces.column[in_plane + 1] += high(sums, 2);
}

void CoarseWater::add_volume(const Place& place, const CellSums& sums) {
  const auto [k, r, c] = place;
  const bool along_x = grid_.axis(0) == 0;
  for (LocalId row = std::max(r - 1, 0); row <= std::min(r + 1, grid_.rows() - 1); ++row) {
    for (LocalId column = std::max(c - 1, 0); column <= std::min(c + 1, grid_.columns(k, row) - 1); ++column) {
      auto& volume = sums_[grid_.index(k, row, column)].volume;
      const auto i = static_cast<std::size_t>(row - r + 1), j = static_cast<std::size_t>(column - c + 1);
      for (std::size_t plane = 0; plane < 3; ++plane)
        volume[plane] += along_x ? sums.volume[plane][i][j] : sums.volume[i][plane][j];
    }
  }
}

void CoarseWater::finish_faces(LocalId k, LocalId r) {
  const std::size_t floor = grid_.index(k, r, 0);
  for (std::size_t at = floor; at < floor + static_cast<std::size_t>(grid_.columns(k, r)); ++at)
    displacement_[0][at] = (sums_[at - grid_.step(0)].high + sums_[at].low).at_face();
}

void CoarseWater::find_surface(Halo& halo) {
  if (solids_) {
    solids_->measure(comm_, grid_, box_);
    find_surface_among_solids(halo);
    return;
  }
  for_each_row(grid_.rows_of({0, grid_.planes() + 2}), [&](LocalId k, LocalId r) {
    for (LocalId c = 0; c < std::min(reach_.wet_columns(k, r), grid_.columns()); ++c) {
      const std::size_t at = grid_.index(k, r, c);
      wet_[at] = is_full_enough(at, c, c == 0) ? 1 : 0;
    }
    if (grid_.columns(k, r) == grid_.columns()) close_ceiling(k, r);
    find_tops(k, r);
  });
  grid_.repeat(wet_);
  grid_.repeat(height_);
}

bool CoarseWater::is_full_enough(std::size_t at, LocalId c, bool on_floor) const {
  const bool submerged = c + 1 < grid_.columns() && fill_[at] >= submerged_fill && fill_[at + 1] >= submerged_fill;
  return fill_[at] >= wet_fill || submerged || (on_floor && fill_[at] >= floor_fill);
}

// Water that reaches the ceiling has no surface: the cell past the last one counts as wet.
void CoarseWater::close_ceiling(LocalId k, LocalId r) {
  const std::size_t end = grid_.index(k, r, grid_.columns());
  if (grid_.columns() == grid_.count(2)) wet_[end] = wet_[end - 1];
}

void CoarseWater::find_tops(LocalId k, LocalId r) {
  const std::size_t floor = grid_.index(k, r, 0);
  bool standing = true;
  Real excess = 0;  // volume in the wet cells below the top one beyond one cell each, in cells
  for (LocalId c = 0; c < grid_.columns(k, r); ++c) {
    const std::size_t at = floor + static_cast<std::size_t>(c);
    if (!is_wet(at)) {
      standing = standing && is_solid(at);
    } else if (is_top(at)) {
      const Real more = standing ? std::clamp(excess, -most_excess, most_excess) : 0;
      height_[at] = std::max(fill_[at] + fill_[at + 1] + more, floor_fill);
    } else {
      excess += open(at) * (fill_[at] - 1);
    }
  }
}

std::size_t CoarseWater::bytes() const {
  std::size_t values = fill_.capacity() + height_.capacity() + level_.capacity();
  for (const auto& u : displacement_) values += u.capacity();
  return values * sizeof(Real) + wet_.capacity() + joined_.capacity() + reach_.bytes() +
         sums_.capacity() * sizeof(PlaneSums);
}

}  // namespace trevi
