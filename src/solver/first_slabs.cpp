#include "solver/first_slabs.hpp"

#include <fmt/format.h>
#include <petscsys.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include "particles/packed.hpp"
#include "trevi/error.hpp"

namespace trevi {

namespace {

// PETSc's solver has three unknowns per particle, and a PetscInt must count those of all ranks together.
void check_unknowns(const Settings& settings, const std::vector<Real>& weights) {
  const Real particles = std::accumulate(weights.begin(), weights.end(), 0.0);
  if (settings.density.method != Method::anderson || 3 * particles <= static_cast<Real>(PETSC_MAX_INT)) return;
  throw InputError(
      fmt::format("[density] method = \"anderson\" can count {:.0f} particles with this PETSc, got {:.0f}; use another "
                  "method",
                  std::floor(static_cast<Real>(PETSC_MAX_INT) / 3), particles));
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

Slabs first_slabs(const Settings& settings, const CellGrid& grid, const std::vector<Real>& weights, int ranks) {
  const std::vector<Real> ones(weights.size(), 1);
  Slabs slabs(settings.slabs == SlabCuts::equal ? ones : weights, ranks);
  check_unknowns(settings, weights);
  const bool single = settings.density.precision == Precision::single;
  slabs.check_capacity(weights, grid.cells_per_plane(), single ? sizeof(Packed<float>) : sizeof(Packed<double>));
  return slabs;
}

}  // namespace trevi
