#include "view/run_folder.hpp"

#include <cmath>
#include <cstdio>
#include <nlohmann/json.hpp>
#include <sstream>

#include "io/hdf5/hdf5_reader.hpp"
#include "io/run_directory/files.hpp"
#include "trevi/error.hpp"
#include "view/frame_reader.hpp"

namespace trevi {

namespace {

namespace fs = std::filesystem;

/// run.json; null if there is none, or only an incomplete one.
nlohmann::json report_of(const std::string& directory) {
  const std::string path = directory + "/run.json";
  return fs::exists(path) ? nlohmann::json::parse(read_text(path), nullptr, false) : nlohmann::json();
}

/// The scene file that run.json names, by which paths of music are resolved; empty if there is none.
std::string scene_path_of(const std::string& directory) {
  const auto json = report_of(directory);
  return json.is_object() ? json.value("scene", "") : "";
}

/// What run.json contains about the box; false if it contains nothing.
bool describe_by_report(const std::string& directory, ViewedScene& viewed) {
  try {
    const auto json = report_of(directory);
    for (std::size_t a = 0; a < 3; ++a) {
      viewed.min[static_cast<Eigen::Index>(a)] = json.at("domain").at("min").at(a);
      viewed.max[static_cast<Eigen::Index>(a)] = json.at("domain").at("max").at(a);
    }
    viewed.spacing = json.at("spacing");
    viewed.rest_density = json.at("rest_density");
    viewed.last_step = json.at("last_step");
    return (viewed.max - viewed.min).minCoeff() > 0 && viewed.spacing > 0;
  } catch (const nlohmann::json::exception&) {  // of another version
    return false;
  }
}

std::vector<std::string> columns_of(const std::string& line) {
  std::vector<std::string> columns;
  std::istringstream text(line);
  for (std::string column; std::getline(text, column, ',');) columns.push_back(column);
  return columns;
}

ViewedScene guess_from(const RawFrame& frame) {
  ViewedScene guess;
  if (frame.position.empty()) return guess;
  guess.min = guess.max = frame.position.front();
  for (const Vec3& p : frame.position) {
    guess.min = guess.min.cwiseMin(p);
    guess.max = guess.max.cwiseMax(p);
  }
  const Vec3 extent = (guess.max - guess.min).cwiseMax(1e-6);
  guess.spacing = std::cbrt(extent.prod() / static_cast<Real>(frame.position.size()));
  guess.max += Vec3(0, 0, 0.5 * extent.z());  // water may splash
  return guess;
}

}  // namespace

std::optional<Scene> find_scene(const std::string& directory, const std::string& scene_file) {
  if (!scene_file.empty()) {
    if (!fs::exists(scene_file)) throw InputError("--scene " + scene_file + ": no such file; check the path");
    return parse_scene(scene_file, read_text(scene_file), {});
  }
  try {
    const std::string path = scene_path_of(directory);
    const auto checkpoints = stepped_files(directory, checkpoint_files);
    if (!checkpoints.empty()) {
      const std::string text = Hdf5Reader(checkpoints.back().path).text("/scene");
      return parse_scene(path.empty() ? directory + "/scene.toml" : path, text, {});
    }
    if (fs::exists(path)) return parse_scene(path, read_text(path), {});
  } catch (const std::exception&) {  // being written at this moment, or of another version: the picture does without
  }
  return std::nullopt;
}

ViewedScene describe_run(const FrameList& list, const std::optional<Scene>& scene) {
  ViewedScene viewed;
  if (!scene && !describe_by_report(list.directory(), viewed)) {
    viewed = guess_from(read_raw(list.entries().front().path));
    std::fprintf(
        stderr,
        "trevi-view: %s tells of no scene and no box (no run.json, no checkpoint): the box is that of the first "
        "frame's particles; give --scene\n",
        list.directory().c_str());
  }
  viewed.name = fs::path(fs::absolute(list.directory())).lexically_normal().filename().string();
  viewed.directory = list.directory();
  if (!scene) return viewed;
  viewed.name = scene->name == "scene" ? viewed.name : scene->name;
  viewed.min = scene->domain.min;
  viewed.max = scene->domain.max;
  viewed.spacing = scene->fluid.spacing;
  viewed.rest_density = scene->fluid.rest_density;
  viewed.last_step = scene->steps();
  return viewed;
}

std::vector<FountainState> FountainSeries::at(std::int64_t step) {
  if (!states_.contains(step)) read();
  const auto found = states_.find(step);
  return found == states_.end() ? std::vector<FountainState>() : found->second;
}

void FountainSeries::read() {
  std::error_code error;
  const auto stamp = fs::last_write_time(path_, error);
  if (error || stamp == stamp_) return;
  stamp_ = stamp;
  std::istringstream text(read_text(path_));
  std::string line;
  std::getline(text, line);
  const auto header = columns_of(line);
  const auto first = static_cast<std::size_t>(std::find(header.begin(), header.end(), "note_0") - header.begin());
  while (first < header.size() && std::getline(text, line) && !text.eof()) {
    const auto row = columns_of(line);
    if (row.size() != header.size()) continue;
    auto& states = states_[std::atoll(row[0].c_str())];
    states.clear();
    for (std::size_t k = first; k + 1 < row.size(); k += 2)
      states.push_back({std::strtod(row[k].c_str(), nullptr), std::strtod(row[k + 1].c_str(), nullptr)});
  }
}

}  // namespace trevi
