// The tables [[fountain]] of a scene, with their music.
#pragma once

#include "app/scene_reader.hpp"
#include "trevi/scene.hpp"

namespace trevi {

/// Adds a fountain to the scene, whose box and fountains before it are read already; `box_known`: the box was good.
void read_fountain(Section& section, Scene& scene, bool box_known);

/// A path of the scene file, which is relative to its folder.
std::string beside_scene(const std::string& scene_path, const std::string& path);

}  // namespace trevi
