// A scene file, read, checked and turned into plain data. Nothing is built here, and no file is read but the scene and
// those that its obstacles name.
// Every problem of the file is found in one pass and reported together, each with file, line, key and remedy.
// The same text gives the same Scene on all ranks.
#pragma once

#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "trevi/particles.hpp"
#include "trevi/session.hpp"
#include "trevi/settings.hpp"
#include "trevi/solver.hpp"
#include "trevi/types.hpp"

namespace trevi {

struct ParticleSource {
  enum class Type { block, file } type = Type::block;
  Vec3 min = Vec3::Zero(), max = Vec3::Zero();  ///< m, block
  Vec3 velocity = Vec3::Zero();                 ///< m/s, block
  /// Block: in place of a velocity, expressions of x, y and z for each of its three coordinates; none or three.
  std::vector<std::string> velocity_formulas;
  std::string surface;  ///< block: an expression of x and y for the height of its surface, m
  Real vortex = 0;      ///< m/s, block: of the vortex that is added
  int vortex_axis = 1;  ///< of the vortex, beside x: y, or z (2) in two dimensions
  std::string path;     ///< file, resolved against the scene's folder
  bool operator==(const ParticleSource&) const = default;
};

/// Where the tables of a scene, and some keys, are in its file. Of the reader, for messages about what is found later.
class SceneLines {
 public:
  /// Where a table is says nothing of what it means.
  bool operator==(const SceneLines&) const { return true; }

 private:
  friend class SceneTable;
  friend class SceneKey;
  std::map<std::string, std::vector<int>> lines_;
};

/// Settings of the solver and all that a run needs besides.
struct Scene : Settings {
  std::string path, name;      ///< as given, and the file name without folder and ending
  std::string text;            ///< the file, plus one line "# --set table.key=value" for each override
  std::int64_t overrides = 0;  ///< number of these lines
  std::vector<ParticleSource> particles;
  Real end = 0;                    ///< s
  std::optional<Real> wall_limit;  ///< s
  std::string instruction_set;     ///< one of instruction_set_names(); empty: the best
  std::optional<int> threads;      ///< of each rank
  SceneLines lines;

  std::int64_t steps() const;     ///< round(end/dt)
  std::string directory() const;  ///< of the program's files: output.directory, or out/NAME where that is empty

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

/// As make_solver() of trevi/solver.hpp, with the file and the line of what cannot be used in its InputErrors. A
/// checkpoint of its output knows the scene, so that the program can go on from it.
std::unique_ptr<Solver> make_solver(MPI_Comm comm, const Scene& scene, Particles particles, SolverExtras extras = {});

/// Keys a scene may use, with type and unit, one a line (for --help and the documentation test).
std::string scene_reference();

/// From an expression of z, m, and t, s (inputs/README.md, Expressions). Throws InputError that says what is wrong. Not
/// for several threads at once.
SpeedProfile speed_profile(const std::string& text);

}  // namespace trevi
