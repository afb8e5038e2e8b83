// The table [[body]] of a scene. Nothing is read but the scene: meshes are read by obstacle_files.hpp.
#pragma once

#include "scene/scene_reader.hpp"
#include "trevi/scene.hpp"

namespace trevi {

void read_body(Section& section, Scene& scene);
/// Rules between bodies and other tables.
void check_bodies(Section& root, const Scene& scene);
/// Checks of bodies whose meshes have been read: that they are in the box, and not inside each other. InputError.
void check_body_places(const Scene& scene);

}  // namespace trevi
