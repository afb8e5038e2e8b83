// For problems that are found after a scene was read, for instance in files that it refers to: an error is reported
// with the place in the scene that refers to them. Not collective.
#pragma once

#include <string>
#include <utility>

#include "trevi/error.hpp"
#include "trevi/scene.hpp"

namespace trevi {

/// A table of a list: {"fountain", 0} is the first [[fountain]] that was read into the scene.
class SceneTable {
 public:
  SceneTable(const char* list, std::size_t index) : list_(list), index_(index) {}

  /// To be called when an element of the list is read; 0: it came from --set.
  static void add(Scene& scene, const char* list, int line) { scene.lines.lines_[list].push_back(line); }
  /// The line in the scene file; 0 if it is not in the file.
  int line_in(const Scene& scene) const;
  /// "scene.toml:12: [[fountain]] music: " for the key "music"; the key may be empty.
  std::string place_in(const Scene& scene, const std::string& key) const;

 private:
  std::string list_;
  std::size_t index_;
};

/// A key of a table that exists once: {"domain", "ranks"}.
class SceneKey {
 public:
  constexpr SceneKey(const char* table, const char* key) : table_(table), key_(key) {}

  /// To be called when it is read; 0: it came from --set.
  void add(Scene& scene, int line) const { scene.lines.lines_[name()] = {line}; }
  /// "scene.toml:12: [domain] ranks: ", without the line if the key is not in the file.
  std::string place_in(const Scene& scene) const;

 private:
  std::string name() const { return std::string(table_) + "." + key_; }
  const char *table_, *key_;
};

/// Does `work` for a key; its InputErrors are given this place.
template <class Work>
auto told_at(const Scene& scene, const SceneKey& key, Work&& work) {
  try {
    return std::forward<Work>(work)();
  } catch (const InputError& error) {
    throw InputError(key.place_in(scene) + error.what());
  }
}

/// The same for a key of a table in a list.
template <class Work>
auto told_at(const Scene& scene, const SceneTable& table, const std::string& key, Work&& work) {
  try {
    return std::forward<Work>(work)();
  } catch (const InputError& error) {
    throw InputError(table.place_in(scene, key) + error.what());
  }
}

}  // namespace trevi
