// The tables [[particles]] of a scene.
#pragma once

#include "scene/scene_reader.hpp"
#include "trevi/scene.hpp"

namespace trevi {

/// A count (of steps, particles) above this is taken for a mistake; it would no longer be exact in a double.
inline constexpr Real max_counted = 1e15;

/// Adds one to the scene, whose box and spacing are read already.
void read_particle_source(Section& section, Scene& scene, const KnownGood& known);

}  // namespace trevi
