// A picture of the initial state of a scene, before anything is computed: its box, water, obstacles, openings and
// gauges. Water is drawn as glass, so that objects in it are visible; for a vessel the far walls are visible.
// Collective.
#pragma once

#include <string>

#include "trevi/scene.hpp"
#include "trevi/session.hpp"

namespace trevi {

/// Writes a PNG file. InputError on all ranks alike for a name that is not that of a PNG file, for an existing file
/// that is not a PNG, and for a scene with more particles than a picture is worth.
void write_scene_picture(const Session& session, const Scene& scene, const std::string& file);

}  // namespace trevi
