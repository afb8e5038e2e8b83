// make_solver() of trevi/solver.hpp for callers that have more than the settings: pumps that were made before, and the
// information about the run for checkpoints. Collective.
#pragma once

#include "io/hdf5/checkpoint.hpp"
#include "solver/make_flow.hpp"
#include "trevi/solver.hpp"

namespace trevi {

/// SolverExtras::flow is not read, because `flow` was made with it. `info` is for checkpoints of settings.output and is
/// not used without a folder.
std::unique_ptr<Solver> make_solver_with(MPI_Comm comm, const Settings& settings, Particles particles,
                                         SolverExtras extras, FlowParts flow, const CheckpointInfo& info);

}  // namespace trevi
