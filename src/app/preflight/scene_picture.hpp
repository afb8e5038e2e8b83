// A picture of a scene as it begins, before anything is computed: its box, water, obstacles, openings and gauges. Water
// is glass, so that one sees what stands in it; of a vessel one sees the far walls. Collective.
#pragma once

#include <string>

#include "trevi/scene.hpp"
#include "trevi/session.hpp"

namespace trevi {

/// Writes a PNG file. InputError on all ranks alike for a name that is not one of those, for a file that is there and
/// is no PNG, and for a scene of more particles than a picture is worth.
void write_scene_picture(const Session& session, const Scene& scene, const std::string& file);

}  // namespace trevi
