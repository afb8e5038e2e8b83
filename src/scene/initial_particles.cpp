#include "scene/initial_particles.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>

#include "base/memory.hpp"
#include "domain/migrate.hpp"
#include "parallel/collective.hpp"
#include "parallel/core_share.hpp"
#include "parallel/reductions.hpp"
#include "scene/block_start.hpp"
#include "scene/free_places.hpp"
#include "scene/lattice.hpp"
#include "scene/scene_place.hpp"
#include "scene/scene_ranks.hpp"
#include "solver/first_slabs.hpp"
#include "solver/hue.hpp"
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

// A block of the scene with the ids of its points; those in obstacles are left out.
struct Block {
  const BlockStart& start;
  Lattice lattice;
  GlobalId first_id;
};

// The points in the rows [rows) of cells.
void add_layer(Particles& particles, const Block& block, const CellGrid& grid, GlobalId layer, const Range& rows) {
  for_each_point(block.lattice, grid.slab_axis(), layer, [&](GlobalId i, GlobalId j, GlobalId k) {
    const Vec3 point = block.lattice.point(i, j, k);
    const LocalId row = grid.row_of(point);
    if (row < rows.begin || row >= rows.end || !block.start.holds_water(point)) return;
    add_particle(particles, block.first_id + block.lattice.id(i, j, k), point, block.start.velocity(point));
  });
}

// Particles read from files, wherever they belong; ids already follow those of the previous sources.
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

// For two dimensions.
void check_layer(MPI_Comm comm, const ParticleRows& rows, const std::string& source) {
  all_or_none(comm, [&] {
    for (std::size_t i = 0; i < rows.position.size(); ++i) {
      if (rows.position[i].y() == 0 && rows.velocity[i].y() == 0) continue;
      throw InputError(
          fmt::format("{}: /particles: row {} is not in the plane y = 0, or leaves it; in two dimensions "
                      "write 0 for y of positions and velocities",
                      source, rows.first + static_cast<GlobalId>(i)));
    }
  });
}

void check_free(MPI_Comm comm, const FreePlaces& places, const ParticleRows& rows, const std::string& source) {
  all_or_none(comm, [&] {
    for (std::size_t i = 0; i < rows.position.size(); ++i) {
      const int k = places.solid_at(rows.position[i]);
      if (k < 0) continue;
      throw InputError(fmt::format("{}: /particles/position: row {} is in {} of the scene; move the particle", source,
                                   rows.first + static_cast<GlobalId>(i), places.name_of(k)));
    }
  });
}

// Returns the number of ids that the rows occupy, from 0 to the largest.
GlobalId append_file(MPI_Comm comm, const Scene& scene, const ParticleSource& source, const FreePlaces& places,
                     FileParticles& files) {
  const std::string& path = source.path;
  const GlobalId first_id = files.first_id.back();
  const ParticleRows rows = read_particle_file(comm, path);
  if (rows.total == 0) throw InputError(path + ": /particles/position: no particles; write one row for each");
  if (scene.fluid.dimensions == 2) check_layer(comm, rows, path);
  check_inside(comm, scene, rows, path);
  check_free(comm, places, rows, path);
  append_rows(files.particles, rows, first_id);
  GlobalId last = -1;
  for (const GlobalId id : rows.id) last = std::max(last, id);
  MPI_Allreduce(MPI_IN_PLACE, &last, 1, MPI_INT64_T, MPI_MAX, comm);
  return last + 1;
}

FileParticles read_files(MPI_Comm comm, const Scene& scene, const FreePlaces& places) {
  FileParticles result;
  GlobalId next_id = 0;
  for (std::size_t k = 0; k < scene.particles.size(); ++k) {
    const ParticleSource& source = scene.particles[k];
    result.first_id.push_back(next_id);
    next_id += source.type == ParticleSource::Type::block ? Lattice(source, scene.fluid.spacing).size()
                                                          : told_at(scene, {"particles", k}, "path", [&] {
                                                              return append_file(comm, scene, source, places, result);
                                                            });
    if (next_id > end_of_ids) {
      throw InputError(scene.path +
                       ": ids of all [[particles]] together pass 2^62; leave /particles/id out of the files "
                       "to number their rows");
    }
  }
  return result;
}

// What a scene starts with: sources of particles, and where they may be.
struct Sources {
  const Scene& scene;
  const CellGrid& grid;
  const FreePlaces& places;
  const FileParticles& files;
};

// Calls visit(block, number of the source) for those sources that are blocks.
template <class Visit>
void for_each_block(const Scene& scene, const FreePlaces& places, const std::vector<GlobalId>& first_id,
                    const Visit& visit) {
  for (std::size_t k = 0; k < scene.particles.size(); ++k) {
    const ParticleSource& source = scene.particles[k];
    if (source.type != ParticleSource::Type::block) continue;
    told_at(scene, {"particles", k}, "", [&] {
      const BlockStart start(source, places);
      visit(Block{start, Lattice(source, scene.fluid.spacing), first_id[k]});
    });
  }
}

// Number of particles of blocks in each plane. Where some places have no water, ranks take turns with the layers.
std::vector<Real> block_weights(MPI_Comm comm, const Scene& scene, const CellGrid& grid, const FreePlaces& places,
                                const std::vector<GlobalId>& first_id) {
  std::vector<GlobalId> count(static_cast<std::size_t>(grid.planes()), 0);
  const int axis = grid.slab_axis(), rank = rank_of(comm), ranks = size_of(comm);
  all_or_none(comm, [&] {
    for_each_block(scene, places, first_id, [&](const Block& block) {
      const GlobalId in_layer = block.lattice.size() / block.lattice.count[static_cast<std::size_t>(axis)];
      for_each_layer(block.lattice, grid, [&](GlobalId layer, LocalId plane) {
        if (layer % ranks != rank) return;
        count[static_cast<std::size_t>(plane)] +=
            block.start.is_whole() ? in_layer : block.start.count(block.lattice, axis, layer);
      });
    });
  });
  count = sum_over_ranks(comm, count);
  return {count.begin(), count.end()};
}

// The same in each row of slabs, for the layers that this rank is responsible for.
void add_block_weights(MPI_Comm comm, const Sources& sources, const Slabs& slabs, RowWeights& weights) {
  const CellGrid& grid = sources.grid;
  const auto rows = static_cast<std::size_t>(grid.rows());
  const int rank = rank_of(comm), ranks = size_of(comm);
  all_or_none(comm, [&] {
    for_each_block(sources.scene, sources.places, sources.files.first_id, [&](const Block& block) {
      for_each_layer(block.lattice, grid, [&](GlobalId layer, LocalId plane) {
        if (layer % ranks != rank) return;
        std::vector<Real>& of_slab = weights[slabs.slab_of(plane)];
        of_slab.resize(rows);
        for_each_point(block.lattice, grid.slab_axis(), layer, [&](GlobalId i, GlobalId j, GlobalId k) {
          const Vec3 point = block.lattice.point(i, j, k);
          of_slab[static_cast<std::size_t>(grid.row_of(point))] +=
              block.start.is_whole() || block.start.holds_water(point) ? 1 : 0;
        });
      });
    });
  });
}

// The same with particles from files, which may be on any rank.
CellWeights source_weights(MPI_Comm comm, const Sources& sources) {
  const auto& [scene, grid, places, files] = sources;
  std::vector<Real> weights = plane_weights(comm, grid, files.particles);
  const std::vector<Real> blocks = block_weights(comm, scene, grid, places, files.first_id);
  for (std::size_t k = 0; k < weights.size(); ++k) weights[k] += blocks[k];
  if (!scene.particles.empty() && std::accumulate(weights.begin(), weights.end(), 0.0) == 0)
    throw InputError(SceneTable("particles", 0).place_in(scene, "") +
                     "no particle of any [[particles]] is left outside of the obstacles and below the surface; move "
                     "them");
  return {std::move(weights), [=, &sources](const Slabs& slabs) {
            RowWeights rows;
            add_row_weights(sources.grid, slabs, sources.files.particles, rows);
            add_block_weights(comm, sources, slabs, rows);
            return rows;
          }};
}

}  // namespace

Slabs initial_slabs(MPI_Comm comm, const Scene& scene, const CellGrid& grid, std::vector<Real>& weights) {
  const FreePlaces places(scene);
  const FileParticles files = read_files(comm, scene, places);
  const Sources sources{scene, grid, places, files};
  const CellWeights of_cells = source_weights(comm, sources);
  weights = of_cells.planes;
  return slabs_of(comm, scene, grid, of_cells);
}

Particles initial_particles(MPI_Comm comm, const Scene& scene) {
  const CellGrid grid = cell_grid(scene, scene.domain);
  const FreePlaces places(scene);
  FileParticles files = read_files(comm, scene, places);
  const Sources sources{scene, grid, places, files};
  const CellWeights weights = source_weights(comm, sources);
  const Slabs slabs = slabs_of(comm, scene, grid, weights);
  Particles particles = std::move(files.particles);
  migrate(comm, particles, &Particles::position, grid, slabs);
  const CellWindow own = slabs.window(rank_of(comm), grid.rows());
  const auto owned =
      std::accumulate(weights.planes.begin() + own.planes.begin, weights.planes.begin() + own.planes.end, 0.0) /
      slabs.parts();
  const int sharers = ranks_of_machine(comm);
  all_or_none(comm, [&] {
    const double bytes_of_state = 3 * sizeof(Vec3) + sizeof(GlobalId);
    require_memory(owned * sharers * bytes_of_state,
                   fmt::format("{}: {:.0f} particles on this machine", scene.path, owned * sharers),
                   "use more machines or a coarser fluid.spacing; --dry-run tells what a run needs");
  });
  // std::vector grows by doubling and would leave these arrays with up to twice the memory that they need, for the
  // whole run.
  particles.for_each_field([&](auto& field) { field.reserve(static_cast<std::size_t>(owned)); });
  all_or_none(comm, [&] {
    for_each_block(scene, places, files.first_id, [&](const Block& block) {
      for_each_layer(block.lattice, grid, [&](GlobalId layer, LocalId plane) {
        if (plane >= own.planes.begin && plane < own.planes.end) add_layer(particles, block, grid, layer, own.rows);
      });
    });
  });
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
  const CellGrid grid = cell_grid(scene, scene.domain);
  const auto of_rows = [&](const Slabs& slabs) {
    RowWeights weights;
    add_row_weights(grid, slabs, particles, weights);
    return weights;
  };
  slabs_of(comm, scene, grid, {plane_weights(comm, grid, particles), of_rows});  // refuses what is not possible
  return particles;
}

}  // namespace trevi
