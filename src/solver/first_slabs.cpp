#include "solver/first_slabs.hpp"

#include <fmt/format.h>
#include <petscsys.h>

#include <cmath>
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

CellGrid cell_grid(const Settings& settings) {
  return {settings.domain.min, settings.domain.max, settings.fluid.kernel_radius, settings.slab_axis,
          settings.periodic};
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
