// run.json of a run: totals over ranks of time, work, traffic and memory. Collective.
#pragma once

#include <string>

#include "trevi/app/scene.hpp"
#include "trevi/parallel/session.hpp"
#include "trevi/solver/solver.hpp"

namespace trevi {

struct RunContext {
  const Scene& scene;
  std::string directory;
  std::int64_t first_step = 0;
};

void write_report(const Session& session, const RunContext& context, const Solver& solver,
                  const std::string& exit_reason);

}  // namespace trevi
