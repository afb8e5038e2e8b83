#include "app/report.hpp"

#include <petscsys.h>
#include <sys/resource.h>

#include <algorithm>
#include <filesystem>
#include <string_view>
#include <system_error>

#include "app/placement.hpp"
#include "app/preflight/envelope.hpp"
#include "base/simd.hpp"
#include "io/frames/vtu.hpp"
#include "io/hdf5/hdf5_rows.hpp"
#include "io/run_directory/run_report.hpp"
#include "parallel/log.hpp"
#include "parallel/reductions.hpp"

namespace trevi {

namespace {

double sum_real(MPI_Comm comm, double value) {
  MPI_Allreduce(MPI_IN_PLACE, &value, 1, MPI_DOUBLE, MPI_SUM, comm);
  return value;
}

std::vector<PhaseReport> phases(MPI_Comm comm) {
  std::vector<PhaseReport> reports;
  for (const EventTotals& event : event_totals()) {
    PhaseReport report;
    report.name = event.name;
    report.seconds_min = min_over_ranks(comm, event.seconds);
    report.seconds_mean = sum_real(comm, event.seconds) / size_of(comm);
    report.seconds_max = max_over_ranks(comm, event.seconds);
    report.calls = event.calls;
    report.flops = sum_real(comm, event.flops);
    report.bytes = sum_real(comm, event.bytes);
    if (report.calls > 0) reports.push_back(report);
  }
  return reports;
}

std::vector<double> of_each_rank(MPI_Comm comm, double mine) {
  std::vector<double> all(static_cast<std::size_t>(size_of(comm)));
  MPI_Allgather(&mine, 1, MPI_DOUBLE, all.data(), 1, MPI_DOUBLE, comm);
  return all;
}

RunReport::Versions versions() {
  char mpi[MPI_MAX_LIBRARY_VERSION_STRING] = {};
  int length = 0;
  MPI_Get_library_version(mpi, &length);
  std::string name = std::string(mpi).substr(0, std::string_view(mpi).find_first_of(",\n"));  // then how it was built
  std::replace(name.begin(), name.end(), '\t', ' ');
  const std::string petsc = std::to_string(PETSC_VERSION_MAJOR) + "." + std::to_string(PETSC_VERSION_MINOR) + "." +
                            std::to_string(PETSC_VERSION_SUBMINOR);
  return {TREVI_VERSION, name, petsc, hdf5_version(), vtk_version()};
}

double resident_bytes() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  return static_cast<double>(usage.ru_maxrss) * 1024;
}

// The events in which the solver makes the passes over pairs that it counts.
double pair_seconds(const std::vector<PhaseReport>& phases) {
  double seconds = 0;
  for (const PhaseReport& phase : phases) {
    if (phase.name == "Lambda" || phase.name == "Delta") seconds += phase.seconds_mean;
  }
  return seconds;
}

// All warnings of the run, those of the start first.
std::vector<std::string> all_warnings(const RunContext& context, const Solver& solver) {
  std::vector<std::string> all = start_warnings(context.scene);
  const auto add = [&](std::vector<std::string> more) { std::move(more.begin(), more.end(), std::back_inserter(all)); };
  if (context.energy != nullptr) add(energy_warnings(context.scene, *context.energy));
  add(crush_warnings(context.scene, solver.counters().compression));
  add(flow_warnings(context.scene, solver.flow()));
  return all;
}

RunReport local_report(const RunContext& context, const Solver& solver, const Outcome& outcome) {
  RunReport report;
  report.exit_reason = outcome.reason;
  report.exit_code = static_cast<int>(outcome.code);
  report.ranks = context.launch.ranks;
  report.threads = context.launch.threads_max;
  report.threads_min = context.launch.threads_min;
  report.versions = versions();
  std::error_code ignored;  // a working directory that no longer exists
  report.scene = std::filesystem::absolute(context.scene.path, ignored).lexically_normal().string();
  if (report.scene.empty()) report.scene = context.scene.path;
  report.domain = context.scene.domain;
  report.spacing = context.scene.fluid.spacing;
  report.rest_density = context.scene.fluid.rest_density;
  report.scene_hash = scene_hash(context.scene.text);
  report.warnings = all_warnings(context, solver);
  if (context.energy != nullptr) {
    report.energy_gain = context.energy->fraction();
    report.motion_gain = context.energy->fraction_of_motion();
  }
  report.instruction_set = instruction_set_name();
  report.precision = context.scene.density.precision == Precision::single ? "single" : "double";
  report.first_step = context.first_step;
  report.last_step = solver.clock().step;
  report.steps = report.last_step - report.first_step;
  const Solver::Counters counters = solver.counters();
  report.unconverged_solves = counters.unconverged;
  report.compression_largest = counters.compression.largest;
  report.crushed_step = counters.compression.first_crushed;
  if (solver.flow() != nullptr) {
    for (const FlowState::Stream& stream : solver.flow()->streams)
      report.inlets.push_back({stream.asked(), stream.made, stream.covered, stream.blocked, stream.dry});
  }
  report.simulated_seconds = static_cast<double>(report.steps) * solver.clock().dt;
  return report;
}

}  // namespace

void write_report(const Session& session, const RunContext& context, const Solver& solver, const Outcome& outcome) {
  const MPI_Comm comm = session.comm();
  const Solver::Counters counters = solver.counters();
  RunReport report = local_report(context, solver, outcome);
  report.particles = sum_over_ranks(comm, solver.particles().size());
  report.wall_seconds = max_over_ranks(comm, counters.seconds);
  report.phases = phases(comm);
  const auto steps = static_cast<double>(report.steps), particles = static_cast<double>(report.particles);
  report.steps_per_second = steps / report.wall_seconds;
  report.particle_steps_per_second = particles * steps / report.wall_seconds;
  report.nanoseconds_per_pair =
      1e9 * pair_seconds(report.phases) * session.size() / sum_real(comm, counters.pair_passes);
  report.halo_bytes_per_step = sum_real(comm, static_cast<double>(counters.halo_bytes)) / steps;
  report.halo_messages_per_step = sum_real(comm, static_cast<double>(counters.halo_messages)) / steps;
  report.step_seconds = of_each_rank(comm, counters.seconds);
  report.waiting_seconds = of_each_rank(comm, counters.waiting_seconds);
  report.halo_wait_seconds = of_each_rank(comm, event_seconds("HaloWait"));
  report.reduction_seconds = of_each_rank(comm, counters.reduction_seconds);
  const Solver::Counters::Balance& balance = counters.balance;
  report.imbalance_mean = balance.looks > 0 ? balance.sum / static_cast<double>(balance.looks) : 1;
  report.imbalance_max = balance.max;
  report.cut_moves = balance.moves;
  report.bytes_per_particle = sum_real(comm, static_cast<double>(counters.bytes)) / particles;
  report.max_resident_bytes = max_over_ranks(comm, resident_bytes());
  report.energy_joules = joules_of_hosts(session, context.meter);
  report.hosts = hosts_of(session);
  write_run_report(comm, context.directory, report);
}

void write_last_words(const RunContext& context, const Solver& solver, const Outcome& outcome) {
  RunReport report = local_report(context, solver, outcome);
  report.wall_seconds = solver.counters().seconds;
  write_run_report(MPI_COMM_SELF, context.directory, report);
}

}  // namespace trevi
