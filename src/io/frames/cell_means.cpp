#include "io/frames/cell_means.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace trevi {

namespace {

constexpr Real velocity_units = 1 << 30, density_units = 1 << 20;  // per 1 m/s, per 1 kg/m³
constexpr Real largest_velocity = 1e5, largest_density = 1e8;      // 90,000 of them in a cell fit into an int64

struct CellSum {
  std::int64_t cell = 0, particles = 0;
  std::array<std::int64_t, 3> velocity{};
  std::int64_t density = 0;

  void add(const CellSum& other) {
    particles += other.particles;
    for (const std::size_t a : {0U, 1U, 2U}) velocity[a] += other.velocity[a];
    density += other.density;
  }
};

// -limit for anything that is not a number.
std::int64_t in_units(Real value, Real limit, Real units) {
  return std::llround(units * std::max(-limit, std::min(limit, value)));
}

CellSum sum_of(const Frame& frame, std::size_t i, std::int64_t cell) {
  CellSum sum{cell, 1, {}, 0};
  for (const int a : {0, 1, 2}) {
    sum.velocity[static_cast<std::size_t>(a)] =
        in_units(frame.particles.velocity[i][a], largest_velocity, velocity_units);
  }
  if (!frame.density.empty()) sum.density = in_units(frame.density[i], largest_density, density_units);
  return sum;
}

void merge_equal_cells(std::vector<CellSum>& sums) {
  std::sort(sums.begin(), sums.end(), [](const CellSum& a, const CellSum& b) { return a.cell < b.cell; });
  std::size_t kept = 0;
  for (const CellSum& sum : sums) {
    if (kept > 0 && sums[kept - 1].cell == sum.cell)
      sums[kept - 1].add(sum);
    else
      sums[kept++] = sum;
  }
  sums.resize(kept);
}

// Sums by cells over this rank's particles. Those of a cell are contiguous, except for the few that have moved.
std::vector<CellSum> own_sums(const CoarseCells& cells, const Frame& frame) {
  std::vector<CellSum> sums;
  for (std::size_t i = 0; i < frame.particles.id.size(); ++i) {
    const std::int64_t cell = cells.point_of(frame.particles.position[i]);
    if (cell < 0) continue;
    const CellSum one = sum_of(frame, i, cell);
    if (!sums.empty() && sums.back().cell == cell)
      sums.back().add(one);
    else
      sums.push_back(one);
  }
  for (const std::int64_t step : cells.steps_to_second()) {
    const std::size_t once = sums.size();
    for (std::size_t k = 0; k < once; ++k) {
      sums.push_back(sums[k]);
      sums.back().cell += step;
    }
  }
  merge_equal_cells(sums);
  return sums;
}

std::vector<int> first_rows(const std::vector<int>& counts) {
  std::vector<int> starts(counts.size());
  std::exclusive_scan(counts.begin(), counts.end(), starts.begin(), 0);
  return starts;
}

// Sends the sums to the ranks responsible for the cells, which are slices of ascending cells.
std::vector<CellSum> sent_to_slices(MPI_Comm comm, std::int64_t total, const std::vector<CellSum>& sums) {
  const int ranks = size_of(comm);
  std::vector<int> sent(static_cast<std::size_t>(ranks)), received(sent.size());
  auto next = sums.begin();
  for (int rank = 0; rank < ranks; ++rank) {
    const RowSlice slice = equal_slice(total, rank, ranks);
    const auto end = std::lower_bound(next, sums.end(), slice.first + slice.count,
                                      [](const CellSum& sum, std::int64_t cell) { return sum.cell < cell; });
    sent[static_cast<std::size_t>(rank)] = static_cast<int>(end - next);
    next = end;
  }
  MPI_Alltoall(sent.data(), 1, MPI_INT, received.data(), 1, MPI_INT, comm);
  const std::vector<int> sent_starts = first_rows(sent), received_starts = first_rows(received);
  std::vector<CellSum> arrived(static_cast<std::size_t>(received_starts.back() + received.back()));
  MPI_Datatype row;
  MPI_Type_contiguous(sizeof(CellSum), MPI_BYTE, &row);
  MPI_Type_commit(&row);
  MPI_Alltoallv(sums.data(), sent.data(), sent_starts.data(), row, arrived.data(), received.data(),
                received_starts.data(), row, comm);
  MPI_Type_free(&row);
  return arrived;
}

}  // namespace

CoarseCells::CoarseCells(const Box& domain, const CellGrid& grid, const std::optional<Box>& box) : grid_(grid) {
  for (const int a : {0, 1, 2}) {
    const auto k = static_cast<std::size_t>(a);
    const Real per_metre = grid.per_length(k);
    const auto last = static_cast<std::int64_t>(grid.count(k));
    std::int64_t end = last;
    if (box) {
      constexpr Real rounding = 1e-9;  // of a cell: if a face of the box is one of cells, no cell beyond it is taken
      const Real low = std::floor((box->min[a] - domain.min[a]) * per_metre + rounding),
                 high = std::ceil((box->max[a] - domain.min[a]) * per_metre - rounding);
      first_[k] = std::clamp<std::int64_t>(static_cast<std::int64_t>(low), 0, last - 1);
      end = std::clamp<std::int64_t>(static_cast<std::int64_t>(high), first_[k] + 1, last);
    }
    cells_[k] = end - first_[k];
    count_[k] = std::max<std::int64_t>(cells_[k], 2);
    size_[a] = grid.length(k) / static_cast<Real>(last);
    const Real first = static_cast<Real>(first_[k]) + (cells_[k] > 1 ? 0.5 : 0.0);
    origin_[a] = domain.min[a] + first * size_[a];
  }
}

std::int64_t CoarseCells::point_of(const Vec3& p) const {
  const std::array<std::int64_t, 3> at{grid_.plane_of(p), grid_.row_of(p), grid_.column_of(p)};
  std::int64_t point = 0;
  for (const std::size_t a : {2U, 1U, 0U}) {
    const std::int64_t index = at[a] - first_[a];
    if (index < 0 || index >= cells_[a]) return -1;
    point = point * count_[a] + index;
  }
  return point;
}

std::vector<std::int64_t> CoarseCells::steps_to_second() const {
  const std::array<std::int64_t, 3> strides{1, count_[0], count_[0] * count_[1]};
  std::vector<std::int64_t> steps;
  for (const std::size_t a : {0U, 1U, 2U})
    if (cells_[a] == 1) steps.push_back(strides[a]);
  return steps;
}

CellMeans cell_means(MPI_Comm comm, const CoarseCells& cells, Real particle_volume, const Frame& frame) {
  CellMeans means;
  means.slice = equal_slice(cells.total(), rank_of(comm), size_of(comm));
  const auto count = static_cast<std::size_t>(means.slice.count);
  std::vector<CellSum> sums = sent_to_slices(comm, cells.total(), own_sums(cells, frame));
  merge_equal_cells(sums);
  means.fraction.resize(count);
  means.velocity.resize(count);
  means.density.resize(count);
  const Real fraction_each = particle_volume / cells.size().prod();
  for (const CellSum& sum : sums) {
    const auto k = static_cast<std::size_t>(sum.cell - means.slice.first);
    const auto particles = static_cast<Real>(sum.particles);
    means.fraction[k] = static_cast<float>(particles * fraction_each);
    for (const std::size_t a : {0U, 1U, 2U})
      means.velocity[k][a] = static_cast<float>(static_cast<Real>(sum.velocity[a]) / velocity_units / particles);
    means.density[k] = static_cast<float>(static_cast<Real>(sum.density) / density_units / particles);
  }
  return means;
}

}  // namespace trevi
