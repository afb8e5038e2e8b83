// Makes a failure on one rank known to all, because a rank that throws alone leaves the others waiting for ever. `work`
// must not communicate, or only in a way that every rank completes whatever happens on another. Collective: every
// function here. The error of the lowest failing rank is thrown on all ranks, with its original type: InputError,
// DamagedFile or RunError.
#pragma once

#include <functional>
#include <string>

#include "trevi/session.hpp"

namespace trevi {

/// Runs `work` on every rank; throws on all ranks alike if it threw on any (InputError or RunError).
void all_or_none(MPI_Comm comm, const std::function<void()>& work);

/// Runs `work` on rank 0 only; throws on all ranks alike if it threw there.
void on_root(MPI_Comm comm, const std::function<void()>& work);

/// The text of the lowest rank whose text is not empty; empty if all are.
std::string first_text(MPI_Comm comm, const std::string& mine);

}  // namespace trevi
