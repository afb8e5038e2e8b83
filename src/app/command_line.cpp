#include "app/command_line.hpp"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <cctype>

#include "app/launch.hpp"
#include "base/threads.hpp"
#include "trevi/error.hpp"
#include "trevi/scene.hpp"

namespace trevi {

namespace {

bool is_petsc_option(const std::string& argument) {
  return argument.size() > 2 && argument[0] == '-' && std::isalpha(static_cast<unsigned char>(argument[1])) != 0;
}

std::string refuse_empty(const std::string& text) { return text.empty() ? "must not be empty" : ""; }

// CLI11's own conversion of numbers saturates, and its messages print the limits of a range with 309 digits.
std::string refuse_step(const std::string& text) {
  const bool digits = text.find_first_not_of("0123456789") == std::string::npos;
  return digits && !text.empty() && text.size() <= 15 ? "" : "must be a whole number from 0 to 999999999999999";
}

std::string refuse_threads(const std::string& text) {
  return whole_threads(text) ? "" : fmt::format("must be a whole number from 1 to {}", max_threads);
}

// A mistyped -steps would otherwise be passed to PETSc and silently ignored.
void refuse_single_dash(const CLI::App& app, int argc, const char* const* argv) {
  for (int k = 1; k < argc; ++k) {
    const std::string argument = argv[k];
    const std::string meant = "-" + argument.substr(0, argument.find('='));
    if (is_petsc_option(argument) && meant != "--help" && app.get_option_no_throw(meant) != nullptr) {
      throw InputError(fmt::format("{0}: did you mean -{0}? A single dash is for options of PETSc", argument));
    }
    if (argument == "-np" || argument == "-n") {
      throw InputError(fmt::format(
          "{0}: the number of ranks is for mpirun, before the program: mpirun {0} 2 trevi SCENE.toml", argument));
    }
  }
}

// The arguments without PETSc's options and their values; in reverse order, as CLI11 expects them.
std::vector<std::string> own_arguments(int argc, const char* const* argv) {
  std::vector<std::string> own;
  for (int k = 1; k < argc; ++k) {
    if (!is_petsc_option(argv[k])) {
      own.emplace_back(argv[k]);
    } else if (k + 1 < argc && argv[k + 1][0] != '-') {
      ++k;
    }
  }
  return {own.rbegin(), own.rend()};
}

void add_options(CLI::App& app, CommandLine& line) {
  app.add_option("scene", line.scene, "scene file (.toml)")->required();
  app.add_option("--output", line.output, "output directory, in place of the scene's")->check(refuse_empty);
  app.add_option("--set", line.overrides, "table.key=value, in place of the scene's value; repeatable")
      ->expected(1)
      ->take_all()
      ->allow_extra_args(false);  // otherwise it takes a scene that follows it
  app.add_option("--restart", line.restart, "go on from a checkpoint: a file, or latest")->check(refuse_empty);
  app.add_option("--steps", line.steps, "stop when the run's total step count is this, before or past time.end")
      ->check(refuse_step);
  app.add_option("--threads", line.threads,
                 "threads of each rank; default [run] threads, OMP_NUM_THREADS, or as many as there are cores for it")
      ->check(refuse_threads);
  app.add_flag("--dry-run", line.dry_run, "check the scene, print what the run would need, write nothing");
  CLI::Option* const dry_run = app.get_option("--dry-run");
  app.add_option("--picture", line.picture, "with --dry-run: draw the scene as it begins into this .png file")
      ->check(refuse_empty)
      ->needs(dry_run);
  app.add_option("--preview", line.preview, "write the curves of the fountains to this .csv file, and do not run")
      ->check(refuse_empty);
  app.add_option("--view", line.view, "let trevi-view --listen HOST:PORT watch and steer the run")->check(refuse_empty);
  app.add_option("--progress", line.progress, "auto, bar, lines or none")
      ->transform(CLI::CheckedTransformer(std::map<std::string, ProgressMode>{{"auto", ProgressMode::automatic},
                                                                              {"bar", ProgressMode::bar},
                                                                              {"lines", ProgressMode::lines},
                                                                              {"none", ProgressMode::none}}));
  app.set_version_flag("--version", std::string("trevi ") + TREVI_VERSION);
}

}  // namespace

CommandLine parse_command_line(int argc, const char* const* argv) {
  CommandLine line;
  CLI::App app("Trevi: water by position based fluids, on any number of MPI ranks.", "trevi");
  app.footer(
      "PETSc options such as -log_view may follow the scene.\nDefaults, definitions and formats are in "
      "inputs/README.md. "
      "In short: a box is at least one kernel radius wide (two\nspacings); domain.dimensions = 2 is a layer; a "
      "score has lines \"time pitch length\", such as 0.5 C4 0.25;\nparticle files are HDF5 with /particles/position "
      "(N "
      "x 3), velocity (N x 3) and id (N).\n\nKeys of a scene:\n" +
      scene_reference());
  add_options(app, line);
  refuse_single_dash(app, argc, argv);
  try {
    app.parse(own_arguments(argc, argv));
  } catch (const CLI::CallForHelp&) {
    line.help = app.help();
  } catch (const CLI::CallForVersion& version) {
    line.help = std::string(version.what()) + "\n";
  } catch (const CLI::ParseError& error) {
    throw InputError(std::string(error.what()) +
                     "\nusage: trevi SCENE.toml [--output DIR] [--set table.key=value ...] "
                     "[--restart FILE|latest] [--steps N] [--threads N] [--dry-run [--picture FILE.png]] [--preview "
                     "FILE.csv] [--view HOST:PORT] "
                     "[--progress auto|bar|lines|none] [PETSc options]; "
                     "--help lists all scene keys");
  }
  return line;
}

}  // namespace trevi
