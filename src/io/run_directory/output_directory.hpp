// The folder of a run: created if missing, and refused if it holds another run, because nothing is overwritten unasked.
// A restart may continue in the folder that holds its checkpoint, or begin in one without a run. Collective; every
// error is thrown on all ranks alike.
#pragma once

#include <optional>
#include <string>

#include "trevi/session.hpp"

namespace trevi {

/// Writes nothing. InputError if the folder holds a run that `restart_file` is not part of, or a forgotten stop file.
void check_output_directory(MPI_Comm comm, const std::string& directory,
                            const std::optional<std::string>& restart_file);

/// To be called once all input has been found valid. RunError if the folder cannot be created.
void make_output_directory(MPI_Comm comm, const std::string& directory);

/// Whether a run in this folder would lose nothing by starting again: there is none, or it died before its first
/// checkpoint and has written nothing past step 0.
bool is_before_first_checkpoint(MPI_Comm comm, const std::string& directory);

}  // namespace trevi
