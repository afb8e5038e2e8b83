// The tables [[fountain]] of a scene, with their music, and what inlets share with them.
#pragma once

#include "scene/scene_reader.hpp"
#include "trevi/scene.hpp"

namespace trevi {

/// Adds a fountain to the scene, whose box and earlier fountains have been read; `box_known`: the box was valid.
void read_fountain(Section& section, Scene& scene, bool box_known);

/// Direction, speed, jitter and music of a fountain or an inlet.
void read_jet(Section& section, const Scene& scene, PumpSettings& pump);
/// The times between which it works.
void read_times(Section& section, PumpSettings& pump);

/// A path in the scene file, which is relative to its folder.
std::string beside_scene(const std::string& scene_path, const std::string& path);

}  // namespace trevi
