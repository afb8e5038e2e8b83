// run.json of a run: totals over ranks of time, work, traffic and memory, and how it ended.
#pragma once

#include <string>

#include "app/launch.hpp"
#include "base/energy.hpp"
#include "io/hdf5/checkpoint.hpp"
#include "io/run_directory/output_lock.hpp"
#include "io/tables/energy_rise.hpp"
#include "trevi/error.hpp"
#include "trevi/scene.hpp"
#include "trevi/session.hpp"
#include "trevi/solver.hpp"

namespace trevi {

struct RunContext {
  const Scene& scene;
  std::string directory;
  std::int64_t first_step = 0;
  bool restarted = false;
  const EnergyRise* energy = nullptr;  ///< null without a series
  Launch launch = {};
  const OutputLock* lock = nullptr;  ///< on the directory
  CheckpointInfo info = {};          ///< for the state of a run whose directory is lost
  EnergyMeter meter{"/sys/class/powercap"};
};

struct Outcome {
  ExitCode code = ExitCode::done;
  std::string reason = "done";  ///< "stopped: SIGUSR2", "failed: ...", for run.json
};

/// Collective.
void write_report(const Session& session, const RunContext& context, const Solver& solver, const Outcome& outcome);

/// The part of the report that one rank knows, for use when it fails alone and cannot communicate. Not collective.
void write_last_words(const RunContext& context, const Solver& solver, const Outcome& outcome);

}  // namespace trevi
