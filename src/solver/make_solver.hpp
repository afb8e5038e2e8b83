// make_solver() of trevi/solver.hpp for callers that know more than the settings say: that the pumps were made before,
// and what checkpoints tell of the run. Collective.
#pragma once

#include "io/hdf5/checkpoint.hpp"
#include "solver/make_flow.hpp"
#include "trevi/solver.hpp"

namespace trevi {

/// SolverExtras::flow is not read: `flow` was made with it. `info` is for checkpoints of settings.output, and without
/// a folder of no use.
std::unique_ptr<Solver> make_solver_with(MPI_Comm comm, const Settings& settings, Particles particles,
                                         SolverExtras extras, FlowParts flow, const CheckpointInfo& info);

}  // namespace trevi
