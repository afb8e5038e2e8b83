// The arguments of the program, which its --help lists. The same on all ranks; not collective. Arguments of the form
// -word are passed to PETSc, with the value that follows them, unless --word is one of ours.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "io/run_directory/progress.hpp"

namespace trevi {

struct CommandLine {
  std::string scene;
  std::string output;                  ///< empty: what the scene says
  std::vector<std::string> overrides;  ///< table.key=value
  std::string restart;                 ///< a file, or "latest"; empty: none
  std::optional<std::int64_t> steps;   ///< total step count to stop at
  std::optional<int> threads;          ///< of each rank
  bool dry_run = false;
  std::string picture;  ///< file for a picture of the scene, with a dry run; empty: none
  std::string preview;  ///< file for the curves of the fountains, instead of a run; empty: none
  std::string view;     ///< HOST:PORT of a viewer that may watch the run; empty: none
  ProgressMode progress = ProgressMode::automatic;
  std::string help;  ///< if not empty: print this, the help or the version, and exit 0
};

/// Throws InputError with the usage line for arguments that it does not understand.
CommandLine parse_command_line(int argc, const char* const* argv);

}  // namespace trevi
