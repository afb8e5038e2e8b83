#include "scene/scene_place.hpp"

namespace trevi {

int SceneTable::line_in(const Scene& scene) const {
  const auto lines = scene.lines.lines_.find(list_);
  return lines != scene.lines.lines_.end() && index_ < lines->second.size() ? lines->second[index_] : 0;
}

std::string SceneTable::place_in(const Scene& scene, const std::string& key) const {
  const int line = line_in(scene);
  const bool paddle = list_ == "obstacle" && index_ < scene.obstacles.size() && scene.obstacles[index_].wavemaker;
  return scene.path + (line > 0 ? ":" + std::to_string(line) : "") + ": [[" + (paddle ? "wavemaker" : list_) + "]]" +
         (key.empty() ? "" : " ") + key + ": ";
}

std::string SceneKey::place_in(const Scene& scene) const {
  const auto lines = scene.lines.lines_.find(name());
  const int line = lines != scene.lines.lines_.end() ? lines->second.front() : 0;
  return scene.path + (line > 0 ? ":" + std::to_string(line) : "") + ": [" + table_ + "] " + key_ + ": ";
}

}  // namespace trevi
