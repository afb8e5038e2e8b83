// What a run's directory contains besides its frames: the box, the music, and what the fountains did at each step. The
// scene comes from a given file, otherwise from the newest checkpoint, or from the scene that run.json names; without
// any of them the box is that of run.json, or, which is reported, that of the first frame's particles. Rank-local.
#pragma once

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "io/frames/viewed_frame.hpp"
#include "trevi/scene.hpp"
#include "view/frame_list.hpp"

namespace trevi {

/// The scene of a directory, with paths of its music resolved as far as possible; nothing if none is found. InputError
/// for a given `scene_file` that cannot be used.
std::optional<Scene> find_scene(const std::string& directory, const std::string& scene_file);

/// Box and spacing from the scene, or estimated from the particles of the first frame.
ViewedScene describe_run(const FrameList& list, const std::optional<Scene>& scene);

/// Notes and speeds of the fountains from DIR/series.csv, which may still grow, and may be missing.
class FountainSeries {
 public:
  explicit FountainSeries(const std::string& directory) : path_(directory + "/series.csv") {}
  std::vector<FountainState> at(std::int64_t step);

 private:
  void read();

  std::string path_;
  std::filesystem::file_time_type stamp_{};
  std::map<std::int64_t, std::vector<FountainState>> states_;
};

}  // namespace trevi
