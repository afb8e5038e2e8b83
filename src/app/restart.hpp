// How a run continues: from which checkpoint, whether the scene still matches it, and the command that continues a
// stopped run. Collective: find_restart, whose InputErrors are thrown on all ranks alike.
#pragma once

#include <optional>
#include <string>

#include "io/hdf5/checkpoint.hpp"
#include "trevi/scene.hpp"
#include "trevi/session.hpp"

namespace trevi {

struct Restart {
  std::string file;                      ///< the checkpoint; where it would be, if there is none yet
  std::optional<CheckpointState> state;  ///< none: the run died before its first checkpoint and starts again
  std::string message;                   ///< what is about to happen, for the user
};

/// `wanted` is the argument of --restart: a file, "latest" (of `directory`), or empty for no restart. `now` is what
/// checkpoints of this run will record about it.
std::optional<Restart> find_restart(const Session& session, const Scene& scene, const CheckpointInfo& now,
                                    const std::string& wanted, const std::string& directory);

/// The command line of this run with --restart latest, ready to be pasted into a shell.
std::string restart_command(const Session& session, int argc, const char* const* argv);

}  // namespace trevi
