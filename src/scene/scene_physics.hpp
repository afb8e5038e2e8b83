// The tables of a scene that say what is simulated: box, fluid, particles, time, forces, filters, fountains.
// Problems go to the findings of `root`; what cannot be used keeps its default, so checks go on to the end.
#pragma once

#include "scene/scene_reader.hpp"
#include "trevi/scene.hpp"

namespace trevi {

/// `scene.path` is set: paths in a scene are resolved against its folder.
void read_physics(Section& root, Scene& scene);

}  // namespace trevi
