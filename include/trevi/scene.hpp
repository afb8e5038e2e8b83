// A scene file, read, checked and converted to plain data. Nothing is built here, and no files are read except the
// scene and those that its obstacles name. All problems of the file are found in one pass and reported together, each
// with file, line, key and remedy. The same text gives the same Scene on all ranks.
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
  /// Block: in place of a velocity, expressions in x, y and z for each of its three components; none or three.
  std::vector<std::string> velocity_formulas;
  std::string surface;  ///< block: an expression in x and y for the height of its surface, m
  Real vortex = 0;      ///< block: speed of the vortex that is added, m/s
  int vortex_axis = 1;  ///< the second axis of the vortex, besides x: y, or z (2) in two dimensions
  std::string path;     ///< file, relative to the scene's folder
  bool operator==(const ParticleSource&) const = default;
};

/// The lines of the file on which the tables of a scene and some keys stand. The reader keeps them for messages about
/// problems that are found later.
class SceneLines {
 public:
  /// Always true, because the line of a table does not affect its meaning.
  bool operator==(const SceneLines&) const { return true; }

 private:
  friend class SceneTable;
  friend class SceneKey;
  std::map<std::string, std::vector<int>> lines_;
};

/// Settings of the solver, and everything else that a run needs.
struct Scene : Settings {
  std::string path, name;      ///< as given, and the file name without folder and ending
  std::string text;            ///< the file, plus one line "# --set table.key=value" for each override
  std::int64_t overrides = 0;  ///< number of these lines
  std::vector<ParticleSource> particles;
  Real end = 0;                    ///< s
  std::optional<Real> wall_limit;  ///< s
  std::string instruction_set;     ///< one of instruction_set_names(); empty: the best available
  std::optional<int> threads;      ///< of each rank
  SceneLines lines;

  std::int64_t steps() const;     ///< round(end/dt)
  std::string directory() const;  ///< of the program's files: output.directory, or out/NAME if that is empty

  bool operator==(const Scene&) const = default;
};

/// Reads the text of a scene. `overrides` are "table.key=value" with TOML values, applied in order.
/// Throws an InputError that lists every problem as "file:line: [table] key: what is wrong; remedy", one per line.
Scene parse_scene(const std::string& path, const std::string& text, const std::vector<std::string>& overrides);

/// Reads a scene file, including the meshes and motions of its obstacles, on one rank of `comm` for all. Collective.
/// Throws InputError on all ranks alike, as parse_scene() does.
Scene read_scene(MPI_Comm comm, const std::string& path, const std::vector<std::string>& overrides = {});

/// The particles of [[particles]] that lie in this rank's slab. Ids vary fastest along x within a block; the sources
/// follow in file order. Collective. Throws InputError for a file that cannot be used, particles outside the box, more
/// ranks than planes, or more particles than a rank can count.
Particles initial_particles(MPI_Comm comm, const Scene& scene);

/// As make_solver() of trevi/solver.hpp, but its InputErrors name the file and the line of what cannot be used. Its
/// checkpoints contain the scene, so that the program can restart from them.
std::unique_ptr<Solver> make_solver(MPI_Comm comm, const Scene& scene, Particles particles, SolverExtras extras = {});

/// The keys that a scene may use, with type and unit, one per line (for --help and the documentation test).
std::string scene_reference();

/// The speed profile given by an expression in z, m, and t, s (inputs/README.md, Expressions). Throws an InputError
/// that says what is wrong. Not to be called by several threads at once.
SpeedProfile speed_profile(const std::string& text);

}  // namespace trevi
