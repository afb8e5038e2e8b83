// Fountains, inlets and drains of a scene with their music, for a solver that may go on from a checkpoint. Collective.
#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "music/music.hpp"
#include "solver/inflow_outflow.hpp"
#include "trevi/scene.hpp"

namespace trevi {

/// As make_fountains() of trevi/scene.hpp; fountains that follow standard input share `live`.
std::vector<std::unique_ptr<Forcing>> make_fountains(MPI_Comm comm, const Scene& scene,
                                                     std::shared_ptr<LiveSound>& live);

/// As make_flow() of trevi/scene.hpp, with the state of a checkpoint.
std::shared_ptr<InflowOutflow> make_flow(MPI_Comm comm, const Scene& scene, std::optional<FlowState> state,
                                         std::shared_ptr<LiveSound>& live);

}  // namespace trevi
