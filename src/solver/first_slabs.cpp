#include "solver/first_slabs.hpp"

#include <fmt/format.h>
#include <petscsys.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include "domain/balance.hpp"
#include "parallel/waiting.hpp"
#include "particles/packed.hpp"
#include "projection/affine.hpp"
#include "solver/halo_traffic.hpp"
#include "solver/ranks_by_model.hpp"
#include "trevi/error.hpp"

namespace trevi {

// PETSc's solver has three unknowns per particle, and a PetscInt must count those of all ranks together.
void check_unknowns(const Settings& settings, const std::vector<Real>& weights) {
  const Real particles = std::accumulate(weights.begin(), weights.end(), 0.0);
  if (settings.density.method != Method::anderson || 3 * particles <= static_cast<Real>(PETSC_MAX_INT)) return;
  throw InputError(
      fmt::format("\"anderson\" can count {:.0f} particles with this PETSc, got {:.0f}; use another "
                  "method",
                  std::floor(static_cast<Real>(PETSC_MAX_INT) / 3), particles));
}

namespace {

// As specified by the settings.
std::array<int, 2> slabs_and_parts(const Settings& settings, const CellGrid& grid, const std::vector<Real>& planes,
                                   int ranks) {
  if (!settings.ranks_by_model) return settings.ranks.value_or(std::array<int, 2>{ranks, 1});
  const Real particles = std::accumulate(planes.begin(), planes.end(), 0.0);
  return ranks_by_model(resting_water(settings, grid, particles), ranks);
}

}  // namespace

CellGrid cell_grid(const Settings& settings, const Box& box) {
  return {box.min, box.max, settings.fluid.kernel_radius, settings.slab_axis, settings.periodic};
}

std::array<LocalId, 3> first_cell(MPI_Comm comm, const Settings& settings, const Particles& particles) {
  std::array<LocalId, 3> cell{};
  if (settings.periodic == std::array<bool, 3>{}) return cell;
  const auto least = std::min_element(particles.id.begin(), particles.id.end());
  const GlobalId none = std::numeric_limits<GlobalId>::max(), mine = least == particles.id.end() ? none : *least;
  GlobalId first = mine;
  MPI_Allreduce(MPI_IN_PLACE, &first, 1, MPI_INT64_T, MPI_MIN, comm);
  if (mine == first && mine != none) {
    const CellGrid grid = cell_grid(settings, settings.domain);
    const Vec3& p = particles.position[static_cast<std::size_t>(least - particles.id.begin())];
    const std::array<LocalId, 3> at{grid.plane_of(p), grid.row_of(p), grid.column_of(p)};
    for (std::size_t a = 0; a < 3; ++a) {
      if (grid.is_periodic(a)) cell[static_cast<std::size_t>(grid.axis(a))] = at[a];
    }
  }
  MPI_Allreduce(MPI_IN_PLACE, cell.data(), 3, MPI_INT32_T, MPI_SUM, comm);
  return cell;
}

std::vector<Real> plane_weights(MPI_Comm comm, const CellGrid& grid, const Particles& particles) {
  std::vector<Real> weights(static_cast<std::size_t>(grid.planes()), 0.0);
  for (const Vec3& p : particles.position) weights[static_cast<std::size_t>(grid.plane_of(p))] += 1;
  MPI_Allreduce(MPI_IN_PLACE, weights.data(), static_cast<int>(weights.size()), MPI_DOUBLE, MPI_SUM, comm);
  return weights;
}

void add_row_weights(const CellGrid& grid, const Slabs& slabs, const Particles& particles, RowWeights& weights) {
  const auto rows = static_cast<std::size_t>(grid.rows());
  for (const Vec3& p : particles.position) {
    std::vector<Real>& of_slab = weights[slabs.slab_of(grid.plane_of(p))];
    of_slab.resize(rows);
    of_slab[static_cast<std::size_t>(grid.row_of(p))] += 1;
  }
}

namespace {

void check_parts(const CellGrid& grid, int parts) {
  if (parts <= grid.rows()) return;
  throw InputError(
      fmt::format("planes have {} rows of cells, fewer than the {} parts of a slab; use at most {} parts, another "
                  "[domain] slab_axis, or a smaller kernel_radius",
                  grid.rows(), parts, grid.rows()));
}

// On the first rank of each slab, the sums over all ranks of the weights of its rows; empty on other ranks. The weights
// are whole numbers, so the order does not matter.
std::vector<Real> sum_at_slabs(MPI_Comm comm, const RowWeights& given, int parts, LocalId rows) {
  std::vector<int> sent(static_cast<std::size_t>(size_of(comm)), 0);
  std::vector<MPI_Request> requests;
  for (const auto& [slab, weights] : given) {
    sent[static_cast<std::size_t>(slab * parts)] = 1;
    MPI_Isend(weights.data(), rows, MPI_DOUBLE, slab * parts, 0, comm, &requests.emplace_back());
  }
  int count = 0;
  MPI_Reduce_scatter_block(sent.data(), &count, 1, MPI_INT, MPI_SUM, comm);
  const bool is_first = rank_of(comm) % parts == 0;
  std::vector<Real> sum(static_cast<std::size_t>(is_first ? rows : 0), 0.0), one(sum.size());
  for (int k = 0; k < count; ++k) {
    MPI_Recv(one.data(), rows, MPI_DOUBLE, MPI_ANY_SOURCE, 0, comm, MPI_STATUS_IGNORE);
    for (std::size_t r = 0; r < sum.size(); ++r) sum[r] += one[r];
  }
  wait_all(requests);
  return sum;
}

}  // namespace

Real bytes_of_particle(const Settings& settings, const CellGrid& grid) {
  const bool single = settings.density.precision == Precision::single;
  const Real record = single ? sizeof(Packed<float>) : sizeof(Packed<double>);
  if (!settings.density.coarse_grid) return record;
  constexpr Real of_cell = sizeof(Real) * (numbers::moments + numbers::volumes);
  return std::max(record, of_cell / resting_water(settings, grid, 0).particles_per_cell);
}

Slabs first_slabs(MPI_Comm comm, const Settings& settings, const CellGrid& grid, const CellWeights& weights) {
  const int ranks = size_of(comm);
  const auto [slabs_of_all, parts] = slabs_and_parts(settings, grid, weights.planes, ranks);
  if (std::int64_t{slabs_of_all} * parts != ranks) {
    throw InputError(fmt::format(
        "[{}, {}] are {} ranks, and this run has {}; start it on {}, or set domain.ranks "
        "to two numbers whose product is {}",
        slabs_of_all, parts, std::int64_t{slabs_of_all} * parts, ranks, std::int64_t{slabs_of_all} * parts, ranks));
  }
  const bool are_equal = settings.slabs == SlabCuts::equal;
  const std::vector<Real> ones(weights.planes.size(), 1);
  Slabs slabs(are_equal ? ones : weights.planes, slabs_of_all);
  if (parts > 1) {
    check_parts(grid, parts);
    std::vector<Real> of_rows = sum_at_slabs(comm, weights.rows(slabs), parts, grid.rows());
    if (are_equal) of_rows.assign(of_rows.size(), 1);
    cut_rows(comm, of_rows, parts, slabs);
  }
  check_unknowns(settings, weights.planes);
  slabs.check_capacity(weights.planes, {grid.rows(), grid.columns()}, bytes_of_particle(settings, grid));
  return slabs;
}

}  // namespace trevi
