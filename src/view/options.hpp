// The arguments of trevi-view.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "view/painter.hpp"

namespace trevi {

struct ViewOptions {
  std::string target;                      ///< directory, list of frames, or scene (.toml) to run
  std::string listen;                      ///< HOST:PORT at which a directory's run is expected; empty: do not listen
  int ranks = 1;                           ///< of a run that is started
  std::vector<std::string> run_arguments;  ///< for the solver, as given
  std::string scene;                       ///< file; for a directory without this information
  Style style = Style::points;
  Colour colour = Colour::rainbow;  ///< replaced by the scene's own if the run or its frames have one
  bool colour_given = false;
  int width = 1280, height = 720;
  CameraPose camera;
  double speed = 1;
  bool loop = false, paused = false, mute = false;
  bool all = false;                 ///< include particles that cannot be seen
  std::int64_t budget = 0;          ///< approximate number of particles in a picture; 0: by the size of the window
  std::optional<std::int64_t> at;   ///< step to show first
  std::string screenshot;           ///< PNG to write instead of opening a window that stays
  std::string frames;               ///< directory for a PNG of each frame
  std::optional<double> benchmark;  ///< duration for which the camera rotates, s
  std::string help;                 ///< if not empty: print this and exit 0

  bool live() const { return !listen.empty() || target.ends_with(".toml"); }
};

/// InputError for arguments that it does not understand.
ViewOptions parse_view_options(int argc, const char* const* argv);

}  // namespace trevi
