// What a run leaves when its folder was removed during the run: the state of its last step, in a folder that it
// reports. Collective.
#pragma once

#include <optional>
#include <string>

#include "io/hdf5/checkpoint.hpp"
#include "trevi/session.hpp"
#include "trevi/solver.hpp"

namespace trevi {

/// Writes a checkpoint into a new folder: beside `lost`, in the working directory or among the temporary files,
/// whichever is possible first. Returns its name; nothing if none is possible.
std::optional<std::string> rescue_state(const Session& session, const CheckpointInfo& info, const Solver& solver,
                                        const std::string& lost);

}  // namespace trevi
