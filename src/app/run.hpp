// The program: from arguments and scene to a finished run and its report. Collective.
#pragma once

#include "trevi/error.hpp"
#include "trevi/session.hpp"

namespace trevi {

/// Throws InputError on all ranks alike, RunError on all ranks or on one (Error::reach).
ExitCode run(const Session& session, int argc, const char* const* argv);

/// Prints an error once and returns its exit code; a failure of a single rank takes all ranks down.
int report_error(const Error& error);

}  // namespace trevi
