#include "scene/scene_changes.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <sstream>

#include "base/hash.hpp"
#include "base/version.hpp"
#include "scene/obstacle_files.hpp"
#include "scene/scene_overrides.hpp"
#include "scene/scene_place.hpp"
#include "trevi/error.hpp"
#include "trevi/session.hpp"

namespace trevi {
namespace {

constexpr std::string_view override_mark = "# --set ";

struct Value {
  std::string text;
  std::string origin;  ///< "scene.toml:12" or "--set time.end=2"
  bool by_override = false;
};

/// "fluid.spacing", "particles.0.min" and so on, with their values.
using Values = std::map<std::string, Value>;

std::string text_of(const toml::node& node) {
  // In a single format, so that 1, 1.0 and 1e0 are the same.
  if (const auto* real = node.as_floating_point()) return fmt::format("{}", real->get());
  if (const auto* array = node.as_array()) {
    std::string all;
    for (const toml::node& element : *array) all += fmt::format("{}{}", all.empty() ? "" : ", ", text_of(element));
    return fmt::format("[{}]", all);
  }
  std::ostringstream text;
  text << toml::node_view<const toml::node>(node);
  return text.str();
}

void collect(const toml::node& node, const std::string& path, Values& values) {
  const std::string dot = path.empty() ? "" : path + '.';
  const toml::array* array = node.as_array();
  if (const toml::table* table = node.as_table()) {
    for (auto&& [key, child] : *table) collect(child, dot + std::string(key.str()), values);
  } else if (array && array->is_array_of_tables()) {
    for (std::size_t k = 0; k < array->size(); ++k) collect((*array)[k], dot + std::to_string(k), values);
  } else {
    const auto& source = node.source();
    const std::string file = source.path ? *source.path : "";
    const bool by_override = file.starts_with("--set ");
    values[path] = {text_of(node), by_override ? file : fmt::format("{}:{}", file, source.begin.line), by_override};
  }
}

struct SceneText {
  std::string path, text;
  std::int64_t overrides;  ///< lines at the end of the text
};

/// The overrides at the end of a text, in order; they are removed from the text.
std::vector<std::string> extract_overrides(SceneText& scene) {
  std::vector<std::string> overrides(static_cast<std::size_t>(scene.overrides));
  for (auto assignment = overrides.rbegin(); assignment != overrides.rend(); ++assignment) {
    if (scene.text.ends_with('\n')) scene.text.pop_back();
    const std::size_t newline = scene.text.rfind('\n');
    const std::size_t start = newline == std::string::npos ? 0 : newline + 1;
    const std::string line = scene.text.substr(start);
    if (!line.starts_with(override_mark)) throw InputError(scene.path + ": /scene: does not end with its overrides");
    *assignment = line.substr(override_mark.size());
    scene.text.resize(start);
  }
  return overrides;
}

Values values_of(SceneText scene) {
  Findings findings(scene.path);
  const std::vector<std::string> overrides = extract_overrides(scene);
  const toml::table document = read_document(scene.path, scene.text, overrides, findings);
  findings.throw_if_any();
  Values values;
  collect(document, "", values);
  return values;
}

bool may_change(const std::string& path) {
  if (path == "time.end" || path == "domain.ranks") return true;
  for (const std::string_view table : {"output.", "colour.", "run."}) {
    if (path.starts_with(table)) return true;
  }
  return false;
}

bool holds(const Values& values, const std::string& path, std::string_view word) {
  const auto found = values.find(path);
  return found != values.end() && found->second.text.find(word) != std::string::npos;
}

/// Whether a particle has the mass rho0 s³ with any kernel: the report's preset implies it, too.
bool has_mass_of_volume(const Values& values) {
  return values.contains("fluid.mass") ? holds(values, "fluid.mass", "volume")
                                       : holds(values, "density.preset", "report");
}

/// Why not even --set may change it; empty if it may. `by_volume`: whether the mass follows from the volume, then and
/// now.
std::string why_never(const std::string& path, std::pair<bool, bool> by_volume) {
  if (path == "time.dt") return "steps of another length need a run of their own";
  if (path == "fluid.spacing") return "the particles of the checkpoint have the mass and the size of their lattice";
  if (path == "fluid.rest_density") return "it would change the mass of the particles in the checkpoint";
  if ((path == "fluid.mass" || path == "density.preset") && by_volume.first != by_volume.second)
    return "it would change the mass of the particles in the checkpoint";
  if (path == "fluid.kernel_radius" || path == "fluid.density_kernel")
    return "it would change the density of the water in the checkpoint; steps with another kernel need a run of their "
           "own";
  if (path == "domain.dimensions") return "the particles of the checkpoint are not those of another space";
  if (path.starts_with("particles.")) return "a restart has its particles from the checkpoint; put it back";
  return {};
}

/// A file that the scene refers to, by the first of these keys; the others say how it is read.
struct NamedFile {
  std::string name;
  std::vector<std::string> keys;
};

std::vector<NamedFile> music_files(const Scene& scene) {
  std::vector<NamedFile> files;
  const auto add = [&](const PumpSettings& pump, const char* table, std::size_t k) {
    files.push_back({pump.music ? pump.music->source : "", {fmt::format("{}.{}.music", table, k)}});
  };
  for (std::size_t k = 0; k < scene.fountains.size(); ++k) add(scene.fountains[k], "fountain", k);
  for (std::size_t k = 0; k < scene.inlets.size(); ++k) add(scene.inlets[k], "inlet", k);
  return files;
}

std::vector<NamedFile> obstacle_files(const Scene& scene) {
  std::vector<NamedFile> files;
  for (std::size_t k = 0; k < scene.obstacles.size(); ++k) {
    const std::string table = fmt::format("obstacle.{}.", k);
    files.push_back({scene.obstacles[k].path, {table + "path", table + "scale"}});
    files.push_back({scene.obstacles[k].motion, {table + "motion"}});
  }
  for (std::size_t k = 0; k < scene.bodies.size(); ++k) {
    const std::string table = fmt::format("body.{}.", k);
    files.push_back({scene.bodies[k].path, {table + "path", table + "scale"}});
    files.push_back({"", {}});
  }
  return files;
}

/// Sorts the changes into those that are allowed and those that are not.
class Comparison {
 public:
  Comparison(const Values& then, const Values& now)
      : then_(then), now_(now), by_volume_(has_mass_of_volume(then), has_mass_of_volume(now)) {}

  /// Files whose content has changed although no key says that it may.
  void add_files(const std::vector<NamedFile>& files, const std::vector<std::int64_t>& then,
                 const std::vector<std::int64_t>& now) {
    for (std::size_t k = 0; k < std::min({files.size(), then.size(), now.size()}); ++k) {
      const std::vector<std::string>& keys = files[k].keys;
      if (keys.empty()) continue;
      const bool same_keys = std::all_of(keys.begin(), keys.end(), [&](const auto& key) { return is_as_before(key); });
      if (then[k] == now[k] || !same_keys) continue;
      refused.push_back(
          fmt::format("{}: {}: not what the run has had so far; put the file back, or say --set {} with a new name",
                      files[k].name, keys.front(), keys.front()));
    }
  }

  void add(const std::string& path, const Value* then, const Value* now) {
    const std::string change =
        fmt::format("{}: {} -> {}", path, then ? then->text : "(absent)", now ? now->text : "(absent)");
    const bool asked_for = now && now->by_override;
    const std::string never = why_never(path, by_volume_);
    if (may_change(path) || (asked_for && never.empty())) {
      allowed.push_back(change);
      return;
    }
    const std::string where = now ? now->origin + ": " : "";
    std::string remedy = then && then->by_override ? fmt::format("say {} again", then->origin) : "put it back";
    if (now) remedy += fmt::format(", or say --set {}={}", path, now->text);
    refused.push_back(fmt::format("{}{}; {}", where, change, never.empty() ? remedy : never));
  }
  std::vector<std::string> allowed, refused;

 private:
  bool is_as_before(const std::string& path) const {
    const auto then = then_.find(path), now = now_.find(path);
    if (then == then_.end() || now == now_.end()) return then == then_.end() && now == now_.end();
    return then->second.text == now->second.text;
  }

  const Values& then_;
  const Values& now_;
  std::pair<bool, bool> by_volume_;
};

}  // namespace

std::vector<std::int64_t> music_checksums(MPI_Comm comm, const Scene& scene) {
  std::vector<std::int64_t> sums;
  const auto add = [&](const PumpSettings& pump, const SceneTable& table) {
    const bool has_file = pump.music && pump.music->source != "-";
    const auto read = [&] { return checksum(read_file_everywhere(comm, pump.music->source)); };
    sums.push_back(has_file ? told_at(scene, table, "music", read) : 0);
  };
  for (std::size_t k = 0; k < scene.fountains.size(); ++k) add(scene.fountains[k], {"fountain", k});
  for (std::size_t k = 0; k < scene.inlets.size(); ++k) add(scene.inlets[k], {"inlet", k});
  return sums;
}

CheckpointInfo checkpoint_info(MPI_Comm comm, const Scene& scene) {
  return {scene.text,
          trevi_version(),
          static_cast<std::int64_t>(scene.seed),
          scene.overrides,
          music_checksums(comm, scene),
          obstacle_checksums(scene)};
}

std::vector<std::string> scene_changes(const CheckpointInfo& info, const std::string& checkpoint_path,
                                       const Scene& scene, const CheckpointInfo& now) {
  const Values before = values_of({checkpoint_path, info.scene_text, info.scene_overrides});
  const Values after = values_of({scene.path, scene.text, scene.overrides});
  Comparison comparison(before, after);
  for (const auto& [path, value] : after) {
    const auto old = before.find(path);
    if (old == before.end()) comparison.add(path, nullptr, &value);
    if (old != before.end() && old->second.text != value.text) comparison.add(path, &old->second, &value);
  }
  for (const auto& [path, value] : before) {
    if (!after.contains(path)) comparison.add(path, &value, nullptr);
  }
  comparison.add_files(music_files(scene), info.music, now.music);
  comparison.add_files(obstacle_files(scene), info.obstacle_files, now.obstacle_files);
  if (comparison.refused.empty()) return comparison.allowed;
  std::string all = checkpoint_path + ": made with another scene; a restart may not change the physics:";
  for (const std::string& change : comparison.refused) all += "\n  " + change;
  throw InputError(all);
}

}  // namespace trevi
