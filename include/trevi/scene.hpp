// A scene file, read, checked and turned into plain data. Nothing is built here and no file but the scene is read.
// Every problem of the file is found in one pass and reported together, each with file, line, key and remedy.
// The same text gives the same Scene on all ranks.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "trevi/clock.hpp"
#include "trevi/colour.hpp"
#include "trevi/settings.hpp"
#include "trevi/types.hpp"

namespace trevi {

struct ParticleSource {
  enum class Type { block, file } type = Type::block;
  Vec3 min = Vec3::Zero(), max = Vec3::Zero();  ///< m, block
  Vec3 velocity = Vec3::Zero();                 ///< m/s, block
  std::string path;                             ///< file, resolved against the scene's folder
  int line = 0;                                 ///< of the table in the scene file, for later messages
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
  std::string directory;  ///< relative to the working directory; default out/<scene name>
  std::optional<FrameSettings> vtu, vtkhdf;
  std::optional<CheckpointSettings> checkpoint;
  std::optional<Schedule> series;
  bool operator==(const OutputSettings&) const = default;
};

/// Who owns which planes: as even a share of the work as whole planes allow, throughout; or as many planes each.
enum class SlabCuts { balanced, equal };

struct Scene {
  std::string path, name;      ///< as given, and the file name without folder and ending
  std::string text;            ///< the file, plus one line "# --set table.key=value" for each override
  std::int64_t overrides = 0;  ///< number of these lines
  Vec3 domain_min = Vec3::Zero(), domain_max = Vec3::Zero();  ///< m
  int slab_axis = 0;                                          ///< 0 x, 1 y
  SlabCuts slabs = SlabCuts::balanced;
  FluidSettings fluid;
  std::vector<ParticleSource> particles;
  Real dt = 1.0 / 60, end = 0;  ///< s
  Real cfl = 0;                 ///< 0: steps are never split
  std::optional<Vec3> gravity;  ///< m/s²
  DensitySettings density;
  WallSettings walls;
  std::optional<TensileSettings> tensile;
  std::optional<Real> vorticity;  ///< epsilon of vorticity confinement
  std::optional<Real> viscosity;  ///< c of XSPH, m³/kg, a share per step
  /// nu, m²/s, by XSPH as well: at most one of the two. A step is at most longest_viscous_step(), or split by the CFL
  /// rule.
  std::optional<Real> kinematic_viscosity;
  std::vector<FountainSettings> fountains;
  OutputSettings output;
  std::optional<Colour> colour;
  std::uint64_t seed = 1;
  std::optional<Real> wall_limit;  ///< s
  std::string instruction_set;     ///< one of instruction_set_names(); empty: the best

  std::int64_t steps() const;  ///< round(end/dt)

  bool operator==(const Scene&) const = default;
};

/// Reads the text of a scene. `overrides` are "table.key=value" with TOML values, applied in order.
/// Throws InputError that lists every problem as "file:line: [table] key: what is wrong; remedy", one a line.
Scene parse_scene(const std::string& path, const std::string& text, const std::vector<std::string>& overrides);

/// Keys a scene may use, with type and unit, one a line (for --help and the documentation test).
std::string scene_reference();

}  // namespace trevi
