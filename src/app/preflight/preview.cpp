#include "app/preflight/preview.hpp"

#include <fmt/format.h>

#include <cmath>
#include <filesystem>
#include <fstream>

#include "app/build.hpp"
#include "io/run_directory/files.hpp"
#include "parallel/collective.hpp"
#include "scene/scene_flow.hpp"
#include "trevi/error.hpp"

namespace trevi {

namespace fs = std::filesystem;

namespace {

std::string number(Real value) { return std::isnan(value) ? "nan" : fmt::format("{}", value); }

constexpr const char* first_columns = "time,note_0,speed_0";

// Only an older preview may be replaced: the file may be a mistyped name, for instance that of the scene itself.
void check_target(const std::string& path) {
  if (!fs::exists(path)) return;
  std::ifstream file(path);
  std::string line;
  if (fs::is_regular_file(path)) std::getline(file, line);
  if (!line.starts_with(first_columns)) {
    throw InputError("--preview " + path + ": is there already and is no preview; choose another name");
  }
}

}  // namespace

void write_preview(const Session& session, const Scene& scene, const PreviewOptions& options) {
  if (scene.fountains.empty()) throw InputError(scene.path + ": no [[fountain]] to preview; add one");
  const std::vector<std::unique_ptr<Fountain>> forcings = make_scene_flow(session.comm(), scene).fountains;
  std::string text = "time";
  for (std::size_t k = 0; k < scene.fountains.size(); ++k) text += fmt::format(",note_{0},speed_{0}", k);
  for (Clock clock{0, scene.dt, 1}; clock.step <= options.last_step; ++clock.step) {
    text += "\n" + number(clock.time());
    for (const auto& forcing : forcings) {
      if (const auto state = forcing->state(clock.time()))
        text += "," + number(state->note) + "," + number(state->speed);
    }
    for (const auto& forcing : forcings) forcing->prepare({clock.step, 0, clock.time(), clock.dt});
  }
  on_root(session.comm(), [&] { check_target(options.file); });
  on_root(session.comm(), [&] { replace_file(options.file, text + "\n"); });
}

}  // namespace trevi
