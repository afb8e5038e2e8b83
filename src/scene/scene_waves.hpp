// The tables [[wavemaker]] and [[damping]] of a scene.
#pragma once

#include <optional>

#include "scene/scene_reader.hpp"
#include "trevi/scene.hpp"

namespace trevi {

/// Adds the paddle to the obstacles. Box, fluid, water, gravity and the other obstacles have been read.
void read_wavemaker(Section& wavemaker, Scene& scene, const KnownGood& known);

/// The depth of the water at the start, m above the floor; none if a file or an expression determines where it is.
std::optional<Real> depth_of_water(const Scene& scene);

/// The box has been read.
void read_damping(Section& damping, Scene& scene, bool box_known);

}  // namespace trevi
