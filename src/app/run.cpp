#include "trevi/app/run.hpp"

#include <unistd.h>

#include <cstdio>

#include "trevi/app/build.hpp"
#include "trevi/app/dry_run.hpp"
#include "trevi/app/preview.hpp"
#include "trevi/app/report.hpp"
#include "trevi/output/output_directory.hpp"
#include "trevi/output/run_report.hpp"

namespace trevi {

namespace {

// The checkpoint to go on from, if any: its file and what it holds.
struct Restart {
  std::string file;
  CheckpointState state;
};

std::optional<Restart> find_restart(const Session& session, const CommandLine& line, const std::string& directory) {
  if (line.restart.empty()) return std::nullopt;
  const std::string file = line.restart == "latest" ? latest_checkpoint(session.comm(), directory) : line.restart;
  return Restart{file, read_checkpoint(session.comm(), file)};
}

void run_steps(Solver& solver, std::int64_t last_step, bool restarted) {
  const ScopedStage stage("Solve");
  if (!restarted) solver.start();
  while (solver.clock().step < last_step) solver.step();
  solver.finish();
}

}  // namespace

ExitCode run(const Session& session, int argc, const char* const* argv) {
  const CommandLine line = parse_command_line(argc, argv);
  if (!line.help.empty()) {
    if (session.rank() == 0) std::fputs(line.help.c_str(), stdout);
    return ExitCode::done;
  }
  const Scene scene = parse_scene(line.scene, read_file_everywhere(session.comm(), line.scene), line.overrides);
  BuildOptions options;
  options.directory = line.output.empty() ? scene.output.directory : line.output;
  options.progress = line.progress;
  options.last_step = line.steps.value_or(scene.steps());
  if (!line.preview.empty()) {
    write_preview(session, scene, {line.preview, options.last_step});
    return ExitCode::done;
  }
  if (line.dry_run) {
    print_dry_run(session, scene, options.directory);
    return ExitCode::done;
  }
  std::optional<Restart> restart = find_restart(session, line, options.directory);
  check_output_directory(session.comm(), options.directory, restart ? std::optional(restart->file) : std::nullopt);
  if (restart) options.restart = std::move(restart->state);
  RunContext context{scene, options.directory, options.restart ? options.restart->step : 0};
  const std::int64_t last_step = options.last_step;
  const bool restarted = options.restart.has_value();
  const std::unique_ptr<Solver> solver = build_solver(session.comm(), scene, std::move(options));
  run_steps(*solver, last_step, restarted);
  write_report(session, context, *solver, "done");
  return ExitCode::done;
}

int report_error(const Session& session, const Error& error) {
  if (error.code() == ExitCode::bad_input) {
    if (session.rank() == 0) std::fprintf(stderr, "trevi: %s\n", error.what());
    return static_cast<int>(error.code());
  }
  // Most failures strike all ranks alike; a moment's patience lets rank 0 speak for them.
  if (session.rank() != 0) usleep(300000);
  std::fprintf(stderr, "trevi: %s\n", error.what());
  MPI_Abort(session.comm(), static_cast<int>(error.code()));
  return static_cast<int>(error.code());
}

}  // namespace trevi
