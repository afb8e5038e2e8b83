// For what is found after a scene was read, in files that it names for instance: an error is reported with the place in
// the scene that names it. Not collective.
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
  /// In the file of the scene; 0 where it is in none.
  int line_in(const Scene& scene) const;
  /// "scene.toml:12: [[fountain]] music: " for the key "music"; the key may be empty.
  std::string place_in(const Scene& scene, const std::string& key) const;

 private:
  std::string list_;
  std::size_t index_;
};

/// Does `work` for a key of the table; its InputErrors gain this place.
template <class Work>
auto told_at(const Scene& scene, const SceneTable& table, const std::string& key, Work&& work) {
  try {
    return std::forward<Work>(work)();
  } catch (const InputError& error) {
    throw InputError(table.place_in(scene, key) + error.what());
  }
}

}  // namespace trevi
