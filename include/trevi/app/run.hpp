// The program: arguments and scene to a finished run and its report. Collective.
#pragma once

#include "trevi/base/error.hpp"
#include "trevi/parallel/session.hpp"

namespace trevi {

/// Throws InputError on all ranks alike, RunError on any.
ExitCode run(const Session& session, int argc, const char* const* argv);

/// Prints an error once: bad input from rank 0 and returns its exit code; a failed run takes all ranks down.
int report_error(const Session& session, const Error& error);

}  // namespace trevi
