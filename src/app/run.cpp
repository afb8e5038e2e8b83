#include "app/run.hpp"

#include <fmt/format.h>

#include <cerrno>
#include <cstdio>

#include "app/build.hpp"
#include "app/launch.hpp"
#include "app/preflight/advice.hpp"
#include "app/preflight/dry_run.hpp"
#include "app/preflight/envelope.hpp"
#include "app/preflight/preview.hpp"
#include "app/preflight/run_cost.hpp"
#include "app/preflight/scene_picture.hpp"
#include "app/report.hpp"
#include "app/rescue.hpp"
#include "app/restart.hpp"
#include "base/simd.hpp"
#include "io/frames/blowup.hpp"
#include "io/frames/vtu.hpp"
#include "io/run_directory/files.hpp"
#include "io/run_directory/output_directory.hpp"
#include "io/writers.hpp"
#include "parallel/collective.hpp"
#include "parallel/log.hpp"
#include "parallel/reductions.hpp"

namespace trevi {

namespace {

void tell(const Session& session, const std::string& text) {
  if (session.rank() == 0) std::fprintf(stderr, "trevi: %s\n", text.c_str());
}

// Output that failed because of a full disk or a closed pipe must not look like success.
void flush_output(MPI_Comm comm) {
  on_root(comm, [] {
    if (std::fflush(stdout) != 0 || std::ferror(stdout) != 0) throw_file_error("standard output", "write", errno);
  });
}

void warn_at_the_end(const Session& session, const RunContext& context, const Solver& solver) {
  const Solver::Counters counters = solver.counters();
  if (counters.unconverged > 0) {
    tell(session,
         fmt::format("warning: {} of {} density solves missed density.tolerance; use more density.iterations or a "
                     "smaller dt",
                     counters.unconverged, counters.substeps));
  }
  for (const std::string& warning : crush_warnings(context.scene, counters.compression))
    tell(session, "warning: " + warning);
  for (const std::string& warning : flow_warnings(context.scene, solver.flow())) tell(session, "warning: " + warning);
  if (context.energy == nullptr) return;
  for (const std::string& warning : energy_warnings(context.scene, *context.energy))
    tell(session, "warning: " + warning);
}

// Reports crushed water, or inlets that make less than they should, when that begins; it is reported again at the end.
class Watch {
 public:
  Watch(const Session& session, const Scene& scene) : session_(session), scene_(scene) {}
  void look(const Solver& solver) {
    warn_once(told_crushed_, crush_warnings(scene_, solver.counters().compression));
    warn_once(told_flow_, flow_warnings(scene_, solver.flow()));
  }

 private:
  void warn_once(bool& told, const std::vector<std::string>& warnings) const {
    if (told || warnings.empty()) return;
    told = true;
    for (const std::string& warning : warnings) tell(session_, "warning: " + warning);
  }

  const Session& session_;
  const Scene& scene_;
  bool told_crushed_ = false, told_flow_ = false;
};

// Runs to the last step or until a stop is requested. A request after the last step has no effect.
Outcome run_steps(Solver& solver, std::int64_t last_step, bool restarted, Watch watch) {
  const ScopedStage stage("Solve");
  if (!restarted) solver.start();
  watch.look(solver);
  std::int64_t saves = 0;
  while (solver.clock().step < last_step) {
    solver.step();
    watch.look(solver);
    const RequestCounts& asked = solver.requests();
    const auto reason = solver.clock().step < last_step ? stop_reason(asked) : std::nullopt;
    if (reason || count_of(asked, Request::checkpoint) > saves) solver.save();
    saves = count_of(asked, Request::checkpoint);
    if (!reason) continue;
    solver.finish();
    return {ExitCode::stopped, "stopped: " + *reason};
  }
  solver.finish();
  return {};
}

// Where the traces of a failed run go: its folder, or, if that was removed, a new one with the last state.
std::string folder_for_traces(const Session& session, const RunContext& context, const Solver& solver,
                              std::string& told) {
  if (context.lock == nullptr || !context.lock->lost()) return context.directory;
  const auto rescued = rescue_state(session, context.info, solver, context.directory);
  told = rescued
             ? fmt::format(
                   "\nthe folder {} is gone; the state of step {} is in {}; go on with --output {} --restart "
                   "latest",
                   context.directory, solver.clock().step, *rescued, *rescued)
             : fmt::format("\nthe folder {} is gone, and nowhere else could the state be written", context.directory);
  return rescued.value_or(context.directory);
}

// Saves what can be saved of a run that failed; a second failure (of the disk, say) must not hide the first.
std::string leave_traces(const Session& session, const RunContext& context, const Solver& solver, const RunError& error,
                         bool blown_up) {
  const Outcome outcome{ExitCode::run_failed, std::string("failed: ") + error.what()};
  std::string traces;
  try {
    if (error.reach() == Reach::one_rank) {
      write_last_words(context, solver, outcome);
      return traces;
    }
    if (blown_up) {
      const std::int64_t step = solver.clock().step + 1;
      traces = "\n" + write_blowup(session.comm(), context.directory, {step, solver.particles(), error.what()}) +
               " holds the particles; ParaView opens it as .hdf";
    }
    RunContext where = context;
    if (!blown_up) where.directory = folder_for_traces(session, context, solver, traces);
    write_report(session, where, solver, outcome);
  } catch (const Error& second) {
    if (std::string_view(second.what()) != error.what()) traces += std::string("\n") + second.what();
  }
  return traces;
}

Outcome run_guarded(const Session& session, const RunContext& context, Solver& solver, std::int64_t last_step) {
  try {
    const Outcome outcome = run_steps(solver, last_step, context.restarted, {session, context.scene});
    write_report(session, context, solver, outcome);
    return outcome;
  } catch (const BlowUp& error) {
    throw RunError(error.what() + leave_traces(session, context, solver, error, true), error.reach());
  } catch (const RunError& error) {
    throw RunError(error.what() + leave_traces(session, context, solver, error, false), error.reach());
  }
}

// The requests that this rank sees, including those of the viewer.
std::function<RequestCounts()> requests_of(RequestWatch& watch, std::shared_ptr<ViewerLink> viewer) {
  return [&watch, viewer = std::move(viewer)] {
    RequestCounts counts = watch.poll();
    if (viewer && viewer->wishes().stop) counts[static_cast<std::size_t>(Request::viewer)] = 1;
    return counts;
  };
}

std::shared_ptr<ViewerLink> connect_on_root(MPI_Comm comm, const std::string& address) {
  std::shared_ptr<ViewerLink> link;
  on_root(comm, [&] { link = connect_viewer(address); });
  return link;
}

// Whether a restart has steps to do. One to an earlier step is refused, because it would set newer output aside.
bool has_steps_left(const Restart& restart, const Scene& scene, const CommandLine& line) {
  if (!restart.state) return true;
  const std::int64_t step = restart.state->step, last = line.steps.value_or(scene.steps());
  if (last >= step) return last > step;
  const std::string at = restart.file + " is at step " + std::to_string(step) + " already; ";
  if (line.steps) throw InputError("--steps " + std::to_string(last) + ": " + at + "give a later step");
  throw InputError(scene.path + ": [time] end: the run ends at step " + std::to_string(last) + ", and " + at +
                   "give a later end, for example with --set time.end");
}

// The first messages of a run: everything that could lead to a refusal has been checked.
void announce(const Session& session, const RunContext& context, const Solver& solver, const std::string& restart) {
  const GlobalId particles = sum_over_ranks(session.comm(), solver.particles().size());
  if (session.rank() == 0) {
    std::fprintf(stderr, "trevi %s: %s, %s particles\n", TREVI_VERSION,
                 launch_text(context.launch, context.scene).c_str(), with_commas(particles).c_str());
  }
  if (!restart.empty()) tell(session, restart);
  for (const std::string& warning : start_warnings(context.scene)) tell(session, "warning: " + warning);
  if (context.restarted) return;  // reported before
  for (const std::string& warning : scene_advice(context.scene)) tell(session, "warning: " + warning);
  if (session.rank() != 0) return;
  for (const std::string& warning : volume_warnings(context.scene, static_cast<double>(particles)))
    tell(session, "warning: " + warning);
  const double bytes = output_bytes(context.scene, static_cast<double>(particles));
  for (const std::string& warning : disk_warnings(bytes, context.directory)) tell(session, "warning: " + warning);
}

ExitCode run_scene(const Session& session, const Scene& scene, const Launch& launch, const CommandLine& line,
                   const std::string& command) {
  BuildOptions options;
  options.directory = line.output.empty() ? scene.directory() : line.output;
  options.progress = line.progress;
  options.last_step = line.steps.value_or(scene.steps());
  OutputLock lock(session.comm(), options.directory);
  options.lock = &lock;
  options.info = checkpoint_info(session.comm(), scene);
  std::optional<Restart> restart = find_restart(session, scene, options.info, line.restart, options.directory);
  const bool goes_on = restart && restart->state;
  check_output_directory(session.comm(), options.directory, restart ? std::optional(restart->file) : std::nullopt);
  if (restart && !has_steps_left(*restart, scene, line)) {
    tell(session, restart->message);
    tell(session, "which is the last; nothing to do");
    return ExitCode::done;
  }
  if (goes_on) options.restart = std::move(restart->state);
  RequestWatch watch(session.comm(), {options.directory + "/stop", scene.wall_limit});
  options.viewed = !line.view.empty();
  if (options.viewed) options.viewer = connect_on_root(session.comm(), line.view);
  const std::shared_ptr<ViewerLink> viewer = options.viewer;
  options.requests = requests_of(watch, options.viewer);
  const std::shared_ptr<EnergyRise> energy = options.energy = make_energy_rise(scene);
  const RunContext context{scene, options.directory, goes_on ? options.restart->step : 0, goes_on, energy.get(), launch,
                           &lock, options.info};
  const std::int64_t last_step = options.last_step;
  const std::unique_ptr<Solver> solver = build_solver(session.comm(), scene, std::move(options));
  announce(session, context, *solver, restart ? restart->message : "");
  const Outcome outcome = run_guarded(session, context, *solver, last_step);
  warn_at_the_end(session, context, *solver);
  if (viewer && !viewer->trouble().empty()) tell(session, "warning: " + viewer->trouble());
  if (outcome.code == ExitCode::stopped) {
    watch.remove_stop_file();
    tell(session, outcome.reason + " at step " + std::to_string(solver->clock().step) + "; go on with\n" + command);
  }
  for (const std::string& option : session.unused_options()) {
    tell(session, "warning: " + option + " was not used; it is no option of the parts of PETSc that this run needs");
  }
  return outcome.code;
}

}  // namespace

ExitCode run(const Session& session, int argc, const char* const* argv) {
  const CommandLine line = parse_command_line(argc, argv);
  if (!line.help.empty()) {
    if (session.rank() == 0) std::fputs(line.help.c_str(), stdout);
    flush_output(session.comm());
    return ExitCode::done;
  }
  const Scene scene = read_scene(session.comm(), line.scene, line.overrides);
  if (!scene.instruction_set.empty()) use_instruction_set(scene.instruction_set);
  if (!line.preview.empty()) {
    write_preview(session, scene, {line.preview, line.steps.value_or(scene.steps())});
    return ExitCode::done;
  }
  if (needs_vtk(scene.output)) require_vtk();
  const Launch launch = use_threads(session, line.threads, scene);
  if (line.dry_run) {
    if (!line.picture.empty()) write_scene_picture(session, scene, line.picture);
    print_dry_run(session, scene, launch, line.output.empty() ? scene.directory() : line.output);
    flush_output(session.comm());
    return ExitCode::done;
  }
  return run_scene(session, scene, launch, line, restart_command(session, argc, argv));
}

int report_error(const Error& error) {
  const int rank = rank_of(MPI_COMM_WORLD);
  if (error.reach() == Reach::all_ranks) {
    if (rank == 0) std::fprintf(stderr, "trevi: %s\n", error.what());
    return static_cast<int>(error.code());
  }
  std::fprintf(stderr, "trevi: rank %d: %s\n", rank, error.what());
  MPI_Abort(MPI_COMM_WORLD, static_cast<int>(error.code()));
  return static_cast<int>(error.code());
}

}  // namespace trevi
