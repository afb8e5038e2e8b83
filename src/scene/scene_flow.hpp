// Fountains, inlets and drains of a scene with their music. Collective.
#pragma once

#include <optional>

#include "solver/make_flow.hpp"
#include "trevi/scene.hpp"

namespace trevi {

/// As make_flow() of a solver; InputErrors give the file and the line of the scene.
FlowParts make_scene_flow(MPI_Comm comm, const Scene& scene, std::optional<FlowState> state = std::nullopt);

}  // namespace trevi
