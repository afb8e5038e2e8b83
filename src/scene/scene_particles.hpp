// The tables [[particles]] of a scene.
#pragma once

#include "scene/scene_reader.hpp"
#include "trevi/scene.hpp"

namespace trevi {

/// A larger count (of steps, particles) is assumed to be a mistake; it would no longer be exact in a double.
inline constexpr Real max_counted = 1e15;

/// Adds one to the scene, whose box and spacing have already been read.
void read_particle_source(Section& section, Scene& scene, const KnownGood& known);

}  // namespace trevi
