// The tables of a scene that determine what is simulated: box, fluid, particles, time, forces, filters, fountains.
// Problems go to the findings of `root`; invalid values keep their defaults, so that checks continue to the end.
#pragma once

#include "scene/scene_reader.hpp"
#include "trevi/scene.hpp"

namespace trevi {

/// `scene.path` is set: paths in a scene are resolved against its folder.
void read_physics(Section& root, Scene& scene);

}  // namespace trevi
