// The table [[gauge]] of a scene.
#pragma once

#include "scene/free_places.hpp"
#include "scene/scene_reader.hpp"
#include "trevi/scene.hpp"

namespace trevi {

/// The spacing, the box and the obstacles have been read.
void read_gauge(Section& gauge, Scene& scene, bool box_known);

/// Checks what gauges need from other tables, when all have been read.
void check_gauges(Section& root, const Scene& scene);

/// Checks that pressure gauges are on a wall or an obstacle; once the obstacles' files have been read.
void check_gauge_places(const Scene& scene, const FreePlaces& places);

}  // namespace trevi
