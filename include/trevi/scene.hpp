// A scene file, read, checked and turned into plain data. Nothing is built here, and no file is read but the scene and
// those that its obstacles name.
// Every problem of the file is found in one pass and reported together, each with file, line, key and remedy.
// The same text gives the same Scene on all ranks.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "trevi/clock.hpp"
#include "trevi/colour.hpp"
#include "trevi/forcing.hpp"
#include "trevi/particles.hpp"
#include "trevi/session.hpp"
#include "trevi/settings.hpp"
#include "trevi/types.hpp"

namespace trevi {

class InflowOutflow;

struct ParticleSource {
  enum class Type { block, file } type = Type::block;
  Vec3 min = Vec3::Zero(), max = Vec3::Zero();  ///< m, block
  Vec3 velocity = Vec3::Zero();                 ///< m/s, block
  /// Block: in place of a velocity, expressions of x, y and z for each of its three coordinates; none or three.
  std::vector<std::string> velocity_formulas;
  std::string surface;  ///< block: an expression of x and y for the height of its surface, m
  Real vortex = 0;      ///< m/s, block: of the vortex that is added
  std::string path;     ///< file, resolved against the scene's folder
  int line = 0;         ///< of the table in the scene file, for later messages
  bool operator==(const ParticleSource&) const = default;
};

struct FrameSettings {  ///< [output.vtu] and [output.vtkhdf]
  Schedule schedule;
  std::vector<std::string> fields = {"velocity", "density", "id"};
  bool operator==(const FrameSettings&) const = default;
};

struct CheckpointSettings {
  Schedule schedule;  ///< may be never: then the start and the end only
  int keep = 2;
  bool operator==(const CheckpointSettings&) const = default;
};

struct OutputSettings {
  std::string directory;  ///< relative to the working directory; default out/SCENE
  std::optional<FrameSettings> vtu, vtkhdf;
  std::optional<CheckpointSettings> checkpoint;
  std::optional<Schedule> series;
  bool operator==(const OutputSettings&) const = default;
};

/// Settings of the solver and all that a run needs besides.
struct Scene : Settings {
  std::string path, name;      ///< as given, and the file name without folder and ending
  std::string text;            ///< the file, plus one line "# --set table.key=value" for each override
  std::int64_t overrides = 0;  ///< number of these lines
  std::vector<ParticleSource> particles;
  Real end = 0;  ///< s
  std::vector<FountainSettings> fountains;
  std::vector<InletSettings> inlets;
  std::vector<DrainSettings> drains;
  OutputSettings output;
  std::optional<Colour> colour;
  std::uint64_t seed = 1;
  std::optional<Real> wall_limit;  ///< s
  std::string instruction_set;     ///< one of instruction_set_names(); empty: the best
  std::optional<int> threads;      ///< of each rank

  std::int64_t steps() const;  ///< round(end/dt)

  bool operator==(const Scene&) const = default;
};

/// Reads the text of a scene. `overrides` are "table.key=value" with TOML values, applied in order.
/// Throws InputError that lists every problem as "file:line: [table] key: what is wrong; remedy", one a line.
Scene parse_scene(const std::string& path, const std::string& text, const std::vector<std::string>& overrides);

/// Reads a scene file, meshes and motions of its obstacles included, on one rank of `comm` for all. Collective.
/// InputError on all ranks alike, as parse_scene().
Scene read_scene(MPI_Comm comm, const std::string& path, const std::vector<std::string>& overrides = {});

/// The particles of [[particles]], those of this rank's slab; ids x fastest within a block, sources in file order.
/// Collective. InputError for a file that cannot be used, particles outside the box, more ranks than planes, or more
/// particles than a rank can count.
Particles initial_particles(MPI_Comm comm, const Scene& scene);

/// The fountains with their music, in the order of the scene. Collective. InputError for music that cannot be used.
std::vector<std::unique_ptr<Forcing>> make_fountains(MPI_Comm comm, const Scene& scene);

/// The inlets and drains of the scene, null without any; for SolverExtras::flow. Collective. InputError for music that
/// cannot be used.
std::shared_ptr<InflowOutflow> make_flow(MPI_Comm comm, const Scene& scene);

/// Keys a scene may use, with type and unit, one a line (for --help and the documentation test).
std::string scene_reference();

}  // namespace trevi
