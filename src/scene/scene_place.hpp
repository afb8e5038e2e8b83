// For files that a scene names: an error in one is reported with the place in the scene that names it.
#pragma once

#include <string>
#include <utility>

#include "trevi/error.hpp"
#include "trevi/scene.hpp"

namespace trevi {

/// Does `work` for a key of the table that begins at `line` (0: it came from --set); its InputErrors gain this place.
template <class Work>
auto told_at(const Scene& scene, int line, const std::string& key, Work&& work) {
  try {
    return std::forward<Work>(work)();
  } catch (const InputError& error) {
    const std::string number = line > 0 ? ":" + std::to_string(line) : "";
    throw InputError(scene.path + number + ": " + key + ": " + error.what());
  }
}

}  // namespace trevi
