#include "app/initial_particles.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>

#include "app/lattice.hpp"
#include "app/scene_place.hpp"
#include "base/memory.hpp"
#include "domain/migrate.hpp"
#include "parallel/collective.hpp"
#include "parallel/core_share.hpp"
#include "parallel/reductions.hpp"
#include "solver/first_slabs.hpp"
#include "trevi/error.hpp"
#include "trevi/session.hpp"

namespace trevi {

namespace {

// Calls visit(layer, plane) for each layer of lattice points across the slab axis.
template <class Visit>
void for_each_layer(const Lattice& lattice, const CellGrid& grid, Visit&& visit) {
  const int axis = grid.slab_axis();
  for (GlobalId layer = 0; layer < lattice.count[static_cast<std::size_t>(axis)]; ++layer) {
    visit(layer, grid.plane_of(lattice.point(axis == 0 ? layer : 0, axis == 1 ? layer : 0, 0)));
  }
}

void add_particle(Particles& particles, GlobalId id, const Vec3& position, const Vec3& velocity) {
  particles.id.push_back(id);
  particles.position.push_back(position);
  particles.predicted.push_back(position);
  particles.velocity.push_back(velocity);
}

struct Layer {
  int axis;  // across which it lies
  GlobalId number;
};

void add_layer(Particles& particles, const Lattice& lattice, Layer layer, const ParticleSource& block,
               GlobalId first_id) {
  std::array<GlobalId, 3> begin = {0, 0, 0}, end = lattice.count;
  begin[static_cast<std::size_t>(layer.axis)] = layer.number;
  end[static_cast<std::size_t>(layer.axis)] = layer.number + 1;
  for (GlobalId k = begin[2]; k < end[2]; ++k) {
    for (GlobalId j = begin[1]; j < end[1]; ++j) {
      for (GlobalId i = begin[0]; i < end[0]; ++i) {
        add_particle(particles, first_id + lattice.id(i, j, k), lattice.point(i, j, k), block.velocity);
      }
    }
  }
}

// Particles read from files, wherever they belong; ids already follow those of the sources before.
struct FileParticles {
  Particles particles;
  std::vector<GlobalId> first_id;  // of each source
};

void append_rows(Particles& particles, const ParticleRows& rows, GlobalId first_id) {
  for (std::size_t i = 0; i < rows.id.size(); ++i) {
    add_particle(particles, rows.id[i] + first_id, rows.position[i], rows.velocity[i]);
  }
}

void check_inside(MPI_Comm comm, const Scene& scene, const ParticleRows& rows, const std::string& source) {
  all_or_none(comm, [&] {
    const auto bad = std::find_if(rows.position.begin(), rows.position.end(),
                                  [&](const Vec3& p) { return !scene.domain.contains(p); });
    if (bad == rows.position.end()) return;
    throw InputError(fmt::format(
        "{}: /particles/position: row {} is outside the box ({}, {}, {}); enlarge [domain] or move the particle",
        source, rows.first + (bad - rows.position.begin()), bad->x(), bad->y(), bad->z()));
  });
}

// Returns how many ids the rows take, from 0 to the largest.
GlobalId append_file(MPI_Comm comm, const Scene& scene, const std::string& path, GlobalId first_id,
                     Particles& particles) {
  const ParticleRows rows = read_particle_file(comm, path);
  if (rows.total == 0) throw InputError(path + ": /particles/position: no particles; write one row for each");
  check_inside(comm, scene, rows, path);
  append_rows(particles, rows, first_id);
  GlobalId last = -1;
  for (const GlobalId id : rows.id) last = std::max(last, id);
  MPI_Allreduce(MPI_IN_PLACE, &last, 1, MPI_INT64_T, MPI_MAX, comm);
  return last + 1;
}

FileParticles read_files(MPI_Comm comm, const Scene& scene) {
  FileParticles result;
  GlobalId next_id = 0;
  for (const ParticleSource& source : scene.particles) {
    result.first_id.push_back(next_id);
    next_id += source.type == ParticleSource::Type::block
                   ? Lattice(source, scene.fluid.spacing).size()
                   : told_at(scene, source.line, "[[particles]] path",
                             [&] { return append_file(comm, scene, source.path, next_id, result.particles); });
    if (next_id > end_of_ids) {
      throw InputError(scene.path +
                       ": ids of all [[particles]] together pass 2^62; leave /particles/id out of the files "
                       "to number their rows");
    }
  }
  return result;
}

// Particles in each plane, for those sources that are blocks.
std::vector<Real> block_weights(const Scene& scene, const CellGrid& grid) {
  std::vector<Real> weights(static_cast<std::size_t>(grid.planes()), 0.0);
  for (const ParticleSource& source : scene.particles) {
    if (source.type != ParticleSource::Type::block) continue;
    const Lattice lattice(source, scene.fluid.spacing);
    const GlobalId in_layer = lattice.size() / lattice.count[static_cast<std::size_t>(grid.slab_axis())];
    for_each_layer(lattice, grid, [&](GlobalId, LocalId plane) {
      weights[static_cast<std::size_t>(plane)] += static_cast<Real>(in_layer);
    });
  }
  return weights;
}

// The same with particles from files, which may be on any rank.
std::vector<Real> source_weights(MPI_Comm comm, const Scene& scene, const CellGrid& grid, const Particles& files) {
  std::vector<Real> weights = plane_weights(comm, grid, files);
  const std::vector<Real> blocks = block_weights(scene, grid);
  for (std::size_t k = 0; k < weights.size(); ++k) weights[k] += blocks[k];
  return weights;
}

// Sets the hue: x at the start, as a share of the extent of all particles in x.
void add_hue(MPI_Comm comm, Particles& particles) {
  Real low = 1e300, high = -1e300;
  for (const Vec3& p : particles.position) {
    low = std::min(low, p.x());
    high = std::max(high, p.x());
  }
  low = min_over_ranks(comm, low);
  high = max_over_ranks(comm, high);
  particles.has_hue = true;
  particles.hue.reserve(particles.position.size());
  for (const Vec3& p : particles.position) {
    particles.hue.push_back(high > low ? static_cast<float>((p.x() - low) / (high - low)) : 0.0F);
  }
}

}  // namespace

Slabs initial_slabs(MPI_Comm comm, const Scene& scene, const CellGrid& grid, std::vector<Real>& weights) {
  const FileParticles files = read_files(comm, scene);
  weights = source_weights(comm, scene, grid, files.particles);
  return first_slabs(scene, grid, weights, size_of(comm));
}

Particles initial_particles(MPI_Comm comm, const Scene& scene) {
  const CellGrid grid = cell_grid(scene);
  FileParticles files = read_files(comm, scene);
  const std::vector<Real> weights = source_weights(comm, scene, grid, files.particles);
  const Slabs slabs = first_slabs(scene, grid, weights, size_of(comm));
  Particles particles = std::move(files.particles);
  migrate(comm, particles, &Particles::position, grid, slabs);
  const int rank = rank_of(comm);
  const auto owned =
      std::accumulate(weights.begin() + slabs.first_plane(rank), weights.begin() + slabs.last_plane(rank), 0.0);
  const int sharers = ranks_of_machine(comm);
  all_or_none(comm, [&] {
    const double bytes_of_state = 3 * sizeof(Vec3) + sizeof(GlobalId);
    require_memory(owned * sharers * bytes_of_state,
                   fmt::format("{}: {:.0f} particles on this machine", scene.path, owned * sharers),
                   "use more machines or a coarser fluid.spacing; --dry-run tells what a run needs");
  });
  // std::vector grows by doubling and would leave these arrays with up to twice the memory they need, for the whole
  // run.
  particles.for_each_field([&](auto& field) { field.reserve(static_cast<std::size_t>(owned)); });
  for (std::size_t s = 0; s < scene.particles.size(); ++s) {
    const ParticleSource& source = scene.particles[s];
    if (source.type != ParticleSource::Type::block) continue;
    const Lattice lattice(source, scene.fluid.spacing);
    for_each_layer(lattice, grid, [&](GlobalId layer, LocalId plane) {
      if (slabs.owner(plane) != rank) return;
      add_layer(particles, lattice, {grid.slab_axis(), layer}, source, files.first_id[s]);
    });
  }
  if (scene.colour == Colour::rainbow_x) add_hue(comm, particles);
  return particles;
}

Particles restored_particles(MPI_Comm comm, const Scene& scene, ParticleRows rows) {
  check_inside(comm, scene, rows, "the checkpoint");
  Particles particles = std::move(static_cast<Particles&>(rows));
  const bool had_hue = particles.has_hue;
  particles.has_hue = scene.colour == Colour::rainbow_x;
  if (particles.has_hue && !had_hue) {
    throw InputError(
        "the checkpoint has no /particles/hue, which [colour] by = \"rainbow_x\" needs; choose another "
        "colour with --set colour.by=rainbow_id");
  }
  if (!particles.has_hue) particles.hue.clear();
  return particles;
}

}  // namespace trevi
